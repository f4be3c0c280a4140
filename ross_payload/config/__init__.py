"""Configuration: frozen models of one TOML file. Units stand in the names here and nowhere else."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

from pydantic import Field, ValidationInfo, field_validator, model_validator

from ross_payload.config.communication_options import Dronecan, Gimbal, Link, Recording, Service, Telemetry
from ross_payload.config.hardware_options import Actuator, Array, Audio, EgoNoise, Guard, Mount
from ross_payload.config.listening_options import Listening, Stream
from ross_payload.config.mission_options import APART_DEG, Exploit, Explore, Informed, VoicePrints
from ross_payload.config.table import Degrees, Model, Positive, Table, read_toml, validated

__all__ = [
    "APART_DEG",
    "VEHICLE_YAW",
    "Actuator",
    "Array",
    "Audio",
    "Config",
    "Degrees",
    "Dronecan",
    "EgoNoise",
    "Exploit",
    "Explore",
    "Gimbal",
    "Guard",
    "Informed",
    "Link",
    "Listening",
    "Model",
    "Mount",
    "Positive",
    "Recording",
    "Service",
    "Stream",
    "Table",
    "Telemetry",
    "VoicePrints",
    "as_in_paper",
    "load",
    "read_toml",
    "validated",
]  # fmt: skip


LEAST_TRAVEL_DEG = 90.0  # of a joint that turns back and forth while it explores: less shows too few axes
VEHICLE_YAW = "vehicle_yaw"  # the actuator whose joint angle counts from north


class Config(Table):
    """The whole file."""

    array: Array = Array()
    audio: Audio = Audio()
    actuator: Actuator = Actuator()
    guard: Guard = Guard()
    mount: Mount = Mount()
    ego_noise: Annotated[EgoNoise, Field(exclude_if=lambda table: table == EgoNoise())] = EgoNoise()
    explore: Explore = Explore()
    informed: Informed | None = None
    exploit: Exploit = Exploit()
    voice_print: VoicePrints = VoicePrints()
    links: tuple[Link, ...] = ()
    telemetry: Telemetry = Telemetry()
    gimbal: Gimbal = Gimbal()
    dronecan: Dronecan = Dronecan()
    service: Service = Service()
    recording: Recording = Recording()
    listening: Listening = Listening()
    seed: Annotated[int, Field(ge=0)] = 0

    @field_validator("audio")
    @classmethod
    def _spacing_by_preset(cls, audio: Audio, info: ValidationInfo) -> Audio:
        """Give the array the spacing of its preset, where the file tells none."""
        array, known = info.data.get("array"), audio.known_spacing
        if array is not None and known is not None and "spacing_m" not in array.model_fields_set:
            info.data["array"] = Array.model_construct(array.model_fields_set, **dict(array) | {"spacing_m": known})
        return audio

    @model_validator(mode="after")
    def _one_gimbal(self) -> Config:
        mode, number = self.gimbal.mode, self.gimbal.component_id
        if mode != "off" and self.actuator.kind == "mavlink_gimbal":
            raise ValueError(f"gimbal.mode: expected 'off', as a mavlink_gimbal announces itself, got '{mode}'")
        if mode != "off" and number == self.telemetry.component_id:
            raise ValueError(
                f"gimbal.component_id: expected another id than telemetry.component_id, got {number} for both"
            )
        return self

    @model_validator(mode="after")
    def _room_to_turn(self) -> Config:
        travel = self.guard.upper_deg - self.guard.lower_deg
        if self.explore.continuous and travel < LEAST_TRAVEL_DEG:
            raise ValueError(
                f"explore.continuous: expected limits at least {LEAST_TRAVEL_DEG:g} deg apart, got {travel:g}"
            )
        return self

    @model_validator(mode="after")
    def _explorer_hears(self) -> Config:
        spacing, speed, rate = self.array.spacing_m, self.array.speed_of_sound_m_s, self.audio.rate_hz
        least = 2 * math.ceil(spacing * rate / speed)  # the first frequency is at most v_p / (2 d)
        if self.explore.frame is not None and self.explore.frame < least:
            raise ValueError(
                f"explore.frame: expected at least {least} samples at {rate} Hz with {spacing:g} m between the "
                f"microphones, as no frequency lies below their aliasing limit otherwise, got {self.explore.frame}"
            )
        return self

    @model_validator(mode="after")
    def _yaw_counts_once(self) -> Config:
        if self.actuator.kind != VEHICLE_YAW:
            return self
        if self.mount.source != "fixed" or self.mount.yaw_deg not in (None, 0.0):
            found = f"yaw_deg = {self.mount.yaw_deg:g}" if self.mount.source == "fixed" else "source = 'autopilot'"
            raise ValueError(
                f"mount: expected no [mount], as the joint angle of vehicle_yaw is the yaw of the vehicle, got {found}"
            )
        if self.gimbal.mode != "off":
            raise ValueError(f"gimbal.mode: expected 'off', as a vehicle is no gimbal, got '{self.gimbal.mode}'")
        return self

    @property
    def hop(self) -> int:
        """Samples of one Input."""
        return self.audio.rate_hz * self.audio.hop_ms // 1000

    @property
    def offset(self) -> float:
        """Calibrated offset of the array's axis [rad]."""
        return math.radians(self.array.offset_deg)


def as_in_paper(config: Config) -> Config:
    """Return a configuration with the methods and numbers of the paper instead of ours; the rest stays as it is.

    Of the paper's own separators the one that serves best is taken; Algorithm 2 as printed is the separator `paper`.
    """
    numbers = {"frame": 1024, "overlap": 0.25}
    explore = Explore(
        method="markov", lead_in_s=config.explore.lead_in_s, unit_s=3, step_deg=15, min_rotations=1, max_rotations=12,
        **numbers,
    )  # fmt: skip
    caps = {"max_speed_deg_s": 225.0, "max_acceleration_deg_s2": 112.5}
    changes = {
        "audio": config.audio.model_copy(update=numbers),
        "guard": config.guard.model_copy(update=caps),
        "explore": explore,
        "exploit": config.exploit.model_copy(update={"separator": "duet", "rules": "paper"}),
    }
    return config.model_copy(update=changes)


def load(path: Path) -> Config:
    """Load one TOML file; what it does not say has the default, and nothing else is merged."""
    return validated(Config, read_toml(path), str(path))
