"""Configuration: frozen models of one TOML file. Units stand in the names here and nowhere else."""

from __future__ import annotations

import math
import tomllib
from itertools import combinations
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from ross_payload.errors import ConfigError

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Degrees = Annotated[float, Field(allow_inf_nan=False)]
Azimuths = Annotated[tuple[Degrees, ...], Field(min_length=1, max_length=6)]
Elevation = Annotated[float, Field(ge=-90, le=90)]
Model = TypeVar("Model", bound=BaseModel)

APART_DEG = 1.0  # sources told from outside that are nearer than this are one


class Table(BaseModel):
    """A table of the file: frozen, and an unknown key is an error."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class Array(Table):
    """[array]: the two microphones."""

    spacing_m: Annotated[float, Field(ge=0.005, le=1.0)] = 0.05  # d, between the microphones [m]
    speed_of_sound_m_s: Annotated[float, Field(ge=250, le=450)] = 343.0  # v_p [m/s]; 331 at 0 deg Celsius, 343 at 20
    offset_deg: Degrees = 0.0  # heading of the axis from microphone 1 to 2 when the joint angle and mount yaw are 0


class Audio(Table):
    """[audio]: rates and frames."""

    rate_hz: Annotated[int, Field(ge=16000, le=48000)] = 16000  # of both microphones [Hz]
    hop_ms: Annotated[int, Field(ge=1, le=20)] = 10  # one step of the mission: a stop is obeyed within it [ms]
    frame: Annotated[int, Field(ge=128, le=8192, multiple_of=2)] = 2048  # STFT frame of the separation [samples]
    overlap: Annotated[float, Field(ge=0.25, le=0.9)] = 0.75  # of neighbouring frames, as a share of the frame


class Actuator(Table):
    """[actuator]: what turns the array; options are the back end's own."""

    kind: str = "tb6600"  # back end, see `ross actuators`
    options: dict[str, Any] = Field(default_factory=dict)  # a table of the back end's own


class Guard(Table):
    """[guard]: limits and what to do on a fault."""

    lower_deg: Degrees = -200.0  # lowest joint angle, never below the hardware's own
    upper_deg: Degrees = 200.0  # highest joint angle, never above the hardware's own
    max_speed_deg_s: Positive = 225.0  # no move is faster
    max_acceleration_deg_s2: Positive = 112.5  # no move accelerates or brakes harder
    max_move_s: Positive = 30.0  # a move that takes longer is a fault [s]
    watchdog_s: Positive = 0.5  # feedback that is older than this while moving is a fault [s]
    on_fault: Literal["hold", "release", "park"] = (
        "hold"  # hold: stay energised; release: let go; park: go to park_deg, then hold
    )
    park_deg: Degrees = 0.0  # where to park

    @model_validator(mode="after")
    def _ordered(self) -> Guard:
        if self.lower_deg >= self.upper_deg:
            raise ValueError(f"lower_deg = {self.lower_deg:g} must be below upper_deg = {self.upper_deg:g}")
        if not self.lower_deg <= self.park_deg <= self.upper_deg:
            raise ValueError(f"park_deg = {self.park_deg:g} must lie within the limits")
        return self


class Mount(Table):
    """[mount]: where the base points."""

    yaw_deg: Degrees | None = None  # clockwise from north, as on a compass; absent: unknown, mount frame


class Explore(Table):
    """[explore]: find K and every azimuth."""

    method: str = "joint"  # explorer: `joint`, `markov`, or `markov-plain`, the paper's own histograms
    options: dict[str, Any] = Field(default_factory=dict)  # a table of the explorer's own
    frame: Annotated[int, Field(ge=128, le=8192, multiple_of=2)] | None = (
        None  # STFT frame [samples]; absent: about 43 ms
    )
    overlap: Annotated[float, Field(ge=0.25, le=0.9)] = 0.75  # of these frames, as a share of the frame
    lead_in_s: Annotated[float, Field(ge=0, le=60)] = 2.0  # listened to before anything turns, for the noise
    unit_s: Annotated[float, Field(ge=0.5, le=60)] = 3.0  # T_unit
    step_deg: Annotated[float, Field(ge=1, le=90)] = 15.0  # one rotation
    min_rotations: Annotated[int, Field(ge=1, le=24)] = 4  # at least so many, however certain the explorer is
    max_rotations: Annotated[int, Field(ge=1, le=24)] = 12  # at most so many
    pipelined: bool = False  # go to promising alignments before the exploration ends

    @model_validator(mode="after")
    def _ordered(self) -> Explore:
        if self.min_rotations > self.max_rotations:
            raise ValueError(f"min_rotations = {self.min_rotations} is above max_rotations = {self.max_rotations}")
        return self


class Informed(Table):
    """[informed]: where the sources are, told from outside; the mission begins without exploring."""

    azimuths_deg: Azimuths  # frame of the mount, as in a scenario
    elevations_deg: tuple[Elevation, ...] | None = None  # one for each azimuth; absent: level with the array
    sigma_deg: Annotated[float, Field(gt=0, le=45)] = 2.0  # one standard deviation of every azimuth
    target: Annotated[int, Field(ge=0)] | None = None  # which of them is visited first, counted from 0

    @model_validator(mode="after")
    def _possible(self) -> Informed:
        count, heights = len(self.azimuths_deg), self.elevations_deg or (0.0,) * len(self.azimuths_deg)
        if len(heights) != count:
            raise ValueError(f"{len(heights)} elevations_deg for {count} azimuths_deg")
        if self.target is not None and self.target >= count:
            raise ValueError(f"target = {self.target}, counted from 0, but there are {count} azimuths_deg")
        for i, j in combinations(range(count), 2):
            apart = abs((self.azimuths_deg[i] - self.azimuths_deg[j] + 180) % 360 - 180)
            if apart < APART_DEG and abs(heights[i] - heights[j]) < APART_DEG:
                raise ValueError(f"azimuths_deg {i} and {j} are {apart:g} deg apart, wanted {APART_DEG:g} at least")
        return self


class Exploit(Table):
    """[exploit]: turn, separate, recognise, keep listening."""

    separator: str = "auto"  # `auto`, or one of the separators
    rules: Literal["best", "paper"] = "best"  # where to turn: best predicted gain, or the paper's equations
    check_s: Annotated[float, Field(ge=0.5, le=60)] = 3.0  # T_check
    run_s: Annotated[float, Field(ge=1, le=600)] = 10.0  # T_run
    runs: Annotated[int, Field(ge=0)] = 1  # how many T_run before the mission is done; 0: until stopped
    criterion: Annotated[float, Field(allow_inf_nan=False)] = 0.0  # accept a voice above this score
    max_restarts: Annotated[int, Field(ge=0)] = 2  # how often to start again when the target's score drops


class Telemetry(Table):
    """[telemetry]: who we are on MAVLink and where we speak."""

    urls: tuple[str, ...] = ()  # where to send MAVLink: udpin, udpout, tcp or serial
    system_id: Annotated[int, Field(ge=1, le=255)] = 1  # of the vehicle that carries the payload
    component_id: Annotated[int, Field(ge=1, le=255)] = 191  # 191: onboard computer


class Config(Table):
    """The whole file."""

    array: Array = Array()
    audio: Audio = Audio()
    actuator: Actuator = Actuator()
    guard: Guard = Guard()
    mount: Mount = Mount()
    explore: Explore = Explore()
    informed: Informed | None = None
    exploit: Exploit = Exploit()
    telemetry: Telemetry = Telemetry()
    seed: Annotated[int, Field(ge=0)] = 0

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


def read_toml(path: Path) -> dict[str, Any]:
    """Read a TOML file.

    Raises
    ------
    ConfigError
        When the file is missing, unreadable or not TOML.
    """
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not UTF-8 text"
        raise ConfigError(f"{path}: cannot be read: {reason}") from error
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{path}: not TOML: {error}") from error


def validated(model: type[Model], values: Any, where: str) -> Model:
    """Check values against a model.

    Raises
    ------
    ConfigError
        With one line that names the first wrong key, what was found and what was wanted.
    """
    try:
        return model.model_validate(values)
    except ValidationError as error:
        raise ConfigError(f"{where}: {_explain(error)}") from error


def load(path: Path) -> Config:
    """Load one TOML file; what it does not say has the default, and nothing else is merged."""
    return validated(Config, read_toml(path), str(path))


def _explain(error: ValidationError) -> str:
    first, others = error.errors()[0], error.error_count() - 1
    key = ".".join(str(part) for part in first["loc"]) or "file"
    if first["type"] == "extra_forbidden":
        text = f"unknown key '{key}'"
    else:
        text = f"{key}: {first['msg'].removeprefix('Value error, ')}"
        if not isinstance(first["input"], dict):
            text += f" (found {first['input']!r})"
    return text + (f"; and {others} more" if others else "")
