"""Where the frames of a telemetry log are: one pass over its bytes, columns of numbers as the result.

A record is the time in microseconds as 8 bytes, big endian, and a frame. Records follow each other; where they do not,
the next place is sought where two good ones do.
"""

from __future__ import annotations

import struct
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field, fields

import numpy as np
from fastcrc.crc16 import mcrf4xx
from numpy.typing import NDArray

from ross_payload.ground.errors import GroundError
from ross_payload.ground.flights.log_file import LogFile
from ross_payload.ground.flights.resync import CHAIN, HEAD, LONGEST, STAMP, V1, V2, chained
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import MESSAGES, common, ross
from ross_protocols.mavlink.tunnel import TYPE

EXTRAS = {number: bytes([message.crc_extra]) for number, message in MESSAGES.items()}
TUNNEL = common.MAVLINK_MSG_ID_TUNNEL
INSIDE = 5  # [bytes] of TUNNEL's payload before what it carries
STATUS = ross.MAVLINK_MSG_ID_ROSS_STATUS
STRETCH = 1 << 18  # that is judged at once where records are sought [bytes]
FUTILE = 1 << 24  # so many bytes without a frame are no log [bytes]
NO_STATE = 255
_STATUS = ross.MAVLink_ross_status_message
STATE = struct.calcsize(
    _STATUS.unpacker.format[: 1 + _STATUS.ordered_fieldnames.index("state")]
)  # place in the payload


@dataclass(frozen=True, slots=True)
class Index:
    """Every good frame in the order of the file; columns of equal length."""

    start: NDArray[np.int64]  # of the frame in the file [bytes]
    size: NDArray[np.uint16]  # of the frame [bytes]
    usec: NDArray[np.int64]  # its stamp [us]
    sender: NDArray[np.uint16]  # 256 * system + component
    sequence: NDArray[np.uint8]
    message: NDArray[np.uint32]  # its id; of a TUNNEL of ours: of what it carries
    tunnelled: NDArray[np.bool_]
    state: NDArray[np.uint8]  # of a ROSS_STATUS, else NO_STATE

    def __len__(self) -> int:
        """Count the frames."""
        return len(self.start)

    def sent_by(self, *senders: ComponentId) -> NDArray[np.bool_]:
        """Whether one of these components sent a frame, for each."""
        return np.isin(self.sender, [256 * who.system + who.component for who in senders])

    def first_heartbeats(self) -> NDArray[np.int64]:
        """Return the numbers of the first HEARTBEAT of every component, in ascending order of these."""
        beats = np.flatnonzero(self.message == common.MAVLINK_MSG_ID_HEARTBEAT)
        return beats[np.unique(self.sender[beats], return_index=True)[1]]


@dataclass(slots=True)
class Damage:
    """What of a log is no good frame."""

    skipped: int = 0  # [bytes]
    holes: int = 0
    cut: bool = False  # the last frame is not whole
    wrong: Counter[int] = field(default_factory=Counter)  # frames with another checksum, by message id


def scan(file: LogFile, obsolete: Callable[[], bool] = lambda: False) -> tuple[Index, Damage]:
    """Find every good frame of a log, and what is damaged; ``obsolete`` says that nobody waits for it any longer.

    Raises
    ------
    GroundError
        When the disk fails, or nobody waits.
    """
    walk, parts, rest, base = _Walk(), [], b"", 0
    for piece in file.pieces():
        if obsolete():
            raise GroundError("the log was closed before it was read")
        data = rest + piece
        last = base + len(data) >= file.size
        places, sizes, reached = walk.over(data, base == 0, last)
        parts.append(_columns(data, base, np.array(places, np.int64), np.array(sizes, np.uint16)))
        rest, base = data[reached:], base + reached
        if base > FUTILE and not any(map(len, parts)):
            break
    return _joined(parts), walk.damage


class _Walk:
    """Goes from record to record, and over what is none."""

    def __init__(self) -> None:
        self.damage = Damage()
        self._lost = True  # until records follow each other
        self._hole = False  # what is skipped belongs to the hole before
        self._judged: tuple[bytes, int, int, NDArray[np.int64]] = b"", 0, 0, np.empty(0, np.int64)

    def over(self, data: bytes, first: bool, last: bool) -> tuple[list[int], list[int], int]:
        """Return places and sizes of the frames in ``data``, and how far it was looked at; all of the ``last``."""
        limit = len(data) if last else len(data) - CHAIN * LONGEST
        places, sizes, here = [], [], 0
        while here < limit:
            size, number = _head(data, here + STAMP)
            end = here + STAMP + size
            if self._lost and not _chained(data, here, begin=first and not here):
                here = self._search(data, here, limit)
            elif size and end <= len(data) and _is_good(data, here + STAMP, size, number):
                places.append(here + STAMP)
                sizes.append(size)
                self._lost, self._hole, here = False, False, end
            elif size and _follows(data, end):
                self.damage.wrong[number] += 1
                here = end
            else:
                self._lost = True
                self.damage.cut = len(data) - here < STAMP + HEAD or end > len(data)
        return places, sizes, here

    def _search(self, data: bytes, here: int, limit: int) -> int:
        """Return where records begin again, or ``limit``."""
        found = self._next(data, here + 1, limit)
        self.damage.cut &= found == len(data)  # else only its length was damaged
        if not self.damage.cut:
            self.damage.skipped += found - here
            self.damage.holes += not self._hole
            self._hole = True
        return found

    def _next(self, data: bytes, here: int, limit: int) -> int:
        """Return the first place from ``here`` on where records follow each other, or ``limit``."""
        while here < limit:
            if data is not self._judged[0] or not self._judged[1] <= here < self._judged[2]:
                end = min(here + STRETCH, limit)
                self._judged = data, here, end, chained(data, here, end)
            places = self._judged[3]
            index = int(np.searchsorted(places, here))
            if index < len(places):
                return int(places[index])
            here = self._judged[2]
        return limit


def _head(data: bytes, at: int) -> tuple[int, int]:
    """Return size and message id of the frame that begins here; 0: none does."""
    if len(data) < at + HEAD:
        return 0, 0
    if data[at] == V2 and data[at + 2] <= 1:  # flags that change the format are not understood
        return data[at + 1] + 12 + 13 * data[at + 2], data[at + 7] | data[at + 8] << 8 | data[at + 9] << 16
    return (data[at + 1] + 8, data[at + 5]) if data[at] == V1 else (0, 0)


def _is_good(data: bytes, at: int, size: int, number: int) -> bool:
    """Whether the checksum is right; of a message that nobody here knows: whether a record follows, as far as known."""
    extra = EXTRAS.get(number)
    if extra is None:
        return _follows(data, at + size) and _is_right(data, at + size + STAMP)
    end = at + size - (13 if data[at] == V2 and data[at + 2] else 0) - 2
    return bool(mcrf4xx(data[at + 1 : end] + extra) == data[end] | data[end + 1] << 8)


def _follows(data: bytes, end: int) -> bool:
    """Whether a record seems to begin here, or the file ends."""
    return end == len(data) or (end + STAMP < len(data) and data[end + STAMP] in (V1, V2))


def _is_right(data: bytes, at: int) -> bool:
    """Whether nothing speaks against a frame here."""
    size, number = _head(data, at)
    return number not in EXTRAS or at + size > len(data) or _is_good(data, at, size, number)


def _chained(data: bytes, here: int, begin: bool = False) -> bool:
    """Whether good records follow each other here: two, the first of a known message, or `CHAIN` of unknown ones.

    At the ``begin`` of a log one will do, or unknown ones before one that is known.
    """
    known = False
    for count in range(1, CHAIN + 1):
        size, number = _head(data, here + STAMP)
        here += STAMP + size
        if not size or here > len(data) or not _is_good(data, here - size, size, number):
            return begin and known
        if count > 1 and (known or number in EXTRAS):
            return known or begin
        known = number in EXTRAS
    return True


def _columns(data: bytes, base: int, at: NDArray[np.int64], size: NDArray[np.uint16]) -> Index:
    """Read the numbers of all frames at once."""
    octets = np.frombuffer(data, np.uint8)
    usec = octets[at[:, None] + np.arange(-STAMP, 0)].view(">u8").ravel()
    v2 = octets[at] == V2
    ids = at + np.where(v2, 5, 3)
    sequence = octets[at + np.where(v2, 4, 2)]
    sender = octets[ids].astype(np.uint16) * 256 + octets[ids + 1]
    message = np.where(v2, _number(octets, at, v2), octets[at + 5])
    inner = np.flatnonzero((message == TUNNEL) & (size > HEAD + INSIDE + 12))
    inner = inner[_is_ours(octets, at[inner])]
    tunnelled = np.zeros(len(at), np.bool_)
    tunnelled[inner] = True
    within = np.where(tunnelled, at + HEAD + INSIDE, at)
    message = np.where(tunnelled, _number(octets, within, tunnelled), message).astype(np.uint32)
    state = _states(octets, within, (message == STATUS) & v2)
    times = np.minimum(usec, np.uint64(2**62)).astype(np.int64)
    return Index(at + base, size, times, sender, sequence, message, tunnelled, state)


def _number(octets: NDArray[np.uint8], at: NDArray[np.int64], where: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return the message ids of MAVLink 2 frames, 0 elsewhere."""
    place = np.where(where, at + 7, 0)
    return sum((octets[place + i].astype(np.int64) << 8 * i for i in range(3)), np.zeros(len(at), np.int64)) * where


def _is_ours(octets: NDArray[np.uint8], at: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Whether a TUNNEL carries one of our frames."""
    kind = octets[at + HEAD] | octets[at + 11].astype(np.uint16) << 8
    ours: NDArray[np.bool_] = (kind == TYPE) & (octets[at + HEAD + INSIDE] == V2)
    return ours


def _states(octets: NDArray[np.uint8], at: NDArray[np.int64], where: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """Return the state in every ROSS_STATUS; zeros at the end of a payload are not sent."""
    states = np.full(len(at), NO_STATE, np.uint8)
    heads = at[where]
    sent = octets[heads + 1] > STATE
    states[where] = np.where(sent, octets[heads + np.where(sent, HEAD + STATE, 0)], 0)
    return states


def _joined(parts: list[Index]) -> Index:
    if not parts:
        parts = [_columns(bytes(64), 0, np.empty(0, np.int64), np.empty(0, np.uint16))]
    return Index(*(np.concatenate([getattr(part, each.name) for part in parts]) for each in fields(Index)))
