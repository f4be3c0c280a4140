"""The mechanics of a simulated servo: motor, friction, backlash, encoder and the loop that holds a goal."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

STEP = 0.001  # of the simulation [s]
NOISE = math.radians(2)  # of an encoder that trembles, one standard deviation [rad]


@dataclass(frozen=True, slots=True)
class Drive:
    """What a servo can do, at its own shaft: a good pan servo."""

    speed: float = math.radians(360)  # highest [rad/s]
    acceleration: float = math.radians(3000)  # of motor and load, without friction [rad/s^2]
    friction: float = math.radians(150)  # sticking and sliding, as acceleration [rad/s^2]
    backlash: float = math.radians(0.05)  # play between motor and load, from end to end [rad]
    position_gain: float = 30.0  # [1/s]
    speed_gain: float = 100.0  # [1/s]
    counts: int = 4096  # of its encoder per turn
    encoder: Literal["motor", "load"] = "motor"  # on which side of the play it sits


@dataclass(slots=True)
class Shaft:
    """A position loop around a speed loop around a shaft with friction.

    The speed wanted is the gain times the error as the encoder sees it, and never more than can be braked away over
    that error with half of the acceleration. Friction holds a shaft at rest until the motor pulls harder. The load
    follows the motor with its play: its own friction holds it where the motor leaves it.
    """

    drive: Drive
    chance: np.random.Generator
    angle: float = 0.0  # of the motor's side [rad]
    rate: float = 0.0  # [rad/s]
    load: float = 0.0  # angle of the load's side [rad]
    slipped: float = 0.0  # by which what turns has slipped on the load's side [rad]
    jammed: bool = False
    powerless: bool = False
    noisy: bool = False

    def __post_init__(self) -> None:
        self.load = self.angle

    @property
    def turned(self) -> float:
        """The true angle of what turns [rad]."""
        return self.load + self.slipped

    @property
    def measured(self) -> float:
        """The angle as the loop sees it [rad], which has many samples of the encoder."""
        return self._sampled(0.0)

    @property
    def reported(self) -> float:
        """One sample of the encoder [rad]."""
        return self._sampled(float(self.chance.normal(0.0, NOISE)) if self.noisy else 0.0)

    def place(self, angle: float) -> None:
        """Stand at an angle [rad], the motor in the middle of its play."""
        self.angle = self.load = angle
        self.rate = self.slipped = 0.0

    def live(self, goal: float | None) -> None:
        """Live for one step with a goal [rad], or without torque."""
        drive = self.drive
        pull = 0.0
        if goal is not None and not self.powerless:
            pull = drive.speed_gain * (self._wanted(goal - self.measured) - self.rate)
        pull = max(-drive.acceleration, min(pull, drive.acceleration))
        if self.jammed or (self.rate == 0.0 and abs(pull) <= drive.friction):
            self.rate = 0.0
            return
        before = self.rate
        drag = math.copysign(drive.friction, before or pull)
        self.rate = before + (pull - drag) * STEP
        if before * self.rate < 0 and abs(pull) <= drive.friction:
            self.rate = 0.0
        self.angle += (before + self.rate) / 2 * STEP
        self.load = min(max(self.load, self.angle - drive.backlash / 2), self.angle + drive.backlash / 2)

    def _sampled(self, noise: float) -> float:
        unit = 2 * math.pi / self.drive.counts
        seen = self.angle if self.drive.encoder == "motor" else self.turned
        return round((seen + noise) / unit) * unit

    def _wanted(self, error: float) -> float:
        drive = self.drive
        speed = min(drive.position_gain * abs(error), math.sqrt(drive.acceleration * abs(error)), drive.speed)
        return math.copysign(speed, error)
