"""What stands near the array in the open: spherical waves, with the exact distance to either microphone."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ross_payload.interfaces import Real, Samples

SINC = 81  # taps of a fractional delay; every response starts SINC // 2 samples late, as those of rooms do
NEAREST = 0.05  # [m] from a microphone: nothing comes nearer


@dataclass(frozen=True, slots=True)
class NearField:
    """Impulse responses of point sources without walls, at any heading of the array.

    The delay of a source r away is r / v_p and its amplitude 1 / (4 pi r), for either microphone on its own: the waves
    are spherical, and the nearer microphone hears more.

    Parameters
    ----------
    places
        Of the sources in the frame in which headings are given, the centre of the array being (0, 0, 0) [m].
    delayed
        False leaves out the delay from a source to the centre of the array, and keeps that between microphones.
    """

    places: tuple[tuple[float, float, float], ...]
    spacing: float  # d [m]
    rate: int  # [Hz]
    speed_of_sound: float  # v_p [m/s]
    delayed: bool = True

    @property
    def n_taps(self) -> int:
        """Length of every response."""
        reach = max((math.hypot(*place) for place in self.places), default=0.0) * self.delayed + self.spacing
        return math.ceil(reach / self.speed_of_sound * self.rate) + SINC + 1

    def at(self, heading: float) -> Samples:
        """Return the responses at a heading [rad], (2, n_sources, n_taps).

        A source 0.343 m ahead on the axis is 0.035 m nearer to microphone 2, which is 5 samples at 49 kHz:

        >>> near = NearField(((0.343, 0.0, 0.0),), 0.035, 49000, 343.0)
        >>> first, second = np.abs(near.at(0.0)[:, 0]).argmax(axis=-1)
        >>> int(first - second)
        5
        >>> round(float(near.at(0.0)[1, 0].max() / near.at(0.0)[0, 0].max()), 1)
        1.1
        """
        away = distances(self.places, heading, self.spacing)
        centre = np.zeros(1) if self.delayed else distances(self.places, heading, 0.0).mean(axis=0) - self.spacing / 2
        delay = (away - centre) * self.rate / self.speed_of_sound + SINC // 2
        offset = np.arange(self.n_taps) - delay[..., None]
        inside = np.abs(offset) <= SINC / 2
        window = np.where(inside, 0.5 + 0.5 * np.cos(2 * np.pi * offset / SINC), 0.0)
        return np.asarray(np.sinc(offset) * window / (4 * np.pi * away[..., None]), dtype=np.float32)


def distances(places: Sequence[tuple[float, float, float]], heading: float, spacing: float) -> Real:
    """From every source to either microphone [m], (2, n_sources); the centre of the array is (0, 0, 0).

    >>> distances([(3.0, 4.0, 0.0)], 0.0, 0.0).tolist()
    [[5.0], [5.0]]
    """
    along = 0.5 * spacing * np.array([math.cos(heading), math.sin(heading), 0.0])
    ends = np.stack([-along, along])
    away = np.linalg.norm(np.reshape(places, (-1, 3)) - ends[:, None], axis=-1)
    return np.asarray(np.maximum(away, NEAREST))
