"""Motor, gear, encoder and position loop of the simulated CANopen drive."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

STEP = 0.001  # of the simulation [s]
TREMBLE = math.radians(2)  # of an encoder that is broken, one standard deviation [rad]


@dataclass(frozen=True, slots=True)
class Mechanics:
    """What motor and load can do, at the array."""

    acceleration: float = math.radians(3000)  # of motor and load, without friction [rad/s^2]
    friction: float = math.radians(150)  # sticking and sliding, as acceleration [rad/s^2]
    position_gain: float = 3600.0  # [1/s^2]
    speed_gain: float = 120.0  # [1/s]


@dataclass(slots=True)
class Axle:
    """The array on its motor. The loop knows what the encoder says; friction it knows to 80 %."""

    scale: float  # encoder counts per joint angle, signed [1/rad]
    chance: np.random.Generator  # of trembling
    mechanics: Mechanics = field(default_factory=Mechanics)
    angle: float = 0.0  # of the array, joint angle [rad]
    rate: float = 0.0  # [rad/s]
    jammed: bool = False
    limp: bool = False  # the motor has lost its torque
    trembling: bool = False
    slipped: float = 0.0  # by which the array has slipped on the gear [rad]

    @property
    def counts(self) -> int:
        """What the encoder counts, on the side of the motor."""
        tremble = self.chance.normal(0.0, TREMBLE) if self.trembling else 0.0
        return round((self.angle - self.slipped + tremble) * self.scale)

    @property
    def counts_rate(self) -> float:
        """How fast it counts [1/s]."""
        return self.rate * self.scale

    def slip(self, by: float) -> None:
        """Let the array slip on the gear [rad]."""
        self.slipped += by
        self.angle += by

    def follow(self, lag: float, speed: float, acceleration: float) -> None:
        """Live for one step: the demand is ahead by ``lag`` and moves; all in counts."""
        mechanics = self.mechanics
        wanted = speed / self.scale
        drag = math.copysign(0.8 * mechanics.friction, wanted) if wanted else 0.0
        pull = mechanics.position_gain * lag / self.scale + mechanics.speed_gain * (wanted - self.rate)
        self.live(pull + acceleration / self.scale + drag)

    def live(self, pull: float = 0.0) -> None:
        """Live for one step while the motor pulls [rad/s^2]; friction holds at rest what is not pulled harder."""
        most, friction = self.mechanics.acceleration, self.mechanics.friction
        pull = 0.0 if self.limp else max(-most, min(pull, most))
        if self.jammed or (self.rate == 0.0 and abs(pull) <= friction):
            self.rate = 0.0
            return
        before = self.rate
        self.rate = before + (pull - math.copysign(friction, before or pull)) * STEP
        if before * self.rate < 0 and abs(pull) <= friction:
            self.rate = 0.0
        self.angle += (before + self.rate) / 2 * STEP
