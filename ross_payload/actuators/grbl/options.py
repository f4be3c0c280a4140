"""[actuator.options] of ``grbl``, and what grbl's own settings must be for them."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field

from ross_payload.config import Degrees, Positive, Table
from ross_protocols.grbl import protocol

SETTING_ROUNDING = 0.0006  # of a setting, which is told with three decimals
AVR_STEPS_PER_S = 30_000  # that grbl 1.1 makes on the processor it was written for; later ones make more
MIN_SETTING = 1e-6  # least of what must be above 0


class Options(Table):
    """[actuator.options] of ``grbl``."""

    port: Annotated[str, Field(pattern="^serial:")] = (
        "serial:/dev/ttyUSB0:115200"  # serial:DEVICE:BAUD or serial:tcp:HOST:PORT
    )
    axis: Literal["X", "Y", "Z", "A", "B", "C"] = "X"  # whose millimetres are degrees of the array
    full_steps: Annotated[int, Field(ge=20, le=400, multiple_of=4)] = 200  # of the motor, per turn
    microsteps: Annotated[int, Field(ge=1, le=256)] = 16  # as set on the driver of the motor
    gear_ratio: Positive = 1.0  # turns of the motor per turn of the array
    max_speed_deg_s: Positive = 225.0  # no move is faster; the guard's cap applies, too
    max_acceleration_deg_s2: Positive = 112.5  # grbl's $120 must not be above
    settle_ms: Annotated[float, Field(ge=0, le=5000)] = 100.0  # idle at one place for so long is settled
    zero: Literal["declared", "unknown", "switch"] = "declared"  # declared: the array stands at its zero when opened
    home_deg: Degrees = 0.0  # with a switch: joint angle where grbl stands after homing
    homing_s: Annotated[float, Field(ge=1, le=300)] = 60.0  # with a switch: homing takes no longer

    @property
    def resolution(self) -> float:
        """One microstep at the array [rad]."""
        return 2 * math.pi / (self.full_steps * self.microsteps * self.gear_ratio)

    @property
    def index(self) -> int:
        """The number of the axis, counted from 0."""
        return "XYZABC".index(self.axis)


def complaint(settings: dict[int, float], options: Options) -> str:
    """Say in one line which of grbl's settings is wrong, and what it must be; empty when all are well.

    >>> good = {1: 255, 10: 1, 13: 0, 22: 0, 100: 8.889, 110: 13500, 120: 112.5}
    >>> complaint(good, Options()), complaint(good | {120: 500}, Options())
    ('', "grbl's $120 is 500, above the acceleration of 112.5 deg/s^2 that is allowed: set $120=112.5")
    """
    steps, speed, acceleration = (
        first + options.index for first in (protocol.STEPS, protocol.MAX_RATE, protocol.ACCELERATION)
    )
    needed = (protocol.IDLE_DELAY, protocol.REPORT_MASK, protocol.INCHES, protocol.HOMING, steps, speed, acceleration)
    for number in needed:
        if number not in settings:
            return f"grbl does not report ${number}: does it have an axis {options.axis}, and is it version 1.1?"
    for number in (steps, speed, acceleration):
        if settings[number] < MIN_SETTING:
            return f"grbl's ${number} is {settings[number]:g}: expected a value above 0"
    scale, cap = protocol.per_degree(options.resolution), options.max_acceleration_deg_s2
    if abs(settings[steps] - scale) > SETTING_ROUNDING:
        return f"grbl's ${steps} is {settings[steps]:g} steps per degree: motor and gear need ${steps}={scale:.7g}"
    if settings[acceleration] > cap + SETTING_ROUNDING:
        found = f"grbl's ${acceleration} is {settings[acceleration]:g}"
        return f"{found}, above the acceleration of {cap:g} deg/s^2 that is allowed: set ${acceleration}={cap:g}"
    if options.zero == "switch" and not settings[protocol.HOMING]:
        return "zero is 'switch', but grbl's $22 is 0: set $22=1"
    return _complaint_of_modes(settings)


def _complaint_of_modes(settings: dict[int, float]) -> str:
    if settings[protocol.IDLE_DELAY] != 255:
        found = f"grbl's $1 is {settings[protocol.IDLE_DELAY]:g}"
        return f"{found}: the motor would lose its torque at rest and the position with it: set $1=255"
    if not int(settings[protocol.REPORT_MASK]) & 1:
        return f"grbl's $10 is {settings[protocol.REPORT_MASK]:g}: it would not report machine positions: set $10=1"
    if settings[protocol.INCHES]:
        return "grbl's $13 is 1: it would report in inches: set $13=0"
    return ""


def slower(settings: dict[int, float], options: Options) -> list[str]:
    """Say what grbl does more slowly than the options allow: moves then take longer; or perhaps faster than it can."""
    speed, acceleration = protocol.MAX_RATE + options.index, protocol.ACCELERATION + options.index
    notes = []
    pulses = settings[speed] / 60 * settings[protocol.STEPS + options.index]
    if pulses > AVR_STEPS_PER_S:
        notes.append(
            f"grbl's ${speed} asks for {pulses:.0f} steps/s: grbl on an AVR loses steps above {AVR_STEPS_PER_S}"
        )
    if protocol.rate(settings[speed]) < math.radians(options.max_speed_deg_s) * 0.999:
        found = f"grbl's ${speed} is {settings[speed]:g}, {settings[speed] / 60:g} deg/s"
        notes.append(f"{found}: slower than max_speed_deg_s = {options.max_speed_deg_s:g}: moves take longer")
    if settings[acceleration] < options.max_acceleration_deg_s2 * 0.999:
        found = f"grbl's ${acceleration} is {settings[acceleration]:g} deg/s^2"
        notes.append(
            f"{found}: slower than max_acceleration_deg_s2 = {options.max_acceleration_deg_s2:g}: moves take longer"
        )
    return notes
