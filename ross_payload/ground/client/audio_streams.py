"""Streams of live listening, as scripts see them: what each carries, to whom, and how it is.

Angles are degrees here, clockwise as on a compass, from north when ``earth``, else from the zero of the mount.
"""

from __future__ import annotations

from dataclasses import dataclass

from ross_payload.ground.model.stream_rows import CODECS, selection_name
from ross_protocols.mavlink.field_converters import compass
from ross_protocols.mavlink.stream_values import StreamReport


@dataclass(frozen=True, slots=True)
class AudioStream:
    """One stream that a payload announces; it stays when it has ended, off, until its number is given to another."""

    number: int  # what `Payload.stop_stream` wants
    sink: str  # "rtp", "tcp", "file", "device" or the name of a plug-in
    what: str  # "mixture", "target", "source" or "azimuth"
    on: bool
    source: int | None  # that it carries, or is to carry
    azimuth_deg: float | None  # where that voice comes from, or the azimuth that was asked for
    earth: bool
    separated: bool  # a voice is heard at present, else the mixture or silence
    codec: str  # "opus", "L16", ...; empty: not known
    rate_hz: int
    address: str
    port: int
    listeners: int | None  # None: the payload cannot tell, as with RTP
    records: bool  # what it carries stays on a disk
    gain_db: float
    muted: bool
    level_db: float | None  # re full scale
    delay_s: float | None  # from the microphone until it leaves the payload
    lost_samples: int  # that did not get out
    lost_packets: int | None  # that its listeners report
    fault: bool
    detail: str  # in words

    @classmethod
    def of(cls, stream: StreamReport) -> AudioStream:
        """Convert what telemetry says of a stream."""
        return cls(
            stream.number, stream.sink, selection_name(stream.selection), stream.on, stream.source,
            None if stream.azimuth is None else compass(stream.azimuth), stream.earth, stream.separated,
            CODECS.get(stream.codec, ""), stream.rate, stream.address, stream.port, stream.listeners, stream.records,
            stream.gain, stream.muted, stream.level, stream.delay, stream.lost, stream.packets_lost, stream.fault,
            stream.detail,
        )  # fmt: skip
