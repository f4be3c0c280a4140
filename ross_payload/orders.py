"""What an operator, a ground station or a timer asks of the payload.

Orders cross to the mission inside an Input, so that a recorded session replays them. Every angle is in radians,
counter-clockwise, in the frame of the mount's attitude (earth frame when that is known, else mount frame).
"""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Order:
    """The root of all orders; ``number`` ties the mission's answers to it, 0: nobody waits for one."""

    number: int = field(default=0, kw_only=True)


@dataclass(frozen=True, slots=True)
class Stop(Order):
    """Decelerate now, end the task, and refuse to move until `Rearm`."""


@dataclass(frozen=True, slots=True)
class Cancel(Order):
    """Decelerate now and end the task."""


@dataclass(frozen=True, slots=True)
class Shutdown(Order):
    """Decelerate now, end the task and the whole session."""


@dataclass(frozen=True, slots=True)
class Rearm(Order):
    """Accept moves again after a stop or a fault."""


@dataclass(frozen=True, slots=True)
class Set(Order):
    """Change one setting in flight; it holds from the next task on."""

    name: str  # of `ross_payload.config.parameter_table`
    value: float


@dataclass(frozen=True, slots=True)
class Task(Order):
    """The root of what takes time: one task at a time."""


@dataclass(frozen=True, slots=True)
class Explore(Task):
    """Find K and every azimuth."""


@dataclass(frozen=True, slots=True)
class Seek(Task):
    """Find the enrolled voice and listen to it: the whole of Algorithms 1 and 2."""


@dataclass(frozen=True, slots=True)
class ListenTo(Task):
    """Turn to the alignment for one source of the latest estimate and listen to it."""

    source: int


@dataclass(frozen=True, slots=True)
class ListenAt(Task):
    """Listen to whoever is at an azimuth: the source of the latest estimate that is near, else one that is new."""

    azimuth: float  # [rad]


@dataclass(frozen=True, slots=True)
class Informed(Task):
    """Find the enrolled voice among sources that are told from outside, without exploring."""

    azimuths: tuple[float, ...]  # [rad]
    first: int | None = None  # which of them is visited first


@dataclass(frozen=True, slots=True)
class Home(Task):
    """Find the zero of the joint, or declare that it stands there; after a fault also arm again."""


@dataclass(frozen=True, slots=True)
class TurnTo(Task):
    """Point the axis from microphone 1 to microphone 2 to a heading and stay there."""

    heading: float  # [rad]


@dataclass(frozen=True, slots=True)
class Point(Task):
    """Point by hand; the next one takes the place of this one without a halt, and any other task ends it.

    One of ``joint`` and ``heading`` is told, or neither: then the array turns at ``rate`` until the next one.
    """

    joint: float | None = None  # joint angle, modulo a turn [rad]
    heading: float | None = None  # held while the base turns [rad]
    rate: float | None = None  # [rad/s]: with an angle the most; alone signed, 0: stand still
    park: bool = False  # ``joint`` is the parking position: no other turn of it


@dataclass(frozen=True, slots=True)
class Park(Task):
    """Turn to the parking position of the configuration."""


@dataclass(frozen=True, slots=True)
class MeasureNoise(Task):
    """Listen at rest while no one talks; later tasks use it instead of their own lead-in."""

    seconds: float  # [s]


@dataclass(frozen=True, slots=True)
class Enrol(Task):
    """Enrol the talker at one source of the latest estimate, or at an azimuth: turn, separate, learn the voice.

    ``consent`` says that the talker has agreed; without it nothing is enrolled.
    """

    source: int | None = None  # either this
    azimuth: float | None = None  # or this [rad]
    seconds: float = 0.0  # of speech [s], 0: as the configuration says
    name: str = ""  # of the stored print, empty: "talker-" and the lowest number that none has
    consent: bool = False
