r"""PCM over a byte stream: one JSON line that says what follows, then interleaved little-endian samples without end.

::

    {"ross_pcm": 1, "rate_hz": 16000, "channels": 2, "format": "s24le"}\n
    <channel 1><channel 2><channel 1><channel 2>...

Full scale is 1. Integer formats clip; ``f32le`` carries what it is given.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Frames = NDArray[np.float32]  # (n, channels)

VERSION = 1
LONGEST_HEADER = 1024  # [bytes]
WIDTHS = {"s16le": 2, "s24le": 3, "f32le": 4}  # of one sample [bytes]
MAX_RATE = 192_000  # [Hz]
MAX_CHANNELS = 64


class PcmError(ValueError):
    """The bytes are not PCM of this kind; says what was expected and what was got."""


@dataclass(frozen=True, slots=True)
class Header:
    """What follows the first line."""

    rate: int  # [Hz]
    channels: int
    format: str = "s24le"  # or s16le, f32le

    def __post_init__(self) -> None:
        for name, value, highest in (("rate_hz", self.rate, MAX_RATE), ("channels", self.channels, MAX_CHANNELS)):
            if type(value) is not int or not 1 <= value <= highest:
                raise PcmError(f"PCM header: {name}: expected a whole number from 1 to {highest}, got {value!r}")
        if self.format not in WIDTHS:
            raise PcmError(f"PCM header: format: expected one of {', '.join(WIDTHS)}, got {self.format!r}")


def encode_header(header: Header) -> bytes:
    r"""Write the first line.

    >>> encode_header(Header(16000, 2))
    b'{"ross_pcm": 1, "rate_hz": 16000, "channels": 2, "format": "s24le"}\n'
    """
    said = {"ross_pcm": VERSION, "rate_hz": header.rate, "channels": header.channels, "format": header.format}
    return json.dumps(said).encode() + b"\n"


def decode_header(line: bytes) -> Header:
    """Read the first line.

    Raises
    ------
    PcmError
        When it is not such a line, or says what cannot be.
    """
    try:
        said: Any = json.loads(line)
    except (ValueError, RecursionError):
        said = None
    if not isinstance(said, dict) or "ross_pcm" not in said:
        raise PcmError(f"PCM header: expected a line like {encode_header(Header(16000, 2))!r}, got {line[:60]!r}")
    if said["ross_pcm"] != VERSION:
        raise PcmError(f"PCM header: expected version {VERSION}, got {said['ross_pcm']!r}")
    return Header(said.get("rate_hz"), said.get("channels"), said.get("format"))  # type: ignore[arg-type]


def encode(frames: Frames, form: str) -> bytes:
    """Write samples (n, channels), full scale 1, interleaved.

    >>> encode(np.array([[0.5, -1.0]], np.float32), "s16le").hex()
    '00400080'
    """
    if form == "f32le":
        return np.ascontiguousarray(frames, "<f4").tobytes()
    scale = 2.0 ** (8 * WIDTHS[form] - 1)
    counts = np.clip(np.rint(np.asarray(frames, np.float64) * scale), -scale, scale - 1)
    if form == "s16le":
        return counts.astype("<i2").tobytes()
    return np.ascontiguousarray(counts, "<i4").view(np.uint8).reshape(-1, 4)[:, :3].tobytes()


def decode(data: bytes, form: str, channels: int) -> Frames:
    """Read whole frames, (n, channels) with full scale 1."""
    if form == "f32le":
        return np.frombuffer(data, "<f4").astype(np.float32).reshape(-1, channels)
    if form == "s16le":
        counts = np.frombuffer(data, "<i2").astype(np.float32)
        return (counts / np.float32(2**15)).reshape(-1, channels)
    wide = np.zeros((len(data) // 3, 4), np.uint8)
    wide[:, 1:] = np.frombuffer(data, np.uint8).reshape(-1, 3)
    return (wide.view("<i4") / np.float32(2**31)).astype(np.float32).reshape(-1, channels)


class Decoder:
    """Takes the stream in pieces of any size; what is not a whole frame waits for the next piece."""

    def __init__(self) -> None:
        self.header: Header | None = None
        self._rest = b""

    def feed(self, data: bytes) -> Frames:
        """Return the frames that are complete, (n, channels); (0, 0) before the header is.

        Raises
        ------
        PcmError
            When the stream does not begin with a good header.
        """
        self._rest += data
        if self.header is None:
            self._begin()
        if self.header is None:
            return np.zeros((0, 0), np.float32)
        size = WIDTHS[self.header.format] * self.header.channels
        whole = len(self._rest) // size * size
        frames, self._rest = self._rest[:whole], self._rest[whole:]
        return decode(frames, self.header.format, self.header.channels)

    def _begin(self) -> None:
        line, end, rest = self._rest.partition(b"\n")
        if end:
            self.header, self._rest = decode_header(line), rest
        elif len(line) > LONGEST_HEADER:
            raise PcmError(f"no PCM header within {LONGEST_HEADER} bytes: {line[:60]!r}")
