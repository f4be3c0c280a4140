"""How a multicopter yaws: an attitude controller that shapes what it is told, propellers that are weak, and wind.

The controller is ArduCopter's in outline: the heading that is wanted moves a target whose rate and acceleration are
limited (`AC_AttitudeControl::input_shaping_angle`), and a proportional-integral loop makes the vehicle follow the
target. PX4's is alike.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ross_payload.angles import wrap

STEP = 0.005  # of the controller [s]
SMOOTHING_S = 0.15  # time constant of the target (ATC_INPUT_TC)
ANGLE_GAIN = 4.5  # (ATC_ANG_YAW_P) [1/s]
RATE_GAIN, RATE_INTEGRAL = 12.0, 6.0  # of the rate loop [1/s], [1/s^2]
COASTING = 3.0  # drag of a vehicle without yaw torque [rad/s^2]


@dataclass(frozen=True, slots=True)
class Airframe:
    """What a multicopter can do about its yaw axis."""

    max_speed: float  # of a turn to a heading (ATC_SLEW_YAW, MPC_YAWRAUTO_MAX) [rad/s]
    max_acceleration: float  # of the target (ATC_ACC_Y_MAX) [rad/s^2]
    torque: float  # that the propellers have, as an acceleration [rad/s^2]


@dataclass(frozen=True, slots=True)
class Wind:
    """Gusts: an angular acceleration that wanders about 0 (Ornstein and Uhlenbeck), correlated over ``length`` [s]."""

    strength: float = 0.0  # standard deviation [rad/s^2]
    length: float = 0.5  # [s]


def shaped_rate(error: float, gain: float, acceleration: float) -> float:
    """Return the rate [rad/s] that brings an angle ``error`` [rad] to rest: linear near 0, a square root beyond.

    ArduPilot's ``sqrt_controller``: where braking at ``acceleration`` [rad/s^2] is what limits it, the rate is that
    from which it can just brake.

    >>> shaped_rate(0.01, 6.0, 2.0), round(shaped_rate(1.0, 6.0, 2.0), 3)
    (0.06, 1.972)
    """
    linear = acceleration / gain**2
    if abs(error) <= linear:
        return gain * error
    return math.copysign(math.sqrt(2 * acceleration * (abs(error) - linear / 2)), error)


@dataclass(slots=True)
class YawDynamics:
    """The yaw of a vehicle, counter-clockwise from north and unwrapped [rad], and what its controller knows."""

    airframe: Airframe
    wind: Wind = Wind()
    chance: np.random.Generator = field(default_factory=lambda: np.random.default_rng(0))
    yaw: float = 0.0  # true [rad]
    rate: float = 0.0  # true [rad/s]
    target: float = 0.0  # of the attitude controller [rad]
    target_rate: float = 0.0  # [rad/s]
    limp: bool = False  # the propellers give no yaw torque
    grounded: bool = False  # it stands
    _integral: float = 0.0  # [rad/s^2]
    _gust: float = 0.0  # [rad/s^2]

    def follow_heading(self, heading: float, max_rate: float) -> None:
        """Let a step pass, toward a heading [rad] on the shorter way from the target."""
        air = self.airframe
        error = wrap(heading - self.target)
        wanted = shaped_rate(error, 1 / SMOOTHING_S, air.max_acceleration)
        limit = min(max_rate, air.max_speed)
        self._advance(min(max(wanted, -limit), limit))

    def follow_rate(self, rate: float) -> None:
        """Let a step pass, toward a rate [rad/s]."""
        self._advance(rate)

    def _advance(self, wanted: float) -> None:
        if self.grounded:
            self.rate = self.target_rate = self._integral = 0.0
            self.target = self.yaw
            return
        change = self.airframe.max_acceleration * STEP
        change = min(max(wanted - self.target_rate, -change), change)
        self.target_rate += change
        self.target += self.target_rate * STEP
        self._move(self._torque(change / STEP) + self._blow())

    def _torque(self, feed_forward: float) -> float:
        """Return what the propellers do [rad/s^2]; ``feed_forward`` is the acceleration of the target."""
        if self.limp:
            self._integral = 0.0
            return -math.copysign(min(COASTING, abs(self.rate) / STEP), self.rate)
        error = self.target_rate + ANGLE_GAIN * (self.target - self.yaw) - self.rate
        torque = self.airframe.torque
        wanted = feed_forward + RATE_GAIN * error + self._integral
        if abs(wanted) < torque:  # else the propellers can do no more
            self._integral += RATE_INTEGRAL * error * STEP
        return min(max(wanted, -torque), torque)

    def _blow(self) -> float:
        if not self.wind.strength:
            return 0.0
        stays = math.exp(-STEP / self.wind.length)
        fresh = self.wind.strength * math.sqrt(1 - stays**2)
        self._gust = stays * self._gust + fresh * float(self.chance.standard_normal())
        return self._gust

    def _move(self, acceleration: float) -> None:
        before = self.rate
        self.rate += acceleration * STEP
        self.yaw += (before + self.rate) / 2 * STEP
