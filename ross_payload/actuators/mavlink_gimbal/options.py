"""What a configuration says about a MAVLink gimbal."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field, model_validator

from ross_payload.config import Degrees, Positive, Table
from ross_protocols.mavlink.gimbal_messages import GimbalTravel


class Options(Table):
    """[actuator.options] of ``mavlink_gimbal``."""

    port: str = "mavlink:"  # the payload's own links
    role: Literal["discover", "client", "manager"] = "discover"  # client: of an autopilot; manager: of a bare device
    device_id: Annotated[int, Field(ge=0, le=255)] = 0  # of the gimbal at its manager, 0: the first
    lower_deg: Annotated[Degrees, Field(le=0)] = -200.0  # travel, which the gimbal must have
    upper_deg: Annotated[Degrees, Field(ge=0)] = 200.0  # the other end
    max_speed_deg_s: Positive = 90.0  # no set-point is faster; the guard's cap applies, too
    max_acceleration_deg_s2: Positive = 112.5  # of the set-points; the gimbal has its own besides
    resolution_deg: Annotated[float, Field(gt=0, le=5)] = 0.1  # settled within this of the goal
    settle_ms: Annotated[float, Field(ge=0, le=5000)] = 100.0  # at rest at the goal, before that is said

    @model_validator(mode="after")
    def _turns(self) -> Options:
        if not self.lower_deg < self.upper_deg:
            raise ValueError(f"lower_deg = {self.lower_deg:g} must be below upper_deg = {self.upper_deg:g}")
        return self

    def travel_trouble(self, travel: GimbalTravel | None) -> str:
        """Say when a gimbal turns less far than is asked for, or tells what cannot be; empty when it is well.

        >>> Options().travel_trouble(GimbalTravel(1, -4.0, 4.0))
        ''
        """
        if travel is None or (math.isnan(travel.lower) and math.isnan(travel.upper)):  # NaN: not known
            return ""
        lower, upper = math.degrees(travel.lower), math.degrees(travel.upper)
        if not lower < upper:
            return (
                f"the limits of the gimbal: expected lower < upper, got {lower:.0f} to {upper:.0f} deg; not moving it"
            )
        if lower - self.resolution_deg <= self.lower_deg and self.upper_deg <= upper + self.resolution_deg:
            return ""
        return (
            f"the travel of the gimbal: expected at least {self.lower_deg:g} to {self.upper_deg:g} deg "
            f"(actuator.options.lower_deg to upper_deg), got {lower:.0f} to {upper:.0f}"
        )
