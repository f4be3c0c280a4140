"""The tables of microphones and actuator: array, audio, actuator, guard, mount."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from ross_payload.config.array_presets import PRESETS
from ross_payload.config.table import Degrees, Positive, Table

Channel = Annotated[int, Field(ge=0, le=63)]
Decibels = Annotated[float, Field(ge=-60, le=60)]
Corner = Annotated[float, Field(ge=0, le=300)]  # of a microphone's low-frequency roll-off [Hz]
Metres = Annotated[float, Field(ge=-10, le=10, allow_inf_nan=False)]

Age = Annotated[float, Field(gt=0, le=60)]  # at which a report is too old [s]; more are milliseconds, most likely

NEAREST_M = 0.1  # a rotor to the array


class Array(Table):
    """[array]: the two microphones."""

    spacing_m: Annotated[float, Field(ge=0.005, le=1.0)] = (
        0.05  # d, between the microphones [m]; default: that of the preset's microphones on these channels, where known
    )
    speed_of_sound_m_s: Annotated[float, Field(ge=250, le=450)] = 343.0  # v_p [m/s]; 331 at 0 deg Celsius, 343 at 20
    offset_deg: Degrees = 0.0  # heading of the axis from microphone 1 to 2 when the joint angle and mount yaw are 0


class Audio(Table):
    """[audio]: rates and frames."""

    source: Annotated[str, Field(pattern=r"^[A-Za-z][\w.-]*:.+")] = (
        "device:default"  # device:NAME (part of it is enough), file:PATH, tcp:HOST:PORT or NAME:ADDRESS of a plug-in
    )
    preset: Literal[
        "",
        "respeaker-2mic",
        "respeaker-4mic",
        "respeaker-usb",
        "respeaker-xvf3800",
        "respeaker-xvf3800-2ch",
        "usb-stereo",
        "i2s-stereo",
    ] = ""  # channels and spacing of known arrays
    channels: tuple[Channel, Channel] | None = (
        None  # those of microphones 1 and 2, from 0; default: the preset's, else 0 and 1
    )
    device_channels: Annotated[int, Field(ge=1, le=64)] | None = (
        None  # channels to open; default: the preset's, else as many as needed
    )
    gain_db: tuple[Decibels, Decibels] = (0.0, 0.0)  # gain of microphones 1 and 2 [dB]
    invert: tuple[bool, bool] = (False, False)  # invert the polarity of microphones 1 and 2
    roll_off_hz: tuple[Corner, Corner] = (0.0, 0.0)  # low-frequency roll-off of microphones 1 and 2 [Hz]
    latency_ms: Annotated[float, Field(gt=0, le=1000)] = 50.0  # latency requested from the sound card [ms]
    buffer_s: Annotated[float, Field(ge=1, le=600)] = 60.0  # audio that is buffered while a separation computes [s]
    rate_hz: Annotated[int, Field(ge=16000, le=48000)] = 16000  # of both microphones [Hz]
    hop_ms: Annotated[int, Field(ge=1, le=20)] = 10  # one step of the mission: a stop takes effect within it [ms]
    frame: Annotated[int, Field(ge=128, le=8192, multiple_of=2)] | None = (
        None  # STFT frame of the separation [samples]; absent: a power of two near 0.1 s
    )
    overlap: Annotated[float, Field(ge=0.25, le=0.9)] = 0.75  # of neighbouring frames, as a share of the frame

    @property
    def microphone_channels(self) -> tuple[int, int]:
        """Channels of microphones 1 and 2, from 0: those of the file, else the preset's, else 0 and 1."""
        preset = PRESETS.get(self.preset)
        return self.channels or (preset.channels if preset else (0, 1))

    @property
    def known_spacing(self) -> float | None:
        """Distance between the two microphones by the preset [m]; None when it is not known."""
        preset = PRESETS.get(self.preset)
        return preset.spacing(self.microphone_channels) if preset else None


class EgoNoise(Table):
    """[ego_noise]: noise of the vehicle itself."""

    learn: bool = False  # in the lead-in, while nobody talks; it is re-estimated in all that is heard from then on
    rotors_m: tuple[tuple[Metres, Metres, Metres], ...] = ()  # ahead, to the left and above the array's centre
    blades: Annotated[int, Field(ge=1, le=8)] = 2  # of every rotor: where its tones are, once its speed is told

    @model_validator(mode="after")
    def _apart(self) -> EgoNoise:
        for place in self.rotors_m:
            if sum(x * x for x in place) < NEAREST_M**2:
                raise ValueError(f"rotors_m: expected places at least {NEAREST_M:g} m from the array, got {place}")
        if self.rotors_m and not self.learn:
            raise ValueError("rotors_m: expected learn = true beside them, got false")
        return self


class Actuator(Table):
    """[actuator]: the actuator that turns the array; options belong to the back end."""

    kind: str = "tb6600"  # back end, see `ross actuators`
    options: dict[str, Any] = Field(default_factory=dict)  # a table of the back end's own


class Guard(Table):
    """[guard]: limits and what to do on a fault."""

    lower_deg: Degrees = -200.0  # lowest joint angle, never below the hardware's
    upper_deg: Degrees = 200.0  # highest joint angle, never above the hardware's
    max_speed_deg_s: Positive = 225.0  # no move is faster
    max_acceleration_deg_s2: Positive = 112.5  # no move accelerates or brakes harder
    max_move_s: Annotated[float, Field(gt=0, le=3600)] = 30.0  # a move that takes longer is a fault [s]
    watchdog_s: Age = 0.5  # feedback that is older than this while moving is a fault [s]
    on_fault: Literal["hold", "release", "park"] = (
        "hold"  # hold: stay energised; release: let go; park: go to park_deg, then hold
    )
    park_deg: Degrees = 0.0  # where to park

    @model_validator(mode="after")
    def _ordered(self) -> Guard:
        if self.lower_deg >= self.upper_deg:
            raise ValueError(f"expected lower_deg below upper_deg, got {self.lower_deg:g} and {self.upper_deg:g}")
        if not self.lower_deg <= self.park_deg <= self.upper_deg:
            raise ValueError(
                f"park_deg: expected {self.lower_deg:g} to {self.upper_deg:g}, the limits, got {self.park_deg:g}"
            )
        return self


class Mount(Table):
    """[mount]: where the base points."""

    source: Literal["fixed", "autopilot"] = "fixed"  # autopilot: from the link of that role
    yaw_deg: Degrees | None = (
        None  # of a fixed base, clockwise from north as on a compass; absent: unknown, mount frame
    )
    fresh_s: Age = 0.5  # an older attitude counts as unknown
    follow_deg: Annotated[float, Field(ge=0.1, le=45)] = 2.0  # while listening, turn at a larger heading error
    height_m: Annotated[float, Field(ge=0, le=500)] | Literal["autopilot"] | None = (
        None  # of the array above the mouths of those who talk; "autopilot": above home, less 1.6 m; absent: not known
    )

    @model_validator(mode="after")
    def _height_is_known(self) -> Mount:
        if self.height_m == "autopilot" and self.source != "autopilot":
            raise ValueError("height_m = 'autopilot': expected source = 'autopilot' beside it, got 'fixed'")
        return self
