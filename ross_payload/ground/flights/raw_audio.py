"""foxglove.RawAudio as other programs write it: protobuf or JSON, 16-bit samples; read field by field.

The layout is that of Foxglove's schemas: timestamp = 1, data = 2, format = 3, sample_rate = 4, number_of_channels = 5.
"""

from __future__ import annotations

import base64
import binascii
import json
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

SCHEMA = "foxglove.RawAudio"
FORMAT = "pcm-s16"
ENCODINGS = ("protobuf", "json")
RATES = range(1000, 384_001)  # [Hz]
MOST_CHANNELS = 16
VARINT, FIXED64, BYTES, FIXED32 = 0, 1, 2, 5  # wire types of protobuf
LONGEST_VARINT = 10  # [bytes]


@dataclass(frozen=True, slots=True, eq=False)
class AudioPart:
    """One message: some samples, and when the first one was heard."""

    time: int  # [ns]; 0: not told
    rate: int  # [Hz]
    samples: NDArray[np.int16]  # (n, n_channels)


def audio_part(data: bytes, encoding: str) -> AudioPart:
    """Read a message.

    >>> message = b'{"data": "AQACAAMABAA=", "format": "pcm-s16", "sample_rate": 8000, "number_of_channels": 2}'
    >>> audio_part(message, "json").samples.tolist()
    [[1, 2], [3, 4]]

    Raises
    ------
    ValueError
        When it is none, or of a kind that is not played; says what was expected.
    """
    if encoding not in ENCODINGS:
        raise ValueError(f"expected one in {' or '.join(ENCODINGS)}, got {encoding[:20]}")
    told = _protobuf(data) if encoding == "protobuf" else _json(data)
    time, content, form, rate, channels = told
    if form != FORMAT:
        raise ValueError(f"format: expected {FORMAT}, got {form[:20]}")
    if rate not in RATES or not 1 <= channels <= MOST_CHANNELS or len(content) % (2 * channels):
        raise ValueError(f"expected whole frames at 1 to 384 kHz, got {len(content)} bytes, {channels} x {rate} Hz")
    return AudioPart(time, rate, np.frombuffer(content, "<i2").reshape(-1, channels))


def _json(data: bytes) -> tuple[int, bytes, str, int, int]:
    try:
        told = json.loads(data)
        stamp = told.get("timestamp") or {}
        time = int(stamp.get("sec", 0)) * 10**9 + int(stamp.get("nsec", 0))
        content = base64.b64decode(told["data"], validate=True)
        return time, content, str(told["format"]), int(told["sample_rate"]), int(told["number_of_channels"])
    except (KeyError, TypeError, AttributeError, RecursionError, binascii.Error) as error:
        raise ValueError(f"expected {SCHEMA} as JSON, got {type(error).__name__}: {error}") from error


def _protobuf(data: bytes) -> tuple[int, bytes, str, int, int]:
    fields = _fields(data)
    stamp = _fields(_bytes(fields, 1))
    time = _number(stamp, 1) * 10**9 + _number(stamp, 2)
    form = _bytes(fields, 3).decode("utf-8", "replace")
    return time, _bytes(fields, 2), form, _number(fields, 4), _number(fields, 5)


def _bytes(fields: dict[int, Any], number: int) -> bytes:
    value = fields.get(number, b"")
    if not isinstance(value, bytes):
        raise ValueError(f"expected {SCHEMA}, got a number in field {number}")
    return value


def _number(fields: dict[int, Any], number: int) -> int:
    value = fields.get(number, 0)
    if not isinstance(value, int):
        raise ValueError(f"expected {SCHEMA}, got bytes in field {number}")
    return value


def _fields(data: bytes) -> dict[int, Any]:
    """Return the fields of a message by number, numbers as int, all else as bytes; the last of each."""
    found: dict[int, Any] = {}
    place = 0
    while place < len(data):
        key, place = _varint(data, place)
        kind, size = key & 7, 0
        if kind == VARINT:
            found[key >> 3], place = _varint(data, place)
            continue
        if kind == BYTES:
            size, place = _varint(data, place)
        elif kind in (FIXED32, FIXED64):
            size = 4 if kind == FIXED32 else 8
        else:
            raise ValueError(f"expected protobuf, got wire type {kind}")
        if place + size > len(data):
            raise ValueError("expected protobuf, got a field that is cut off")
        content = data[place : place + size]
        found[key >> 3] = content if kind == BYTES else int.from_bytes(content, "little")
        place += size
    return found


def _varint(data: bytes, place: int) -> tuple[int, int]:
    value = 0
    for shift, byte in enumerate(data[place : place + LONGEST_VARINT]):
        value |= (byte & 127) << 7 * shift
        if byte < 128:
            return value, place + shift + 1
    raise ValueError("expected protobuf, got a number without an end")
