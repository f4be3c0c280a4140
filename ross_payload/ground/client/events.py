"""What happens at a payload, as values; and how to see it in two states of what is known of it.

Scripts stand at the edge: angles are degrees here, clockwise as on a compass, from north when ``earth``, else from the
zero of the mount. ``at`` is the time of the message on the station's clock [s].
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from ross_payload.ground.model.payload_state import PayloadState, SourceTrack
from ross_payload.ground.model.stream_rows import CODECS, changed, selection_name
from ross_payload.ground.model.view import word
from ross_protocols.mavlink.dialect import ross
from ross_protocols.mavlink.field_converters import compass
from ross_protocols.mavlink.stream_values import StreamReport
from ross_protocols.mavlink.values import Source, Status


@dataclass(frozen=True, slots=True)
class SourceEstimate:
    """One source of the payload's latest estimate."""

    source: int  # its index in the estimate: what `Payload.listen_to` wants
    azimuth_deg: float
    mirror_deg: float | None  # where it may be instead; None: the mirror image is ruled out
    sigma_deg: float
    confidence: float  # probability that a talker is within 10 deg
    earth: bool  # azimuths count from north
    target: bool  # the enrolled voice
    rate_deg_s: float | None  # of the azimuth, clockwise; None: it is not tracked
    age_s: float | None  # since it was last heard, while it is tracked

    @classmethod
    def of(cls, source: Source) -> SourceEstimate:
        """Convert what telemetry says of a source."""
        mirror = None if source.mirror is None else compass(source.mirror)
        tracked = source.tracked
        return cls(
            source.source, compass(source.azimuth), mirror, math.degrees(source.sigma), source.confidence,
            source.earth, source.target,
            0.0 - math.degrees(source.rate or 0.0) if tracked else None, (source.age or 0.0) if tracked else None,
        )  # fmt: skip


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
    listeners: int | None  # None: the payload does not tell; with RTP 1, or 0 when nobody takes it
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


@dataclass(frozen=True, slots=True)
class Event:
    """The root of all events."""

    at: float  # [s]


@dataclass(frozen=True, slots=True)
class StateChanged(Event):
    """The mission is in another state, an entry of ROSS_STATE in lower case: ``idle``, ``explore_turn``, ``run``."""

    before: str | None  # None: it was not known
    state: str


@dataclass(frozen=True, slots=True)
class SourceFound(Event):
    """A source is estimated where none was lately."""

    source: SourceEstimate


@dataclass(frozen=True, slots=True)
class SourceMoved(Event):
    """A source is estimated at another azimuth; its index may be another one, too."""

    source: SourceEstimate
    from_deg: float  # azimuth before


@dataclass(frozen=True, slots=True)
class TargetFound(Event):
    """The enrolled voice was recognised."""

    source: int | None  # index in the estimate


@dataclass(frozen=True, slots=True)
class TargetLost(Event):
    """The enrolled voice is not recognised any longer."""


@dataclass(frozen=True, slots=True)
class FaultRaised(Event):
    """The actuator, or the mission, has a fault; a `TextReceived` says which."""


@dataclass(frozen=True, slots=True)
class FaultCleared(Event):
    """There is no fault any longer."""


@dataclass(frozen=True, slots=True)
class StreamChanged(Event):
    """A stream of live listening starts, ends, carries something else, gains or loses a listener, fails or recovers."""

    stream: AudioStream


@dataclass(frozen=True, slots=True)
class TextReceived(Event):
    """A text for humans, whole."""

    severity: int  # MAV_SEVERITY: 0 emergency to 7 debug
    text: str


@dataclass(frozen=True, slots=True)
class TaskProgress(Event):
    """What becomes of something that this client asked for."""

    request: str  # such as "turn to 10 deg"
    state: str  # as in `CommandStatus`: sent, acknowledged, in_progress, done, refused, failed, cancelled, no_answer
    progress: float | None  # 0 to 1
    reason: str


@dataclass(frozen=True, slots=True)
class PayloadRestarted(Event):
    """It has restarted, and has forgotten what it was asked."""


@dataclass(frozen=True, slots=True)
class ContactLost(Event):
    """Nothing has been received from it for `SILENT_S`."""


@dataclass(frozen=True, slots=True)
class ContactRestored(Event):
    """It is received again."""


def events_between(before: PayloadState, after: PayloadState) -> Iterator[Event]:
    """Yield what has happened between two states of one payload, the second one message after the first."""
    at = after.last
    if after.boots != before.boots:
        yield PayloadRestarted(at)
    was, now = before.status, after.status
    if now is not None and now is not was:
        yield from _status_events(was, now, at)
    tracks = [track for track in after.trails if track not in before.trails]
    for source in after.sources if tracks else ():
        if source not in before.sources:
            yield from _source_events(source, tracks, before.trails, at)
    for stream in changed(before.streams, after.streams) if after.streams is not before.streams else ():
        yield StreamChanged(at, AudioStream.of(stream))
    known = {id(text) for text in before.texts}
    for text in after.texts:
        if id(text) not in known:
            yield TextReceived(text.at, text.severity, text.text)


def _status_events(was: Status | None, now: Status, at: float) -> Iterator[Event]:
    state, fault = word("ROSS_STATE", now.state), _has_fault(now)
    if was is None or was.state != now.state:
        yield StateChanged(at, None if was is None else word("ROSS_STATE", was.state), str(state))
    if fault != (was is not None and _has_fault(was)):
        yield FaultRaised(at) if fault else FaultCleared(at)
    if now.target_found and (was is None or not was.target_found or was.target != now.target):
        yield TargetFound(at, now.target)
    elif was is not None and was.target_found and not now.target_found:
        yield TargetLost(at)


def _has_fault(status: Status) -> bool:
    return bool(status.fault or status.state == ross.ROSS_STATE_FAULT)


def _source_events(
    source: Source, tracks: list[SourceTrack], before: tuple[SourceTrack, ...], at: float
) -> Iterator[SourceFound | SourceMoved]:
    """Tell a source by its track: one that goes on where another one ended is the same source."""
    for track in tracks:
        if track.source != source.source or track.estimate != source.estimate:
            continue
        *earlier, _ = track.points
        if not earlier:
            yield SourceFound(at, SourceEstimate.of(source))
        elif all(track.points != old.points for old in before):
            yield SourceMoved(at, SourceEstimate.of(source), compass(earlier[-1][1]))
