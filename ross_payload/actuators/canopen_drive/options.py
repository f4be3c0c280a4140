"""[actuator.options] of ``canopen_drive``, and what they say about joint angles and encoder counts."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field, model_validator

from ross_payload.actuators.driver_shell import NodeId, capabilities_of, check_geared_node
from ross_payload.config import Degrees, Positive, Table
from ross_payload.interfaces import Capabilities, Feedback

HOMING_METHODS = {  # homing methods by CiA 402
    "here": 37,
    "negative_limit": 17,
    "positive_limit": 18,
    "switch_positive": 19,
    "switch_negative": 21,
}
MAX_COUNTS = 2**31 - 1  # counts


class Options(Table):
    """[actuator.options] of ``canopen_drive``."""

    port: Annotated[str, Field(pattern="^can:")] = "can:socketcan:can0"  # can:INTERFACE:CHANNEL[:BITRATE]
    node_id: NodeId = 5  # of the drive
    own_node_id: NodeId = 127  # of this payload, for its heartbeat; nobody else may have it
    counts_per_turn: Annotated[float, Field(gt=0, le=1e9)] = 4096.0  # of the encoder, per turn of the motor
    gear_ratio: Annotated[float, Field(ge=-10000, le=10000)] = 20.0  # turns of the motor per turn of the array, signed
    zero_deg: Degrees = 0.0  # joint angle where the drive counts 0: at its home, or at an absolute encoder's zero
    lower_deg: Degrees = -200.0  # ends of the travel, joint angles
    upper_deg: Degrees = 200.0  # the other end
    homing: Literal["none", "here", "negative_limit", "positive_limit", "switch_positive", "switch_negative"] = (
        "none"  # none: an absolute encoder knows where it is
    )
    homing_deg_s: Positive = 20.0  # towards the switch; a tenth of it away from it
    resolution_deg: Positive = 0.1  # how near to a goal the drive comes
    max_lag_deg: Positive = 5.0  # farther behind its own plan, the drive reports a following error
    max_speed_deg_s: Positive = 225.0  # no move is faster; the guard's cap applies, too
    max_acceleration_deg_s2: Positive = 112.5  # no move accelerates or brakes harder; the guard's cap applies, too
    settle_ms: Annotated[float, Field(ge=0, le=5000)] = 100.0  # still for so long is settled

    @model_validator(mode="after")
    def _sensible(self) -> Options:
        check_geared_node(self)
        if max(abs(count) for count in self.travel) > MAX_COUNTS or self.span(self.max_speed_deg_s) > MAX_COUNTS:
            raise ValueError("counts_per_turn and gear_ratio: the travel has more counts than fit into 32 bits")
        most = math.degrees((MAX_COUNTS - 1) / abs(self.scale))
        for key in ("homing_deg_s", "max_lag_deg", "max_acceleration_deg_s2"):
            if getattr(self, key) > most:
                raise ValueError(
                    f"{key}: expected at most {most:g}, which is 31 bits in counts, got {getattr(self, key):g}"
                )
        if self.homing == "here" and not self.lower_deg <= self.zero_deg <= self.upper_deg:
            raise ValueError(
                f"zero_deg: expected {self.lower_deg:g} to {self.upper_deg:g}, the travel, as the array stands there"
                f" for homing = 'here', got {self.zero_deg:g}"
            )
        return self

    @property
    def absolute(self) -> bool:
        """Whether the encoder knows where it is without homing."""
        return self.homing == "none"

    @property
    def scale(self) -> float:
        """Counts per joint angle, signed [1/rad].

        >>> round(math.radians(1) * Options(counts_per_turn=3600, gear_ratio=-2.0).scale, 9)
        -20.0
        """
        return self.counts_per_turn * self.gear_ratio / (2 * math.pi)

    @property
    def travel(self) -> tuple[int, int]:
        """Counts at the ends of the travel, the lower one first."""
        ends = (self.counts(math.radians(self.lower_deg)), self.counts(math.radians(self.upper_deg)))
        return min(ends), max(ends)

    @property
    def resolution(self) -> float:
        """What can be told apart [rad]."""
        return max(math.radians(self.resolution_deg), 1 / abs(self.scale))

    @property
    def capabilities(self) -> Capabilities:
        """What is asked of drive and array."""
        finds_zero = self.homing not in ("none", "here")
        return capabilities_of(self, self.resolution, Feedback.MEASURED, finds_zero=finds_zero)

    def counts(self, joint: float) -> int:
        """Return the drive's position at a joint angle [rad]."""
        return round((joint - math.radians(self.zero_deg)) * self.scale)

    def joint(self, counts: float) -> float:
        """Return the joint angle [rad] at a position of the drive.

        >>> options = Options(counts_per_turn=3600, gear_ratio=2.0, zero_deg=-90)
        >>> options.counts(0.0), round(math.degrees(options.joint(200)), 9)
        (1800, -80.0)
        """
        return math.radians(self.zero_deg) + counts / self.scale

    def span(self, degrees: float) -> int:
        """Return counts for degrees of the array: a way, a speed or an acceleration, at least 1."""
        return max(round(abs(math.radians(degrees) * self.scale)), 1)
