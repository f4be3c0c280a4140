"""The explorer `joint` among the noise of the vehicle: noise is whitened away, and what it votes for is left out.

Bins vote as in `joint`, by `weighted_itd_in_noise`. Noise is not all Gaussian: some of its loud bins vote for the
rotors all the same. How many per second a lead-in tells, in which nobody talks; where the rotors stand in the
histograms of another heading follows from their places. That many votes are taken from every histogram: what stands
where the rotors are is a talker only as far as it votes more than they did.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ross_payload.dsp.density import histogram, histograms, itd_grid, kde, prominent_peaks
from ross_payload.dsp.ego_noise import EgoNoise, learnt
from ross_payload.dsp.itd import Trust, band_limits
from ross_payload.dsp.itd_in_noise import weighted_itd_in_noise
from ross_payload.dsp.rotors import Rotors, heard_from
from ross_payload.interfaces import Complex, Marks, Observation, Real
from ross_payload.localization.joint import BANDWIDTH
from ross_payload.localization.sectors import Histograms
from ross_payload.localization.talker_evidence import BLOCK, Among

WIDTH = 0.1  # of the votes for a rotor [d / v_p]
RICH = Trust(neighbourhood=(3, 3), coherence=0.9, floor=3.0)  # wide: hardly any noise agrees so far
STRICT = Trust(neighbourhood=(3, 3), coherence=0.92)
OVER = 2.0  # times the votes of the lead-in are left out: the throttle moves
COUNTS = 3.0  # that a vote is worth of one in `joint`: they are fewer


@dataclass(frozen=True, slots=True)
class Votes:
    """What noise votes for per second: for the rotors, and for any ITD alike."""

    rotors: float
    anywhere: float

    @classmethod
    def of(cls, counts: Real, rotors: Real | None, seconds: float) -> Votes:
        """Share the counts (n_bins,) of a lead-in between the rotors, given as where they vote, and anywhere."""
        total = float(counts.sum()) / seconds
        if rotors is None:
            return cls(0.0, total)
        off = rotors - 1 / rotors.size
        share = float(((counts / seconds - total / rotors.size) * off).sum() / max(float((off**2).sum()), 1e-12))
        share = min(max(share, 0.0), total)
        return cls(share, total - share)

    def over(self, rotors: Real | None, n_bins: int) -> Real:
        """Per second and bin of a histogram, (n_bins,)."""
        even = np.full(n_bins, self.anywhere / n_bins)
        return even if rotors is None else even + self.rotors * rotors


@dataclass(frozen=True, slots=True)
class Learnt:
    """What is known of the noise: its covariance, and what it votes for in either histogram."""

    noise: EgoNoise
    rich: Votes
    strict: Votes


@dataclass(frozen=True, slots=True)
class JointInNoise:
    """Observes for the explorer `joint` where the vehicle makes noise."""

    spacing: float
    speed_of_sound: float

    def learn(
        self,
        lead_in: Complex,
        frequencies: Real,
        period: float,
        aboard: float,
        rotors: Rotors | None,
        *,
        tonal: Marks | None = None,
    ) -> Learnt | None:
        """What a lead-in (2, n_freqs, n_frames), heard at ``aboard`` [rad], tells; None: the noise is white.

        ``aboard`` is the heading of the array in the frame of the vehicle; ``tonal`` as of `observe`.
        """
        noise = learnt(lead_in, frequencies, period, aboard, rotors)
        if noise is None or not self._band(frequencies).any():
            return None
        blocks, strict = self._histograms(lead_in, frequencies, aboard, noise, period, tonal=tonal)
        seconds, there = lead_in.shape[-1] * period, self._rotors(noise, aboard)
        return Learnt(noise, Votes.of(blocks.sum(axis=0), there, seconds), Votes.of(strict, there, seconds))

    def observe(
        self,
        spectrogram: Complex,
        frequencies: Real,
        heading: float,
        aboard: float,
        known: Learnt,
        *,
        period: float,
        tonal: Marks | None = None,
    ) -> Observation:
        """Condense one orientation as `Joint.observe` does, for its `estimate`.

        Parameters
        ----------
        spectrogram
            (2, n_freqs, n_frames), heard at one heading.
        frequencies
            [Hz].
        heading, aboard
            Of the array [rad], in the frame of the azimuths and in that of the vehicle.
        known
            From `learn`.
        period
            Time between frames [s].
        tonal
            Where tones of the rotors are, (n_freqs, n_frames): these bins do not vote. None: nobody knows.
        """
        grid = itd_grid(self.spacing, self.speed_of_sound)
        if not spectrogram.shape[-1]:
            nothing = np.zeros_like(grid)
            return Observation(heading, grid, nothing, 0.0, (), Histograms(np.zeros((0, len(grid))), nothing))
        blocks, strict = self._histograms(spectrogram, frequencies, aboard, known.noise, period, tonal=tonal)
        seconds, there = spectrogram.shape[-1] * period, self._rotors(known.noise, aboard)
        rich = blocks.sum(axis=0)
        left = COUNTS * np.maximum(rich - OVER * seconds * known.rich.over(there, len(grid)), 0)
        blocks = blocks * (left / np.maximum(rich, 1e-12))
        strict = COUNTS * np.maximum(strict - OVER * seconds * known.strict.over(there, len(grid)), 0)
        kept = min(float(left.sum() / COUNTS / max(float(rich.sum()), 1e-12)), 1.0)
        among = Among(_phasors(known.noise, heading - aboard), kept)
        density = kde(left, grid, BANDWIDTH * self.spacing / self.speed_of_sound)
        peaks = prominent_peaks(density, grid)
        return Observation(heading, grid, density, float(left.sum()), peaks, Histograms(blocks, strict, among))

    def _histograms(
        self,
        spectrogram: Complex,
        frequencies: Real,
        aboard: float,
        noise: EgoNoise,
        period: float,
        *,
        tonal: Marks | None,
    ) -> tuple[Real, Real]:
        """Votes of every block of time (n_blocks, n_bins), and the strict ones (n_bins,)."""
        band = self._band(frequencies)
        grid = itd_grid(self.spacing, self.speed_of_sound)
        field = noise.field(spectrogram, frequencies, period, aboard, tonal)[band]
        floor = (RICH.floor * noise.outliers**2)[band]
        heard = np.ones((1, 1)) if tonal is None else ~tonal[band]
        found = (
            weighted_itd_in_noise(spectrogram[:, band], frequencies[band], period, field, floor=floor, trust=trust)
            for trust in (RICH, STRICT)
        )
        rich, strict = ((itd, weight * heard) for itd, weight in found)
        return histograms(*rich, grid, max(round(BLOCK / period), 1)), histogram(*strict, grid)

    def _band(self, frequencies: Real) -> Real:
        low, high = band_limits(self.spacing, self.speed_of_sound)
        return np.asarray((frequencies >= low) & (frequencies <= high))

    def _rotors(self, noise: EgoNoise, aboard: float) -> Real | None:
        """Where the rotors vote; None when their places are not known."""
        if noise.rotors is None:
            return None
        unit = self.spacing / self.speed_of_sound
        return heard_from(noise.rotors, itd_grid(self.spacing, self.speed_of_sound), aboard, WIDTH * unit)


def _phasors(noise: EgoNoise, turned: float) -> tuple[complex, ...]:
    """Where rotors may be taken for talkers: nowhere in wind, which drowns them."""
    if noise.rotors is None or noise.gusty:
        return ()
    return tuple(complex(phasor) for phasor in noise.rotors.phasors(turned))
