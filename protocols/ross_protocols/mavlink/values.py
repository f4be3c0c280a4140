"""What telemetry says, as values: SI units, radians, counter-clockwise, and None for what is not known.

One value is one MAVLink message. ``codec`` turns values into messages and back; nothing else knows what the wire
looks like. Headings and azimuths are in the earth frame (0 at north) when ``earth`` is true, else in the mount frame.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from ross_protocols.mavlink.stream_values import StreamReport

DIALECT_VERSION = 4
CURVE_POINTS = 80


class Rule(IntEnum):
    """Why a heading was chosen: ROSS_ALIGNMENT_RULE."""

    UNKNOWN = 0
    BISECTOR = 1
    ARGMAX = 2
    STAY = 3
    GAIN = 4
    LIMITED = 5


class CandidateState(IntEnum):
    """What became of an alignment candidate: ROSS_CANDIDATE_STATE."""

    PLANNED = 0
    TURNING = 1
    REJECTED = 2
    ACCEPTED = 3


class Phase(IntEnum):
    """Which separation: ROSS_SEPARATION_PHASE."""

    CHECK = 1
    RUN = 2


class Health(IntEnum):
    """How a component is: MAV_STATE."""

    BOOT = 1
    CALIBRATING = 2
    STANDBY = 3
    ACTIVE = 4
    CRITICAL = 5


class Severity(IntEnum):
    """How much a text matters: MAV_SEVERITY."""

    CRITICAL = 2
    ERROR = 3
    WARNING = 4
    NOTICE = 5
    INFO = 6


class RecordingState(IntEnum):
    """What the recorder does: ROSS_RECORDING_STATE."""

    OFF = 0
    ON = 1
    FULL = 2
    BROKEN = 3


@dataclass(frozen=True, slots=True)
class Heartbeat:
    """The component is alive."""

    health: Health
    state: int  # of the mission: ROSS_STATE


@dataclass(frozen=True, slots=True)
class Text:
    """At most 50 characters of ASCII for a human; longer ones go in chunks that share an id."""

    severity: Severity
    text: str
    id: int = 0  # 0: one chunk, all of it
    chunk: int = 0


@dataclass(frozen=True, slots=True)
class Information:
    """Who the payload is and what it can do: ROSS_INFORMATION."""

    time_usec: int  # [us]
    spacing: float  # [m]
    speed_of_sound: float  # [m/s]
    axis_offset: float  # heading of the axis at joint angle 0, in the mount frame [rad]
    joint_lower: float | None  # [rad], None: continuous
    joint_upper: float | None  # [rad], None: continuous
    joint_speed: float | None  # [rad/s]
    unit: float  # T_unit [s]
    rate: int  # [Hz]
    k_max: int
    software_version: str  # at most 24 characters
    actuator: str  # at most 16 characters
    dialect_version: int = DIALECT_VERSION


@dataclass(frozen=True, slots=True)
class Status:
    """The mission at a glance: ROSS_STATUS."""

    time_usec: int  # [us]
    mission_time: float  # [s], to the millisecond on the wire
    state: int  # ROSS_STATE
    earth: bool
    outcome: int | None = None  # ROSS_OUTCOME, None: not over
    heading: float | None = None  # [rad]
    heading_goal: float | None = None  # [rad]
    joint: float | None = None  # [rad], not wrapped
    joint_rate: float | None = None  # [rad/s]
    mount_yaw: float | None = None  # [rad]
    score: float | None = None
    criterion: float | None = None
    rotation: int = 0  # r
    rotation_max: int = 0  # R
    k: int | None = None
    target: int | None = None  # index of a source
    noise_measured: bool = False
    certain: bool = False
    target_found: bool = False
    time_unix: bool = False  # time_usec is UNIX time, else since boot
    streaming: bool = False  # what is heard leaves the payload live
    recording: bool = False  # what is heard is kept on a disk
    actuator_present: bool = False
    settled: bool = False
    homed: bool = False
    fault: bool = False
    open_loop: bool = False


@dataclass(frozen=True, slots=True)
class Source:
    """One source of an estimate: ROSS_SOURCE."""

    time_usec: int  # [us]
    estimate: int  # number of the estimate
    source: int  # index
    count: int  # K
    azimuth: float  # [rad]
    sigma: float  # [rad]
    confidence: float  # probability that a talker is within 10 deg
    weight: float  # 0 to 1
    earth: bool
    resolved: bool
    mirror: float | None = None  # [rad]
    elevation: float | None = None  # [rad]
    score: float | None = None
    target: bool = False
    final: bool = False
    tracked: bool = False  # followed while the mission listens: rate and age mean something
    rate: float | None = None  # of the azimuth [rad/s], None: at rest or not tracked
    age: float | None = None  # since it was heard last [s], None: it talks or is not tracked


@dataclass(frozen=True, slots=True)
class Alignment:
    """One alignment candidate of a plan: ROSS_ALIGNMENT."""

    time_usec: int  # [us]
    plan: int  # number of the plan
    candidate: int  # index
    count: int
    source: int  # the isolated one
    heading: float  # [rad]
    joint: float  # [rad], not wrapped
    isolation: float  # [s]
    aliased: tuple[int, ...]  # ascending indices of sources, each below 32
    rule: Rule
    state: CandidateState
    earth: bool
    gain: float | None = None  # predicted SI-SDRi [dB]


@dataclass(frozen=True, slots=True)
class Separation:
    """One separated group: ROSS_SEPARATION."""

    time_usec: int  # [us]
    separation: int  # number of the separation
    group: int  # index
    count: int
    phase: Phase
    members: tuple[int, ...]  # ascending indices of sources, each below 32
    method: str  # at most 16 characters
    earth: bool
    heading: float | None = None  # [rad]
    score: float | None = None
    criterion: float | None = None
    si_sdr: float | None = None  # [dB]
    si_sdri: float | None = None  # [dB]
    accepted: bool = False
    target: bool = False


@dataclass(frozen=True, slots=True)
class Audio:
    """How the microphones are: ROSS_AUDIO."""

    time_usec: int  # [us]
    trouble: int = 0  # ROSS_AUDIO_TROUBLE
    level: tuple[float, ...] = (-120.0, -120.0)  # of each microphone [dB re full scale]
    peak: tuple[float, ...] = (-120.0, -120.0)  # [dB re full scale]
    lost: int = 0  # samples
    reopened: int = 0
    waiting: float = 0.0  # [s]
    rate: float | None = None  # [Hz]


@dataclass(frozen=True, slots=True)
class Recording:
    """What the recorder does: ROSS_RECORDING."""

    time_usec: int  # [us]
    state: RecordingState = RecordingState.OFF
    duration: float = 0.0  # [s]
    free: float | None = None  # [bytes]
    name: str = ""  # at most 40 characters
    reason: str = ""  # at most 48 characters


@dataclass(frozen=True, slots=True)
class Density:
    """The ITD density of one orientation: ROSS_DENSITY."""

    time_usec: int  # [us]
    exploration: int  # its number
    rotation: int  # r
    heading: float  # [rad]
    earth: bool
    first: float  # ITD of the first point [s]
    last: float  # ITD of the last point [s]
    density: tuple[float, ...]  # CURVE_POINTS shares of the maximum, 0 to 1


@dataclass(frozen=True, slots=True)
class Isolation:
    """How well each heading isolates one source: ROSS_ISOLATION."""

    time_usec: int  # [us]
    plan: int  # number of the plan
    source: int  # index
    earth: bool
    first: float  # heading of the first point [rad], not wrapped
    last: float  # heading of the last point [rad], not wrapped
    maximum: float  # [s]
    isolation: tuple[float, ...]  # CURVE_POINTS shares of the maximum, 0 to 1


@dataclass(frozen=True, slots=True)
class LinkReport:
    """How one link is, and what went through it since the start: ROSS_LINK."""

    time_usec: int  # [us]
    link: int  # index
    count: int  # of links
    url: str  # at most 60 characters
    up: bool
    autopilot: bool
    sent: int = 0  # frames
    dropped: int = 0  # frames
    received: int = 0  # frames
    lost: int | None = 0  # frames; None: some are missing, and a router may have kept them to itself
    bad: int = 0
    refused: int = 0  # frames
    reconnects: int = 0


@dataclass(frozen=True, slots=True)
class Named:
    """One number with a name, for ground stations that do not know our dialect: NAMED_VALUE_FLOAT."""

    time: float  # since boot [s]
    name: str  # at most 10 characters
    value: float


@dataclass(frozen=True, slots=True)
class Array:
    """Some numbers with a name, for ground stations that do not know our dialect: DEBUG_FLOAT_ARRAY."""

    time_usec: int  # [us]
    name: str  # at most 10 characters
    id: int
    numbers: tuple[float, ...]  # 58 at most; zeros at the end are not told from none


Value = (
    Heartbeat | Text | Information | Status | Source | Alignment | Separation | Audio | Recording | Density | Isolation
    | LinkReport | StreamReport | Named | Array
)  # fmt: skip
