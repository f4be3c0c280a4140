"""Where the rotors of the vehicle are, and what the array hears of them at a heading.

They are fixed to the vehicle and near: waves are spherical, and the delay to either microphone follows from its exact
distance. In the frame of the array the rotors move as it turns.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ross_payload.dsp.covariance import ROOT2
from ross_payload.interfaces import Complex, Real


@dataclass(frozen=True, slots=True)
class Rotors:
    """Where the rotors are: ahead, to the left and above the centre of the array [m], frame of the vehicle."""

    places: tuple[tuple[float, float, float], ...]
    spacing: float  # d [m]
    speed_of_sound: float  # v_p [m/s]

    def delays(self, heading: float) -> Real:
        """TDOA of every rotor at a heading in the frame of the vehicle [s], > 0 when microphone 2 leads, (n,).

        >>> rotors = Rotors(((0.343, 0.0, 0.0), (0.0, 0.343, 0.0)), 0.0343, 343.0)
        >>> np.abs(rotors.delays(0.0) - [1e-4, 0.0]).max() < 1e-9
        np.True_
        """
        first, second = self._distances(heading)
        return np.asarray((first - second) / self.speed_of_sound)

    def phasors(self, turned: float = 0.0) -> Complex:
        """Every rotor as a far source of the same delays, cos(elevation) exp(j azimuth), (n,).

        The vehicle has ``turned`` [rad]: azimuths are in the frame of the headings.

        >>> np.abs(Rotors(((1.0, 0.0, 0.0),), 0.05, 343.0).phasors(np.pi / 2) - 1j).max() < 1e-9
        np.True_
        """
        ahead, left, above = np.reshape(self.places, (-1, 3)).T
        return np.asarray((ahead + 1j * left) / np.sqrt(ahead**2 + left**2 + above**2) * np.exp(1j * turned))

    def shape(self, frequencies: Real, heading: float, directed: Real) -> Real:
        """Covariance of noise of which a share (n_freqs,) comes from the rotors, all alike; trace 2, (n_freqs, 4)."""
        first, second = self._distances(heading)
        one, two, both = first**-2.0, second**-2.0, 1 / (first * second)
        scale = 2 / (one + two).sum()
        phase = 2 * np.pi * frequencies[:, None] * (first - second) / self.speed_of_sound
        real, imag = (both * np.cos(phase)).sum(axis=1), -(both * np.sin(phase)).sum(axis=1)
        ones = np.ones(len(frequencies))
        rotors = scale * np.stack([one.sum() * ones, two.sum() * ones, ROOT2 * real, ROOT2 * imag], axis=1)
        white = np.array([1.0, 1.0, 0.0, 0.0])
        return np.asarray(directed[:, None] * rotors + (1 - directed[:, None]) * white, dtype=np.float32)

    def _distances(self, heading: float) -> tuple[Real, Real]:
        along = 0.5 * self.spacing * np.array([np.cos(heading), np.sin(heading), 0.0])
        places = np.reshape(self.places, (-1, 3))
        return np.linalg.norm(places + along, axis=1), np.linalg.norm(places - along, axis=1)


def heard_from(rotors: Rotors, grid: Real, heading: float, width: float) -> Real:
    """Where on a grid of ITDs [s] the rotors vote at a heading of the vehicle, all alike; sums to 1, (n_bins,)."""
    kernels = np.exp(-0.5 * ((grid - rotors.delays(heading)[:, None]) / width) ** 2)
    return np.asarray(kernels.sum(axis=0) / kernels.sum())
