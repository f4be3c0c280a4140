"""[actuator.options] of ``dronecan_servo``, and what they say about angles and values on the wire."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field, model_validator

from ross_payload.actuators.driver_shell import NodeId, check_geared_node
from ross_payload.config import Degrees, Positive, Table
from ross_protocols.dronecan.gimbal_messages import COARSE, AngularCommand
from ross_protocols.dronecan.messages import ArrayCommand, Command, CommandKind, as_sent, spacing

DEFAULT_ENDS = {"unitless": (-1.0, 1.0), "pwm": (1000.0, 2000.0)}  # values at the ends of the travel
RANGES = {"unitless": (-1.0, 1.0), "pwm": (500.0, 2500.0)}


class Options(Table):
    """[actuator.options] of ``dronecan_servo``."""

    port: Annotated[str, Field(pattern="^can:")] = "can:socketcan:can0"  # can:INTERFACE:CHANNEL[:BITRATE]
    node_id: NodeId = 50  # of the servo
    own_node_id: Annotated[int, Field(ge=0, le=127)] = 121  # of this payload; 0: an allocator on the bus gives one
    actuator_id: Annotated[int, Field(ge=0, le=255)] = 1  # ArduPilot counts from 1
    gimbal_id: Annotated[int, Field(ge=0, le=255)] = 0  # for command = "gimbal", instead of actuator_id
    command: Literal["unitless", "position", "pwm", "gimbal"] = (
        "unitless"  # what is sent: a value, an angle, the width of a pulse, or the attitude of a gimbal
    )
    lower_deg: Degrees = -200.0  # ends of the travel, joint angles
    upper_deg: Degrees = 200.0  # the other end
    at_lower: float | None = None  # value of the command at lower_deg; absent: -1, or 1000 us
    at_upper: float | None = None  # value of the command at upper_deg; absent: 1, or 2000 us
    feedback: Literal["measured", "model"] = (
        "measured"  # model: for a servo without position in its Status, let go if it is stopped unheard for 0.3 s
    )
    gear_ratio: Annotated[float, Field(ge=-1000, le=1000)] = 1.0  # turns of the servo per turn of the array, signed
    zero_position_deg: Degrees = 0.0  # position of the servo at joint angle 0
    resolution_deg: Positive = 0.25  # how near to a goal the servo comes
    lag_ms: Annotated[float, Field(ge=0, le=100)] = 20.0  # by which the servo is late; its set-points lead by so much
    max_lag_deg: Positive = 20.0  # farther behind its set-point, the servo does not follow
    max_speed_deg_s: Positive = 225.0  # no move is faster; the guard's cap applies, too
    max_acceleration_deg_s2: Positive = 112.5  # no move accelerates or brakes harder; the guard's cap applies, too
    settle_ms: Annotated[float, Field(ge=0, le=5000)] = 100.0  # still for so long is settled

    @model_validator(mode="after")
    def _sensible(self) -> Options:
        check_geared_node(self)
        if self.angular:
            if self.at_lower is not None or self.at_upper is not None:
                raise ValueError("position commands follow from gear_ratio; at_lower and at_upper are for the others")
            if self.command == "gimbal" and abs(self.gear_ratio) != 1:
                raise ValueError(
                    f"gear_ratio: expected 1 or -1, because a gimbal does not count turns, got {self.gear_ratio:g}"
                )
        else:
            self._check_ends(*RANGES[self.command])
        return self

    def _check_ends(self, least: float, most: float) -> None:
        lower, upper = self.ends
        if not (least <= lower <= most and least <= upper <= most) or spacing(most) > abs(upper - lower) / 10:
            expected = f"expected two different values from {least:g} to {most:g}"
            raise ValueError(f"at_lower, at_upper: {expected}, got {lower:g} and {upper:g}")

    @property
    def angular(self) -> bool:
        """Whether the value of a command is an angle [rad]."""
        return self.command in ("position", "gimbal")

    @property
    def ends(self) -> tuple[float, float]:
        """Values of the command at the ends of the travel."""
        if self.angular:
            return self._position(math.radians(self.lower_deg)), self._position(math.radians(self.upper_deg))
        lower, upper = DEFAULT_ENDS[self.command]
        return lower if self.at_lower is None else self.at_lower, upper if self.at_upper is None else self.at_upper

    @property
    def number(self) -> int:
        """Its id among actuators, or among gimbals."""
        return self.gimbal_id if self.command == "gimbal" else self.actuator_id

    def message(self, joint: float) -> ArrayCommand | AngularCommand:
        """Return what tells the servo a joint angle [rad].

        >>> Options(lower_deg=-90, upper_deg=90).message(0.0)
        ArrayCommand(commands=(Command(actuator_id=1, kind=<CommandKind.UNITLESS: 0>, value=0.0),))
        """
        if self.command == "gimbal":
            return AngularCommand(self.gimbal_id, self.value(joint))
        return ArrayCommand((Command(self.actuator_id, CommandKind[self.command.upper()], self.value(joint)),))

    @property
    def resolution(self) -> float:
        """What can be told apart [rad]: the worst of the servo, its commands and its reports."""
        if self.command == "gimbal":
            return max(math.radians(self.resolution_deg), 2 * COARSE)
        widest = max(abs(value) for value in self.ends) or 1.0
        command = spacing(widest) / abs(self._slope)
        farthest = max(abs(self._position(math.radians(angle))) for angle in (self.lower_deg, self.upper_deg))
        report = spacing(farthest) / abs(self.gear_ratio) if self.feedback == "measured" else 0.0
        return max(math.radians(self.resolution_deg), command, report)

    def value(self, joint: float) -> float:
        """Return the command for a joint angle [rad], as float16 has it where it is sent as one.

        >>> Options(lower_deg=-90, upper_deg=90).value(math.pi / 4)
        0.5
        """
        value = self.ends[0] + (joint - math.radians(self.lower_deg)) * self._slope
        return value if self.command == "gimbal" else as_sent(value)

    def quantised(self, joint: float) -> float:
        """Return the joint angle [rad] that the servo takes the command for ``joint`` [rad] to mean."""
        return self.joint_of(self.value(joint))

    def joint_of(self, value: float) -> float:
        """Return the joint angle [rad] that a command means."""
        return math.radians(self.lower_deg) + (value - self.ends[0]) / self._slope

    def joint_at(self, position: float) -> float:
        """Return the joint angle [rad] at a position of the servo [rad].

        >>> round(math.degrees(Options(gear_ratio=-2.0).joint_at(math.radians(30))), 9)
        -15.0
        """
        return (position - math.radians(self.zero_position_deg)) / self.gear_ratio

    def _position(self, joint: float) -> float:
        """Return the position of the servo [rad] at a joint angle [rad]."""
        return self.gear_ratio * joint + math.radians(self.zero_position_deg)

    @property
    def _slope(self) -> float:
        """Change of the command per joint angle [1/rad]."""
        lower, upper = self.ends
        return (upper - lower) / math.radians(self.upper_deg - self.lower_deg)
