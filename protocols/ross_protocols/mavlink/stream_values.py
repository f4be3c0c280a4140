"""What telemetry says of live listening, as a value like those of `values`: SI units, radians, counter-clockwise.

A stream carries one voice, or the mixture, to one place: a listener at an address, a device, a file.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum


class Selection(IntEnum):
    """What a stream carries: ROSS_SELECTION."""

    NONE = 0
    MIXTURE = 1
    TARGET = 2
    SOURCE = 3
    AZIMUTH = 4


class Codec(IntEnum):
    """How the audio of a stream is coded: ROSS_CODEC."""

    OTHER = 0
    L16 = 1
    OPUS = 2
    PCM = 3
    FLAC = 4


@dataclass(frozen=True, slots=True)
class StreamReport:
    """One stream of live listening: ROSS_STREAM."""

    time_usec: int  # [us]
    number: int
    count: int  # every number is below
    sink: str  # at most 10 characters
    selection: Selection
    earth: bool
    rate: int  # [Hz]
    on: bool = False
    source: int | None = None  # index of a source
    azimuth: float | None = None  # [rad]
    group: int | None = None  # index of a separated group
    codec: Codec = Codec.OTHER
    address: str = ""  # at most 40 characters
    port: int = 0
    listeners: int | None = None  # at most 254
    gain: float = 0.0  # [dB]
    level: float | None = None  # [dB re full scale], to 1 dB on the wire
    delay: float | None = None  # [s], to the millisecond on the wire
    lost: int = 0  # samples
    packets_lost: int | None = None
    detail: str = ""  # at most 24 characters
    fault: bool = False
    muted: bool = False
    records: bool = False  # what it carries stays on a disk
    separated: bool = False  # it carries a separated voice at present


def description_file(number: int) -> str:
    """Return the name of the session description (SDP) of a stream, as MAVLink FTP offers it.

    >>> description_file(0)
    'stream-0.sdp'
    """
    return f"stream-{number}.sdp"
