"""What live listening is asked for, and how its streams are: plain values that cross between threads.

A stream takes one voice, or the mixture, to one sink. It has a number, from 0, that it keeps for good; a stream that
has ended stays in what is told, off, until its number is given to another. Angles are in radians, counter-clockwise, in
the frame of the mount's attitude, as those of orders are.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

MAX_STREAMS = 16  # at once
LISTENER_TIMEOUT_S = 25.0  # of who is silent: five times the 5 s between reports, RFC 3550, 6.2.1 and 6.3.5


class What(StrEnum):
    """What a stream can carry."""

    MIXTURE = "mixture"  # microphone 1, as it is
    TARGET = "target"  # whoever the mission listens to
    SOURCE = "source"  # one source of the latest estimate
    AZIMUTH = "azimuth"  # whoever is there


@dataclass(frozen=True, slots=True)
class Selection:
    """What a stream carries; ``source`` is told for SOURCE alone, ``azimuth`` for AZIMUTH alone."""

    what: What = What.TARGET
    source: int | None = None  # index into the latest estimate
    azimuth: float | None = None  # [rad]


@dataclass(frozen=True, slots=True)
class StreamOrder:
    """Start, change or end one stream: for the listening stage, not for the mission. None: as it is.

    An order may come twice, since networks double frames: what it asks for is a state, and the second one changes
    nothing.
    """

    on: bool
    number: int | None = None  # None: the one that goes to this address and port, else a new one; of an end: or all
    selection: Selection | None = None  # None, of a new one: the target
    gain_db: float | None = None  # None, of a new one: 0
    muted: bool | None = None  # None, of a new one: not muted
    address: str = ""  # IPv4, unicast, numeric; empty: where it goes already. A new one needs it
    port: int = 0  # 1 to 65535 with an address
    codec: str = ""  # "L16" or "opus"; empty: that which it has, of a new one Opus


@dataclass(frozen=True, slots=True)
class StreamStatus:
    """One stream at one moment; what is not known is None."""

    number: int  # below 255
    sink: str  # name of its entry point: "file", "device", "tcp", "rtp" or a plug-in's
    selection: Selection
    on: bool
    rate: int  # of the samples as they leave [Hz]
    codec: str = ""  # "pcm" (tcp, device), "L16", "opus", "flac" ...; empty: the sink has no such thing
    address: str = ""  # host or address, device or file: where it goes (tcp: where it waits for listeners)
    port: int = 0  # 0: it has none
    listeners: int | None = None  # who take it at present; None: the sink cannot tell
    keeps: bool = False  # what is heard stays on a disk
    separated: bool = False  # a separated voice is heard at present, else the mixture or silence
    source: int | None = None  # whose voice that is, an index into the latest estimate
    group: int | None = None  # and which of the separated groups
    azimuth: float | None = None  # and from where [rad]
    gain_db: float = 0.0
    muted: bool = False
    level_db: float | None = None  # rms of the last second, after the gain [dB re full scale]
    delay: float | None = None  # from the microphone to where it leaves the payload [s]
    lost: int = 0  # samples that never got out, since it was started
    packets_lost: int | None = None  # on the way, as the listeners report (RTCP)
    fault: str = ""  # in words; empty while all is well
    detail: str = ""  # what else there is to say, in words: "no target yet", "waits for a listener"
