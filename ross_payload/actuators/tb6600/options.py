"""[actuator.options] of ``tb6600``, and what they say about edges, steps and the home switch."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field, model_validator

from ross_payload.actuators.tb6600.homing import SearchOptions
from ross_payload.actuators.tb6600.pulse_segments import RECORDING
from ross_payload.actuators.tb6600.step_edges import PulseTiming
from ross_payload.actuators.wires.gpio import AHEAD, SCHEME, pins_of
from ross_payload.config import Degrees, Positive, Table

MOST_AHEAD_MS = 100.0  # where something turns: that much later a stop begins
ROUNDING_S = 1e-8  # of a time on the Clock, more than its last digit after a year [s]


class Options(Table):
    """[actuator.options] of ``tb6600``; speed and acceleration default to the paper's."""

    port: str = RECORDING  # pulses:lgpio:CHIP:STEP,DIRECTION,ENABLE[,HOME]; the default moves nothing
    full_steps: Annotated[int, Field(ge=20, le=400, multiple_of=4)] = 200  # of the motor, per turn
    microsteps: Literal[1, 2, 4, 8, 16, 32] = 16  # as set on the module; tables of makers differ
    gear_ratio: Positive = 1.0  # turns of the motor per turn of the array
    max_speed_deg_s: Positive = 225.0  # no move is faster; the guard's cap applies, too
    max_acceleration_deg_s2: Positive = 112.5  # no move accelerates or brakes harder; the guard's cap applies, too
    invert_direction: bool = False  # the motor turns the other way
    enable_means_off: bool = True  # most modules switch off when ENA is asserted
    pulse_us: Annotated[float, Field(ge=1, le=1000)] = 10.0  # a pulse is high, and low, for so long at least
    direction_setup_us: Annotated[float, Field(ge=1, le=1000)] = 20.0  # DIRECTION to STEP, at least
    direction_hold_us: Annotated[float, Field(ge=1, le=1000)] = 20.0  # STEP to DIRECTION, at least
    enable_lead_ms: Annotated[float, Field(ge=0, le=1000)] = 5.0  # from switching on to the first pulse
    max_pulse_rate_hz: Annotated[float, Field(ge=10, le=200_000)] = 15_000.0  # pulses come no faster
    ahead_ms: Annotated[float, Field(ge=20, le=500)] = 40.0  # a stop's latency, and the longest pause of the program
    settle_ms: Annotated[float, Field(ge=0, le=5000)] = 100.0  # after the last step, for the ringing
    zero: Literal["declared", "unknown", "switch"] = "declared"  # declared: the array stands at its zero when opened
    home_level: Literal["low", "high"] = "low"  # of the HOME line while the switch is pressed
    home_direction: Literal["clockwise", "counter-clockwise"] = "clockwise"  # in which the switch is looked for
    home_offset_deg: Degrees = 0.0  # joint angle at which the switch closes, turning that way
    home_speed_deg_s: Annotated[float, Field(ge=1, le=90)] = 20.0  # of the search; a tenth of it to measure
    home_search_deg: Annotated[float, Field(ge=1, le=1440)] = 400.0  # no farther without the switch

    @model_validator(mode="after")
    def _pulses_fit(self) -> Options:
        if self.max_pulse_rate_hz * 2e-6 * self.pulse_us > 1:
            raise ValueError(f"max_pulse_rate_hz = {self.max_pulse_rate_hz:g} leaves no room for pulse_us twice")
        needed = math.radians(self.max_speed_deg_s) / self.resolution
        if needed * (self.timing.period - ROUNDING_S) > 1 + 1e-9:
            found = f"max_speed_deg_s = {self.max_speed_deg_s:g} needs {needed:.0f} pulses/s"
            cap = f"max_pulse_rate_hz = {self.max_pulse_rate_hz:g} in whole microseconds"
            raise ValueError(f"{found}, expected at most {1 / self.timing.period:.0f} ({cap})")
        return self

    @model_validator(mode="after")
    def _pins_fit(self) -> Options:
        if not self.port.startswith(SCHEME):
            return self
        if pins_of(self.port).home is None and self.zero == "switch":
            raise ValueError(f"port: expected a HOME line for zero = 'switch' ({self.port},HOME), got none")
        if self.ahead_ms > AHEAD * 1e3:
            raise ValueError(f"ahead_ms: expected at most {AHEAD * 1e3:g} on pins, got {self.ahead_ms:g}")
        return self

    @model_validator(mode="after")
    def _stops_soon(self) -> Options:
        if self.ahead_ms > MOST_AHEAD_MS and self.port != RECORDING:
            raise ValueError(f"ahead_ms: expected at most {MOST_AHEAD_MS:g} with a motor, got {self.ahead_ms:g}")
        return self

    @property
    def resolution(self) -> float:
        """One microstep at the array [rad]."""
        return 2 * math.pi / (self.full_steps * self.microsteps * self.gear_ratio)

    @property
    def timing(self) -> PulseTiming:
        """What to keep between edges: whole microseconds and a trifle, so that rounding to them takes nothing away."""
        return PulseTiming(
            width=_whole(self.pulse_us),
            setup=_whole(self.direction_setup_us),
            hold=_whole(self.direction_hold_us),
            period=_whole(1e6 / self.max_pulse_rate_hz),
            up=not self.invert_direction,
        )

    @property
    def search(self) -> SearchOptions:
        """How to look for the home switch."""
        return SearchOptions(
            sign=1 if self.home_direction == "counter-clockwise" else -1,
            speed=math.radians(self.home_speed_deg_s),
            travel=math.radians(self.home_search_deg),
        )


def _whole(microseconds: float) -> float:
    """Round up to whole microseconds, and a trifle more [s]."""
    return math.ceil(microseconds - 1e-6) * 1e-6 + ROUNDING_S
