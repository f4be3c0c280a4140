"""The vehicle that carries the payload: how it yaws."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Yaw:
    """A triangle wave around a mean: to and fro at a constant rate.

    Radians, counter-clockwise. At time 0 it stands at its mean and turns counter-clockwise; an amplitude of 0 is rest.

    >>> yaw = Yaw(mean=1.0, amplitude=0.5, speed=0.25)
    >>> [yaw.at(time) for time in (0.0, 2.0, 4.0, 6.0, 8.0)]
    [1.0, 1.5, 1.0, 0.5, 1.0]
    >>> [yaw.rate(time) for time in (1.0, 3.0, 7.0)]
    [0.25, -0.25, 0.25]
    """

    mean: float = 0.0  # [rad]
    amplitude: float = 0.0  # [rad]
    speed: float = 1.0  # [rad/s]

    def turned(self, time: float) -> float:
        """How far it has turned from its mean [rad] at ``time`` [s]."""
        if self.amplitude == 0.0:
            return 0.0
        way = (self.speed * time + self.amplitude) % (4 * self.amplitude)  # since it stood at the lower end
        return min(way, 4 * self.amplitude - way) - self.amplitude

    def at(self, time: float) -> float:
        """Where it points [rad] at ``time`` [s]."""
        return self.mean + self.turned(time)

    def rate(self, time: float) -> float:
        """How fast it turns [rad/s] at ``time`` [s]."""
        if self.amplitude == 0.0:
            return 0.0
        way = (self.speed * time + self.amplitude) % (4 * self.amplitude)
        return math.copysign(self.speed, 2 * self.amplitude - way)
