"""What a configuration says about a vehicle that yaws for its microphones."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from ross_payload.config import Degrees, Positive, Table
from ross_payload.errors import ConfigError


class Options(Table):
    """[actuator.options] of ``vehicle_yaw``."""

    port: str = "mavlink:"  # the payload's own links
    turn_vehicle: bool = False  # must be true: the autopilot turns the whole vehicle while it flies
    px4_mode: Literal["hold", "offboard"] = "hold"  # in which a PX4 is turned; offboard: a stream that must not end
    lower_deg: Annotated[Degrees, Field(le=0)] = -200.0  # headings, counter-clockwise from north
    upper_deg: Annotated[Degrees, Field(ge=0)] = 200.0
    max_speed_deg_s: Positive = 30.0
    max_acceleration_deg_s2: Positive = 30.0
    resolution_deg: Annotated[float, Field(gt=0, le=10)] = 3.0  # settled within this of the goal, in wind
    settle_ms: Annotated[float, Field(ge=0, le=5000)] = 500.0  # at the goal, before that is said
    yaw_channel: Annotated[int, Field(ge=0, le=18)] = 4  # of RC_CHANNELS: the pilot's yaw stick; 0: nobody holds one
    stick_centre_us: Annotated[float, Field(ge=1000, le=2000)] = 1500.0  # pulse of the stick at rest
    stick_dead_band_us: Annotated[float, Field(ge=5, le=200)] = (
        40.0  # farther from its centre the vehicle is the pilot's
    )

    @model_validator(mode="after")
    def _turns(self) -> Options:
        if not self.lower_deg < self.upper_deg:
            raise ValueError(f"lower_deg = {self.lower_deg:g} must be below upper_deg = {self.upper_deg:g}")
        return self

    def check_consent(self) -> None:
        """Refuse to turn a vehicle that nobody has said may be turned.

        Raises
        ------
        ConfigError
            When ``turn_vehicle`` is false.
        """
        if not self.turn_vehicle:
            raise ConfigError(
                "actuator.options.turn_vehicle: expected true, since the autopilot turns the whole vehicle while it"
                " flies, got false"
            )
