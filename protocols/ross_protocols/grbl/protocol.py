"""What crosses the serial line of a controller with grbl 1.1: lines both ways, and single bytes that act at once.

One axis of grbl carries the turn. Its "millimetre" is one degree, so that $100 is steps per degree, $110 degrees per
minute and $120 degrees per second squared. Degrees are converted here and nowhere else; positive is counter-clockwise.

After the interface and jogging pages of grbl 1.1.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

from ross_protocols.grbl.error_texts import alarm_words, error_words

STATUS, HOLD, RESET, JOG_CANCEL = b"?", b"!", b"\x18", b"\x85"
LONGEST = 256  # line that is kept; grbl's own are below 128
AXES = "XYZABC"
STEPS, MAX_RATE, ACCELERATION, TRAVEL = 100, 110, 120, 130  # plus the number of the axis
IDLE_DELAY, REPORT_MASK, SOFT_LIMITS, HOMING = 1, 10, 20, 22
INCHES = 13
MIN_FEED = 1.0  # grbl moves no slower [mm/min]
_NUMBER = re.compile(r"-?\d{1,9}(?:\.\d{1,6})?")
_STATE = re.compile(r"([A-Z][a-z]+)(?::(\d))?")


class State(StrEnum):
    """What grbl does."""

    IDLE = "Idle"
    RUN = "Run"
    HOLD = "Hold"
    JOG = "Jog"
    HOME = "Home"
    ALARM = "Alarm"
    DOOR = "Door"
    CHECK = "Check"
    SLEEP = "Sleep"


SUBSTATES = {
    (State.HOLD, 0): "held, ready to resume",
    (State.HOLD, 1): "coming to a hold",
    (State.DOOR, 0): "door closed, ready to resume",
    (State.DOOR, 1): "stopped, the door is open",
    (State.DOOR, 2): "the door is open, coming to a stop",
    (State.DOOR, 3): "door closed, resuming",
}


@dataclass(frozen=True, slots=True)
class Ok:
    """The line was taken."""


@dataclass(frozen=True, slots=True)
class Error:
    """The line was refused."""

    number: int

    @property
    def words(self) -> str:
        """Why."""
        return error_words(self.number)


@dataclass(frozen=True, slots=True)
class Alarm:
    """It has stopped and locked itself."""

    number: int

    @property
    def words(self) -> str:
        """Why."""
        return alarm_words(self.number)


@dataclass(frozen=True, slots=True)
class Banner:
    """It has started, or was reset."""

    version: str


@dataclass(frozen=True, slots=True)
class Setting:
    """One line of ``$$``, as a bare number."""

    number: int
    value: float


@dataclass(frozen=True, slots=True)
class Info:
    """A line in brackets, such as the version."""

    key: str
    text: str


@dataclass(frozen=True, slots=True)
class Garbage:
    """A line that grbl does not say."""

    text: str


@dataclass(frozen=True, slots=True)
class Report:
    """Where it is and what it does."""

    state: State
    substate: int | None = None
    machine: tuple[float, ...] | None = None  # of every axis [rad]
    work: tuple[float, ...] | None = None  # machine less offset [rad]
    offset: tuple[float, ...] | None = None  # told now and then [rad]
    speed: float | None = None  # without sign [rad/s]
    pins: str = ""  # inputs that are active
    overrides: tuple[int, ...] | None = None  # of feed, rapids, spindle [percent]
    buffers: tuple[int, ...] | None = None  # free blocks and bytes

    @property
    def at_rest(self) -> bool:
        """Whether nothing moves, nor will by itself.

        >>> Report(State.HOLD, 0).at_rest, Report(State.HOLD, 1).at_rest
        (True, False)
        """
        if self.state in (State.HOLD, State.DOOR):
            return (self.state, self.substate) in ((State.HOLD, 0), (State.DOOR, 0), (State.DOOR, 1))
        return self.state in (State.IDLE, State.ALARM, State.SLEEP, State.CHECK)

    @property
    def doing(self) -> str:
        """The state in words.

        >>> Report(State.DOOR, 1).doing
        'Door (stopped, the door is open)'
        """
        words = SUBSTATES.get((self.state, -1 if self.substate is None else self.substate))
        return f"{self.state} ({words})" if words else str(self.state)


Message = Ok | Error | Alarm | Banner | Setting | Info | Report | Garbage


READERS: tuple[tuple[re.Pattern[str], Callable[[re.Match[str]], Message]], ...] = (
    (re.compile(r"ok"), lambda found: Ok()),
    (re.compile(r"error:(\d{1,3})"), lambda found: Error(int(found[1]))),
    (re.compile(r"ALARM:(\d{1,3})"), lambda found: Alarm(int(found[1]))),
    (re.compile(r"Grbl(?:HAL)? (\d+\.\d+\w?) \[.*\]"), lambda found: Banner(found[1])),
    (
        re.compile(r"\$(\d{1,3})=(-?\d{1,9}(?:\.\d{0,6})?)(?: *\(.*\))?"),
        lambda found: Setting(int(found[1]), float(found[2])),
    ),
    (re.compile(r"\[([A-Za-z]\w*):(.*)\]"), lambda found: Info(found[1], found[2])),
)


class Lines:
    r"""Cuts bytes into messages; what is too long or is no text is garbage, empty lines are left out.

    >>> lines = Lines()
    >>> lines.feed(b"ok"), lines.feed(b"\r\nerror:15\r\n")
    ([], [Ok(), Error(number=15)])
    """

    def __init__(self) -> None:
        self._held = b""
        self._skipping = False  # the rest of a line that was too long

    def feed(self, data: bytes) -> list[Message]:
        """Take in bytes; return the messages that are complete."""
        *lines, held = (self._held + data).split(b"\n")
        messages = [message for line in lines if (message := self._read(line)) is not None]
        if len(held) > LONGEST:
            if not self._skipping:
                messages.append(Garbage(_shown(held)))
            self._skipping, held = True, b""
        self._held = held
        return messages

    def _read(self, line: bytes) -> Message | None:
        line = line.strip(b"\r \0")
        if self._skipping:
            self._skipping = False
            return None
        return read(line) if line else None


def read(line: bytes) -> Message:
    r"""Read one line without its end.

    >>> read(b"<Jog|MPos:90.000,0.000,0.000|FS:600,0|Pn:X>").pins
    'X'
    >>> read(b"$120=112.500"), read(b"ALARM:1").words
    (Setting(number=120, value=112.5), 'alarm 1: a limit switch was hit; the position is lost')
    >>> read(b"Grbl 1.1h ['$' for help]"), read(b"gr\xff")
    (Banner(version='1.1h'), Garbage(text="b'gr\\xff'"))
    """
    text = line.decode("ascii", errors="replace")
    if len(line) > LONGEST or not (text.isascii() and text.isprintable()):
        return Garbage(_shown(line))
    for pattern, make in READERS:
        if found := pattern.fullmatch(text):
            return make(found)
    return _report(text) or Garbage(_shown(line))


def _report(text: str) -> Report | None:
    if not (text.startswith("<") and text.endswith(">")):
        return None
    doing, *parts = text[1:-1].split("|")
    fields = dict(part.partition(":")[::2] for part in parts)
    found = _STATE.fullmatch(doing)
    if found is None or found[1] not in set(State) or len(fields) != len(parts):
        return None
    numbers = {
        name: _numbers(fields[name]) for name in ("MPos", "WPos", "WCO", "F", "FS", "Ov", "Bf") if name in fields
    }
    if not all(numbers.values()) or ("MPos" in numbers) == ("WPos" in numbers):
        return None
    speed = numbers.get("FS") or numbers.get("F")
    return Report(
        state=State(found[1]),
        substate=int(found[2]) if found[2] else None,
        machine=_angles(numbers.get("MPos")),
        work=_angles(numbers.get("WPos")),
        offset=_angles(numbers.get("WCO")),
        speed=math.radians(speed[0] / 60) if speed else None,
        pins=fields.get("Pn", ""),
        overrides=_whole(numbers.get("Ov")),
        buffers=_whole(numbers.get("Bf")),
    )


def _numbers(text: str) -> tuple[float, ...]:
    """Numbers between commas; () when one is none."""
    parts = text.split(",")
    return tuple(map(float, parts)) if all(map(_NUMBER.fullmatch, parts)) else ()


def _angles(numbers: tuple[float, ...] | None) -> tuple[float, ...] | None:
    return None if numbers is None else tuple(map(math.radians, numbers))


def _whole(numbers: tuple[float, ...] | None) -> tuple[int, ...] | None:
    return None if numbers is None else tuple(map(int, numbers))


def _shown(line: bytes) -> str:
    return repr(line[:40])


def jog(axis: str, goal: float, speed: float) -> bytes:
    r"""Return the line that jogs one axis to a machine position [rad], at most at ``speed`` [rad/s].

    G53: work offsets that somebody has stored do not count. At less than 1 deg/min grbl moves at that
    (MINIMUM_FEED_RATE in its `config.h`); F0 is an error.

    >>> jog("X", math.pi / 2, math.pi)
    b'$J=G90G21G53X90.0000F10800.0\n'
    >>> jog("X", 0.0, 1e-6)
    b'$J=G90G21G53X0.0000F1.0\n'
    """
    return f"$J=G90G21G53{axis}{math.degrees(goal):.4f}F{max(math.degrees(speed) * 60, MIN_FEED):.1f}\n".encode()


def per_degree(resolution: float) -> float:
    """Return $100 for a step of so many [rad].

    >>> round(per_degree(2 * math.pi / 3200), 3)
    8.889
    """
    return 1 / math.degrees(resolution)


def rate(value: float) -> float:
    """Return $110 as [rad/s].

    >>> round(rate(10800), 4)
    3.1416
    """
    return math.radians(value / 60)
