"""The rooms of every table: the paper's planes and true rooms with a floor and a ceiling.

Sabine's formula makes the flat rooms of three dimensions ring longer than asked for; their nominal T60 is chosen so
that the energy decay of what is simulated (Schroeder, first 20 dB) has the T60 in their name.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ross_payload.errors import ConfigError, unknown
from ross_payload.interfaces import Real, Samples
from ross_sim.acoustics.impulse_responses import Responses
from ross_sim.acoustics.room import RoomSpec, respond

SPACING, SPEED_OF_SOUND = 0.05, 343.0  # d [m], v_p [m/s]
DISTANCE = 2.5  # of every talker in a plane [m]
NEAR, FAR = 2.0, 2.5  # of the talkers in three dimensions, along the floor [m]
ARRAY, LOW, HIGH = 1.2, 1.5, 1.7  # heights of the array and of the talkers' mouths [m]


@dataclass(frozen=True, slots=True)
class Setting:
    """One room with the array in its middle."""

    name: str
    size: tuple[float, ...]  # [m]
    t60: float  # nominal [s]

    @property
    def flat(self) -> bool:
        """Whether the room is a plane."""
        return len(self.size) == 2

    @property
    def centre(self) -> tuple[float, ...]:
        """Where the array is [m]."""
        return (self.size[0] / 2, self.size[1] / 2) + (() if self.flat else (ARRAY,))

    def places(self, azimuths: Real, rng: np.random.Generator) -> Real:
        """Where talkers at these azimuths [rad] stand [m], (n_sources, dim); ``rng`` draws distances and heights."""
        n = len(azimuths)
        distance = np.full(n, DISTANCE) if self.flat else rng.uniform(NEAR, FAR, n)
        height = [] if self.flat else [rng.uniform(LOW, HIGH, n)]
        x, y = self.centre[:2]
        return np.stack([x + distance * np.cos(azimuths), y + distance * np.sin(azimuths), *height], axis=1)

    def responses(self, places: Real, headings: Sequence[float], rate: int) -> Samples:
        """Impulse responses (n_headings, 2, n_sources, n_taps); those of true rooms are kept on disk."""
        spec = RoomSpec(
            self.size, self.t60, rate, self.centre, SPACING, tuple(map(tuple, places.tolist())), SPEED_OF_SOUND
        )
        if self.flat:
            return respond(spec, headings)
        return Responses(spec).over(headings)


SETTINGS = {
    setting.name: setting
    for setting in (
        Setting("S1", (10.0, 10.0), 0.0),
        Setting("S2", (10.0, 10.0), 0.45),
        Setting("S3", (10.0, 10.0), 0.7),
        Setting("A0.3", (10.0, 10.0, 3.0), 0.280),
        Setting("A0.45", (10.0, 10.0, 3.0), 0.376),
        Setting("A0.7", (10.0, 10.0, 3.0), 0.527),
        Setting("B0.3", (6.0, 8.0, 3.0), 0.302),
        Setting("B0.45", (6.0, 8.0, 3.0), 0.409),
        Setting("B0.7", (6.0, 8.0, 3.0), 0.592),
    )
}
PLANES = ("S1", "S2", "S3")  # the paper's settings


def check_rooms(names: Iterable[str]) -> None:
    """Check that rooms are known.

    Raises
    ------
    ConfigError
        When one is not.
    """
    for name in names:
        if name not in SETTINGS:
            raise ConfigError(unknown("room", name, SETTINGS))
