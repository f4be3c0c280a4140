"""Opening a flight: a telemetry log of anybody, or a session folder."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ross_payload.errors import refused_as
from ross_payload.ground.errors import GroundError
from ross_payload.ground.flights.bookmarks import Bookmark, marks_of
from ross_payload.ground.flights.log_file import (
    CALENDAR_FROM_US,
    CALENDAR_UNTIL_US,
    EXPECTED,
    LogFile,
    is_simulated,
    seconds_of,
)
from ross_payload.ground.flights.tlog_index import Damage, Index, scan
from ross_protocols.mavlink.codec import Decoder, Packet
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import MESSAGES, common
from ross_protocols.mavlink.tunnel import OURS
from ross_protocols.mavlink.vehicle import AUTOPILOT

LOGS = ("telemetry.tlog", "mission.tlog")  # of a session folder, of the results of a simulation
UNPACKED, SOUND = "unpacked.tlog", "sound.json"  # of an MCAP file
MANIFEST = 1 << 16  # [bytes] that a session.json has at most
MIRRORS = (common.MAVLINK_MSG_ID_NAMED_VALUE_FLOAT, common.MAVLINK_MSG_ID_DEBUG_FLOAT_ARRAY)
SAMPLE = 500  # mirrors that are looked at to know a payload without our dialect
MOST_NAMES = 6  # that a note lists
OUR_IDS = [number for number, message in MESSAGES.items() if message.msgname.startswith(OURS)]
LOOKS = (
    (b"\xa3\x95", "an ArduPilot flight log (.bin)"),
    (b"ULog", "a PX4 flight log (.ulg)"),
    (b"\x89MCAP", "an MCAP file"),
    (b"\xd4\xc3\xb2\xa1", "a network capture"),
    (b"\n\r\r\n", "a network capture"),
)  # by how a file begins


@dataclass(frozen=True, slots=True)
class UnpackedSound:
    """What lies beside the log of an MCAP file; times are those of the file [s]."""

    begins: dict[str, float]  # of the tracks
    origin: float | None  # of the times in the flight; None: its first frame
    duration: float  # from there to the last end
    notes: list[str]


@dataclass(frozen=True, slots=True)
class Flight:
    """A log that was opened: what is in it, and where. Times are seconds since its first frame."""

    name: str
    path: Path
    start: float | None  # UNIX time of its first frame [s]; None: the log does not know
    duration: float  # [s]
    payloads: tuple[ComponentId, ...]
    notes: tuple[str, ...]  # what is odd about it, in words
    marks: tuple[Bookmark, ...]  # state changes and texts, in order
    index: Index
    at: NDArray[np.float64]  # of every frame [s], never falling
    file: LogFile

    @property
    def simulated(self) -> bool:
        """Whether its times are those of a simulation, and no time of day is known."""
        return self.start is None and len(self.index) > 0 and is_simulated(int(self.index.usec[0]))

    def packets(self, which: NDArray[np.int64]) -> Iterator[tuple[float, Packet]]:
        """Yield times and packets of the frames with these numbers, in their order."""
        yield from _packets(self.file, self.index, self.at, which)


def open_flight(path: Path, obsolete: Callable[[], bool] = lambda: False) -> Flight:
    """Open a telemetry log, or a folder with one; ``obsolete`` says that nobody waits for it any longer.

    Raises
    ------
    GroundError
        When it is none, cannot be read, or nobody waits.
    """
    log = _find(path)
    file = LogFile(log)
    index, damage = scan(file, obsolete)
    unpacked = unpacked_sound(log)
    if not len(index) and unpacked is None:
        raise GroundError(f"{log}: {EXPECTED}, got {_kind(file)}")
    if unpacked is not None and not len(index):
        return _sound_alone(path, log, index, file, unpacked)
    at, start, steps = seconds_of(index.usec)
    payloads = _payloads(file, index, at)
    manifest, odd = _manifest(log)
    marks, until = marks_of(index, payloads, float(at[-1]), lambda which: _packets(file, index, at, which))
    odd += [f"events after {until:.0f} s are too many to be listed"] if until < at[-1] else []
    odd += [] if unpacked is None else unpacked.notes
    notes = (*_damaged(damage), *_strange(index, payloads), *_clock(steps), *odd)
    name = log.parent.resolve().name if log != path or log.name == LOGS[0] else log.name
    started = start if start is not None else _unix(manifest.get("started"))
    return Flight(name, log, started, float(at[-1]), payloads, notes, marks, index, at, file)


def unpacked_sound(log: Path) -> UnpackedSound | None:
    """Read what lies beside the log of an MCAP file; None: it is another log."""
    if log.name != UNPACKED:
        return None
    try:
        told = json.loads((log.parent / SOUND).read_bytes())
        return UnpackedSound(**told)
    except (OSError, ValueError, TypeError) as error:
        raise GroundError(f"{log.parent / SOUND}: cannot be read: {error}") from error


def _sound_alone(path: Path, log: Path, index: Index, file: LogFile, sound: UnpackedSound) -> Flight:
    """Return a flight without a frame."""
    origin = sound.origin or 0.0
    start = origin if origin * 1e6 > CALENDAR_FROM_US else None
    nothing = np.zeros(0)
    return Flight(path.name, log, start, sound.duration, (), tuple(sound.notes), (), index, nothing, file)


def who_of(sender: int) -> ComponentId:
    """Return whom a number of the index stands for.

    >>> str(who_of(256 + 191))
    '1-191'
    """
    return ComponentId(sender >> 8, sender & 255)


def name_of(message: int) -> str:
    """Return the name of a message, or its number when nobody here knows it."""
    return str(MESSAGES[message].msgname) if message in MESSAGES else str(message)


def _find(path: Path) -> Path:
    """Return the log that is meant."""
    with refused_as(GroundError, f"{path}: cannot be read"):
        if not path.is_dir():
            return path
        log = next((path / name for name in (*LOGS, UNPACKED) if (path / name).exists()), None)
    if log is None:
        raise GroundError(f"{path}: {EXPECTED}, got a folder without {' or '.join(LOGS)}")
    return log


def _packets(
    file: LogFile, index: Index, at: NDArray[np.float64], which: NDArray[np.int64]
) -> Iterator[tuple[float, Packet]]:
    decoder = Decoder()
    columns = (index.start[which].tolist(), index.size[which].tolist(), at[which].tolist())
    for start, size, time in zip(*columns, strict=True):
        for packet in decoder.feed(file.read(start, size)):
            yield time, packet


def _payloads(file: LogFile, index: Index, at: NDArray[np.float64]) -> tuple[ComponentId, ...]:
    """Who says something of our dialect, or a mirror of it."""
    ours = set(np.unique(index.sender[np.isin(index.message, OUR_IDS)]).tolist())
    mirrors = np.isin(index.message, MIRRORS) & ~np.isin(index.sender, list(ours))
    for sender in np.unique(index.sender[mirrors]).tolist():
        which = np.flatnonzero(mirrors & (index.sender == sender))[:SAMPLE]
        names = (packet.message.name for _, packet in _packets(file, index, at, which))
        if any(name.startswith("ross_") for name in names):
            ours.add(sender)
    return tuple(who for who in map(who_of, sorted(ours)) if who.component != AUTOPILOT)


def _kind(file: LogFile) -> str:
    """Tell what a file seems to be that is no log."""
    head = file.read(0, 1 << 16)
    if not file.size:
        return "an empty file"
    if any(Decoder().feed(head[:4096])):
        return "MAVLink without times (a .raw file)"
    text = "a text" if head.isascii() and b"\0" not in head else "no frame of MAVLink"
    return next((words for begin, words in LOOKS if head.startswith(begin)), text)


def _manifest(log: Path) -> tuple[dict[str, Any], list[str]]:
    """Read what a session folder says of itself, and what is odd about it."""
    path = log.parent / "session.json"
    if log.name != LOGS[0] or not path.exists():
        return {}, []
    try:
        file = LogFile(path)
        manifest = json.loads(file.read(0, MANIFEST))
    except (GroundError, ValueError, RecursionError):
        return {}, ["session.json cannot be read"]
    if not isinstance(manifest, dict):
        return {}, ["session.json does not describe a session"]
    return manifest, ["the session was cut off"] if manifest.get("end") is None else []


def _unix(started: Any) -> float | None:
    try:
        began = datetime.fromisoformat(str(started))
        time = (began if began.tzinfo else began.replace(tzinfo=UTC)).timestamp()
    except (ValueError, OverflowError, OSError):
        return None
    return time if CALENDAR_FROM_US < time * 1e6 < CALENDAR_UNTIL_US else None


def _damaged(damage: Damage) -> list[str]:
    notes = []
    if damage.skipped:
        places = "1 place" if damage.holes == 1 else f"{damage.holes} places"
        notes.append(f"{damage.skipped} bytes in {places} are no frames and were skipped")
    if damage.wrong:
        words = f"{damage.wrong.total()} frames have a wrong checksum (damaged, or of another dialect)"
        notes.append(f"{words}: {_listed(damage.wrong)}")
    return [*notes, "the last frame is cut off"] if damage.cut else notes


def _strange(index: Index, payloads: tuple[ComponentId, ...]) -> list[str]:
    """Tell of messages that nobody here knows, and of a log that is somebody else's."""
    numbers, counts = np.unique(index.message, return_counts=True)
    found = Counter(dict(zip(numbers.tolist(), counts.tolist(), strict=True)))
    unknown = Counter({number: count for number, count in found.items() if number not in MESSAGES})
    notes = [f"messages of another dialect: {_listed(unknown)}"] if unknown else []
    if payloads:
        return notes
    systems = sorted({sender >> 8 for sender in np.unique(index.sender).tolist()})
    whose = f"system{'s' if len(systems) > 1 else ''} {', '.join(map(str, systems[:MOST_NAMES]))}"
    return [f"no messages of a payload: this is a log of {whose}: {_listed(found)}", *notes]


def _listed(found: Counter[int]) -> str:
    most = [f"{name_of(number)} x {count}" for number, count in found.most_common(MOST_NAMES)]
    return ", ".join(most + ["..."] * (len(found) > MOST_NAMES))


def _clock(steps: int) -> list[str]:
    times = "once" if steps == 1 else f"{steps} times"
    return [f"the clock of the log jumped {times}: the jumps are left out"] if steps else []
