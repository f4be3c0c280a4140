"""Where records begin again in damaged bytes: every place of a stretch is judged at once, whatever stands there.

One checksum for every byte of a log full of markers would take minutes. CRC-16 is linear: with ``Q[i]``, the register
after the bytes up to i from 0, the register after the bytes a to b from r is ``Q[b] ^ M^(b-a) (Q[a] ^ r)``, where M is
a step over a byte of zeros. So any number of checksums costs one pass over the bytes and a few look-ups each.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ross_protocols.mavlink.dialect import MESSAGES

V1, V2 = 0xFE, 0xFD
STAMP = 8  # [bytes] of the time before every frame
HEAD = 10  # [bytes] of a frame
LONGEST = STAMP + HEAD + 2 + 255 + 13  # record [bytes]
CHAIN = 8  # records of unknown messages in a row that are no accident
POLYNOMIAL = 0x8408  # of CRC-16/MCRF4XX, reflected
ROW = 512  # [bytes] over which one register runs
LENGTHS = 288  # [bytes] that a checksum covers at most, and some more

Octets = NDArray[np.uint8]
Places = NDArray[np.int64]
Flags = NDArray[np.bool_]


def chained(data: bytes, begin: int, end: int) -> Places:
    """Return the places from ``begin`` up to ``end`` where two good records follow, the first of a known message.

    `CHAIN` records of unknown messages in a row will do, too. A record is the stamp and the frame.
    """
    octets = np.frombuffer(data, np.uint8, min(len(data), end + (CHAIN + 2) * LONGEST) - begin, begin)
    starts = _FrameStarts(octets, begin + len(octets) == len(data))
    first = np.arange(max(min(end - begin, len(octets) - STAMP), 0), dtype=np.int64) + STAMP
    first = first[starts.good[first]]
    known, after = starts.known[first], first + starts.size[first] + STAMP
    both = known & starts.at(starts.good, after)
    chain = ~known
    for _ in range(CHAIN - 1):
        chain &= starts.at(starts.good, after) & ~starts.at(starts.known, after)
        after = after + starts.at(starts.size, after) + STAMP
    places: Places = first[both | chain] - STAMP + begin
    return places


@dataclass(slots=True, init=False)
class _FrameStarts:
    """What every byte would be as the first of a frame."""

    size: NDArray[np.int64]  # of the frame [bytes], 0: none begins here
    known: Flags  # a message of the dialect
    good: Flags  # its checksum is right; of an unknown one: a record follows, as far as known

    def __init__(self, octets: Octets, last: bool) -> None:
        n = len(octets)
        self.size, self.known, self.good = np.zeros(n, np.int64), np.zeros(n, bool), np.zeros(n, bool)
        at, size, number, signed = _frames(octets)
        extras = _extras()
        index = np.minimum(np.searchsorted(extras[0], number), len(extras[0]) - 1)
        known, whole = extras[0][index] == number, at + size <= n
        self.size[at], self.known[at] = size, known
        sure = np.flatnonzero(known & whole)
        ends = (at + size - 13 * signed - 2)[sure]
        found = octets[ends] | octets[ends + 1].astype(np.uint16) << 8
        self.good[at[sure]] = _checksums(octets, at[sure] + 1, ends, extras[1][index[sure]]) == found
        rest = at[~known & whole]
        self.good[rest] = self._followed(rest + self.size[rest], n, last)

    def _followed(self, end: Places, n: int, last: bool) -> Flags:
        """Whether a record seems to begin at ``end``, and nothing speaks against it; or the file ends there."""
        after = end + STAMP
        size = self.at(self.size, after)
        begins = (size > 0) & (~self.at(self.known, after) | (after + size > n) | self.at(self.good, after))
        followed: Flags = begins | ((end == n) & last)
        return followed

    def at(self, values: NDArray[Any], places: Places) -> NDArray[Any]:
        """Return what stands at ``places``, 0 beyond the end."""
        within = places < len(values)
        found: NDArray[Any] = np.where(within, values[np.where(within, places, 0)], values.dtype.type(0))
        return found


def _frames(octets: Octets) -> tuple[Places, Places, Places, Flags]:
    """Return place, size, message id and whether it is signed of everything that could be a frame."""
    at = np.flatnonzero(((octets == V1) | (octets == V2))[: max(len(octets) - HEAD + 1, 0)]).astype(np.int64)
    v1 = octets[at] == V1
    at = at[v1 | (octets[at + 2] <= 1)]  # flags that change the format are not understood
    v1, signed = octets[at] == V1, octets[at + 2] == 1
    number = np.where(v1, octets[at + 5], 0).astype(np.int64)
    for place in range(3):
        number += np.where(v1, 0, octets[at + 7 + place].astype(np.int64) << 8 * place)
    return at, octets[at + 1] + np.where(v1, 8, 12 + 13 * signed), number, signed & ~v1


def _checksums(octets: Octets, begin: Places, end: Places, extra: Octets) -> NDArray[np.uint16]:
    """Return CRC-16/MCRF4XX of ``octets[begin:end]`` and one more byte, for all at once."""
    row, zeros = begin // ROW, _zeros()
    prefix, step = _prefixes(octets), _steps()
    register = prefix[begin - row * ROW, row] ^ np.uint16(0xFFFF)
    length = end - begin
    register = zeros[length, 0, register & 255] ^ zeros[length, 1, register >> 8] ^ prefix[end - row * ROW, row]
    result: NDArray[np.uint16] = (register >> 8) ^ step[(register ^ extra) & 255]
    return result


def _prefixes(octets: Octets) -> NDArray[np.uint16]:
    """Return the register after every byte of every row, from 0, (ROW + LENGTHS + 1, n_rows); rows overlap."""
    rows = len(octets) // ROW + 1
    padded = np.zeros((rows + 1) * ROW, np.uint8)
    padded[: len(octets)] = octets
    parts = padded.reshape(-1, ROW)
    columns = np.concatenate([parts[:-1].T, parts[1:, :LENGTHS].T])
    step, prefix = _steps(), np.zeros((ROW + LENGTHS + 1, rows), np.uint16)
    for place, column in enumerate(columns):
        register = prefix[place]
        prefix[place + 1] = (register >> 8) ^ step[(register ^ column) & 255]
    return prefix


@cache
def _steps() -> NDArray[np.uint16]:
    """Return the register after one byte, by the byte, (256,)."""
    register: NDArray[np.uint16] = np.arange(256, dtype=np.uint16)
    for _ in range(8):
        register = np.where(register & 1, (register >> 1) ^ POLYNOMIAL, register >> 1).astype(np.uint16)
    return register


@cache
def _zeros() -> NDArray[np.uint16]:
    """Return the register after n bytes of zeros, by n and by its low and its high byte, (LENGTHS, 2, 256)."""
    step = _steps()
    tables: list[NDArray[np.uint16]] = [np.arange(256, dtype=np.uint16) << np.array([[0], [8]], np.uint16)]
    for _ in range(LENGTHS - 1):
        tables.append((tables[-1] >> 8) ^ step[tables[-1] & 255])
    return np.array(tables)


@cache
def _extras() -> tuple[Places, Octets]:
    """Return the ids of the messages that are known, sorted, and their extra byte."""
    numbers = sorted(MESSAGES)
    return np.array(numbers, np.int64), np.array([MESSAGES[number].crc_extra for number in numbers], np.uint8)
