"""How a vehicle yaws: to and fro, steadily, here and there as in wind, and as it vibrates."""

from __future__ import annotations

import math
from dataclasses import dataclass

DRIFTS = (
    (0.033, 0.9),
    (0.071, 2.3),
    (0.127, 4.1),
)  # of the drift: frequencies [Hz] and phases [rad]; each is as strong


@dataclass(frozen=True, slots=True)
class Yaw:
    """A triangle wave around a mean: to and fro at a constant rate; what else moves it is added.

    Radians, counter-clockwise. At time 0 it stands at its mean and turns counter-clockwise; an amplitude of 0 is rest.
    The drift is a sum of slow waves that never repeats within a flight, the vibration one fast wave.

    >>> yaw = Yaw(mean=1.0, amplitude=0.5, speed=0.25)
    >>> [yaw.at(time) for time in (0.0, 2.0, 4.0, 6.0, 8.0)]
    [1.0, 1.5, 1.0, 0.5, 1.0]
    >>> [yaw.rate(time) for time in (1.0, 3.0, 7.0)]
    [0.25, -0.25, 0.25]
    >>> Yaw(steady=0.5).at(3.0)
    1.5
    """

    mean: float = 0.0  # [rad]
    amplitude: float = 0.0  # [rad]
    speed: float = 1.0  # [rad/s]
    steady: float = 0.0  # [rad/s]
    drift: float = 0.0  # one standard deviation [rad]
    vibration: float = 0.0  # to either side [rad]
    frequency: float = 12.0  # of the vibration [Hz]

    def turned(self, time: float) -> float:
        """How far it has turned from its mean [rad] at ``time`` [s]."""
        return self._to_and_fro(time) + self._moved(time)

    def at(self, time: float) -> float:
        """Where it points [rad] at ``time`` [s]."""
        return self.mean + self.turned(time)

    def rate(self, time: float) -> float:
        """How fast it turns [rad/s] at ``time`` [s]."""
        rate = self.steady
        if self.amplitude:
            way = (self.speed * time + self.amplitude) % (4 * self.amplitude)
            rate += math.copysign(self.speed, 2 * self.amplitude - way)
        if self.drift:
            scale = self.drift * math.sqrt(2 / len(DRIFTS))
            rate += scale * sum(2 * math.pi * f * math.cos(2 * math.pi * f * time + shift) for f, shift in DRIFTS)
        if self.vibration:
            omega = 2 * math.pi * self.frequency
            rate += self.vibration * omega * math.cos(omega * time)
        return rate

    def _to_and_fro(self, time: float) -> float:
        if self.amplitude == 0.0:
            return 0.0
        way = (self.speed * time + self.amplitude) % (4 * self.amplitude)  # since it stood at the lower end
        return min(way, 4 * self.amplitude - way) - self.amplitude

    def _moved(self, time: float) -> float:
        turned = self.steady * time
        if self.drift:
            scale = self.drift * math.sqrt(2 / len(DRIFTS))
            turned += scale * sum(math.sin(2 * math.pi * f * time + shift) for f, shift in DRIFTS)
        if self.vibration:
            turned += self.vibration * math.sin(2 * math.pi * self.frequency * time)
        return turned
