"""How one message changes what is known of a payload: pure functions.

A source is told by its track: its index may change from one estimate to the next, where it is hardly.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

from ross_payload.ground.model.payload_state import Moment, PayloadState, SourceTrack, StatusText
from ross_protocols.mavlink import values
from ross_protocols.mavlink.computer import Computer
from ross_protocols.mavlink.dialect import ross
from ross_protocols.mavlink.field_converters import wrap
from ross_protocols.mavlink.stream_values import StreamReport

MOST_SOURCES = 32  # that are kept; bitmasks of the dialect have no more
MOST_TEXTS = 200
MOST_MOMENTS = 600
MOST_ROTATIONS = 64
MOST_LINKS = 16
MOST_STREAMS = 255
MOMENT_SPACING_S = 1.0  # [s] between two moments when nothing changes
JUST_BEGUN_S = 5.0  # [s] of mission time within which a payload that was not seen to rest has just begun
LATE_US = 10_000_000  # [us] before the newest of its kind, at most: a frame that was on its way for long
REPEATED_US = 86_400_000_000  # [us] before it: what is repeated keeps the time at which it was found
RESTING = (ross.ROSS_STATE_IDLE, ross.ROSS_STATE_DONE, ross.ROSS_STATE_STOPPED, ross.ROSS_STATE_FAULT)
MIRROR, AZIMUTHS = "ross_", "ross_az"
STATUS_TIMEOUT_S = 35.0  # [s] beside others without a status: at the lowest TLM_STATUS_HZ three in a row were lost
SILENCE_S = 5.0  # [s] between two messages, of which no more counts as time without a status: nothing else came, either
MOST_POINTS = 60  # of a track
MOST_TRACKS = 64
TRACK_TIMEOUT_S = 12.0  # that a track stays without going on: a source is sent again every 5 s
MAX_STEP = math.radians(20)  # that a source moves at most from one estimate to the next


@dataclass(frozen=True, slots=True)
class IndexedList:
    """Where values that come in a row are kept: of one generation, by index, as many as they say."""

    attribute: str  # of `Payload`
    generation: str  # attribute of the value
    index: str  # attribute of the value
    count: str  # attribute of the value that says how many there are; "": it does not say
    most: int


LATEST: dict[type, str] = {
    values.Heartbeat: "heartbeat",
    values.Information: "information",
    values.Audio: "audio",
    values.Recording: "recording",
}
SOURCES = IndexedList("sources", "estimate", "source", "count", MOST_SOURCES)
LISTS: dict[type, IndexedList] = {
    values.Alignment: IndexedList("alignments", "plan", "candidate", "count", MOST_SOURCES),
    values.Separation: IndexedList("separations", "separation", "group", "count", MOST_SOURCES),
    values.Density: IndexedList("densities", "exploration", "rotation", "", MOST_ROTATIONS),
    values.Isolation: IndexedList("isolations", "plan", "source", "", MOST_SOURCES),
    values.LinkReport: IndexedList("links", "count", "link", "count", MOST_LINKS),
    StreamReport: IndexedList("streams", "count", "number", "count", MOST_STREAMS),
}


def is_sane(value: values.Value) -> bool:
    """Whether every number of a value is one: what is not known is None, and a NaN is nobody's meaning.

    >>> [is_sane(values.Named(time=1.0, name="ross_k", value=value)) for value in (math.nan, 3.0)]
    [False, True]
    """
    return all(_finite(getattr(value, each.name)) for each in fields(value))


def learn(known: PayloadState, value: values.Value, at: float) -> PayloadState:
    """Return what is known after a value that came ``at`` a time [s]; `is_sane` values only."""
    known = _heard(known, at)
    if isinstance(value, values.Heartbeat | values.Named | values.Array):
        known = _without_old_status(known)
    match value:
        case values.Status():
            return _status(known, value, at)
        case values.Source():
            return _source(known, value, at)
        case values.Named() | values.Array():
            return _mirror(known, value)
    if type(value) in LISTS:
        return _listed(known, value, LISTS[type(value)])
    changes: dict[str, Any] = {LATEST[type(value)]: value} if type(value) in LATEST else {}
    return replace(known, **changes)


def with_text(known: PayloadState, text: StatusText) -> PayloadState:
    """Return what is known after a text."""
    return replace(_heard(known, text.at), texts=(*known.texts, text)[-MOST_TEXTS:])


def with_computer(known: PayloadState, computer: Computer, at: float) -> PayloadState:
    """Return what is known after a report of the payload's computer."""
    return replace(_heard(known, at), computer=computer)


def flawed(known: PayloadState, flaw: str) -> PayloadState:
    """Return what is known after something odd; each flaw is kept once."""
    counts = replace(known.counts, malformed=known.counts.malformed + 1)
    flaws = known.flaws if flaw in known.flaws else (*known.flaws, flaw)[-8:]
    return replace(known, counts=counts, flaws=flaws)


def restarted(known: PayloadState, at: float) -> PayloadState:
    """Return what is left when a payload restarts: that it is there."""
    fresh = PayloadState(
        known.who, known.first, at, boots=known.boots + 1, tunnelled=known.tunnelled, counts=known.counts
    )
    return replace(fresh, texts=known.texts)


def _heard(known: PayloadState, at: float) -> PayloadState:
    between = min(max(at - known.last, 0.0), SILENCE_S)
    return replace(known, last=at, without_status=known.without_status + between)


def _finite(value: Any) -> bool:
    if isinstance(value, float):
        return math.isfinite(value)
    return all(map(_finite, value)) if isinstance(value, tuple) else True


def _status(known: PayloadState, status: values.Status, at: float) -> PayloadState:
    moment = Moment.of(status, at)
    history = known.history
    if not history or _telling(history[-1], moment):
        history = (*history, moment)[-MOST_MOMENTS:]
    began, ended = _span(known, status)
    known = replace(known, status=status, status_at=at, without_status=0.0, history=history, began=began, ended=ended)
    return replace(known, sources=(), announced=0) if status.k == 0 else known  # of no sources none tells


def _span(known: PayloadState, status: values.Status) -> tuple[float | None, float | None]:
    """When the latest mission began and ended, in mission time [s]."""
    before, rests = known.status, status.state in RESTING
    rested = status.mission_time < JUST_BEGUN_S if before is None else before.state in RESTING
    if rested and not rests:
        return status.mission_time, None
    if rests and not rested:
        return known.began, status.mission_time
    return known.began, known.ended


def _telling(before: Moment, now: Moment) -> bool:
    """Whether a moment says more than that time went by, or enough time went by."""
    same = (before.state, before.k, before.score, before.criterion) == (now.state, now.k, now.score, now.criterion)
    return not same or now.at - before.at >= MOMENT_SPACING_S or now.at < before.at


def _source(known: PayloadState, source: values.Source, at: float) -> PayloadState:
    before = known.sources
    if is_overtaken(before, source, SOURCES):
        return known
    known = replace(known, announced=source.count)
    if not before or before[0].estimate != source.estimate:
        known = _of_this_estimate(known, source)
    if source.source >= MOST_SOURCES:
        return known
    return replace(_listed(known, source, SOURCES), trails=followed(known.trails, source, at))


def _of_this_estimate(known: PayloadState, source: values.Source) -> PayloadState:
    """Forget what speaks of the sources of an older estimate."""
    since = source.time_usec
    return replace(
        known,
        alignments=tuple(each for each in known.alignments if each.time_usec >= since),
        separations=tuple(each for each in known.separations if each.time_usec >= since),
        isolations=tuple(each for each in known.isolations if each.time_usec >= since),
    )


def _listed(known: PayloadState, item: Any, kept: IndexedList) -> PayloadState:
    """Put an item among those of its generation; those of another one are forgotten."""
    before = getattr(known, kept.attribute)
    if is_overtaken(before, item, kept):
        return known
    generation = getattr(item, kept.generation)
    same = [each for each in before if getattr(each, kept.generation) == generation]
    by_index = {getattr(each, kept.index): each for each in [*same, item]}
    most = min(getattr(item, kept.count), kept.most) if kept.count else kept.most
    changes: dict[str, Any] = {kept.attribute: tuple(by_index[key] for key in sorted(by_index) if key < most)}
    return replace(known, **changes)


def is_overtaken(before: Iterable[Any], item: Any, kept: IndexedList) -> bool:
    """Tell whether an item of an older generation comes after some of a newer one."""
    other = [each for each in before if getattr(each, kept.generation) != getattr(item, kept.generation)]
    return any(0 < each.time_usec - item.time_usec < REPEATED_US for each in other)


def _azimuths(numbers: Sequence[float]) -> tuple[float, ...]:
    """Read how many there are, and then each [deg]; zeros at the end do not travel.

    >>> _azimuths((2.0, 90.0)), _azimuths((-1.0, 90.0))
    ((90.0, 0.0), ())
    """
    count = min(max(int(numbers[0]), 0), MOST_SOURCES) if numbers else 0
    return tuple([*numbers[1 : count + 1], *[0.0] * count][:count])


def _without_old_status(known: PayloadState) -> PayloadState:
    """Forget what our own messages told when no status has come for long.

    The way that is left passes on no message of ours, or another station has disabled the status on the link.
    """
    if known.status is None or known.without_status <= STATUS_TIMEOUT_S:
        return known
    fresh = PayloadState(known.who, known.first, known.last, known.boots, known.tunnelled, known.twin, known.counts)
    kept = ("heartbeat", "information", "computer", "texts", "history", "mirrors", "azimuths", "flaws")
    return replace(fresh, **{name: getattr(known, name) for name in kept})


def _mirror(known: PayloadState, named: values.Named | values.Array) -> PayloadState:
    if isinstance(named, values.Array):
        return replace(known, azimuths=_azimuths(named.numbers)) if named.name == AZIMUTHS else known
    if not named.name.startswith(MIRROR):
        return known
    return replace(known, mirrors=tuple(sorted({**dict(known.mirrors), named.name: named.value}.items())))


def followed(trails: Sequence[SourceTrack], source: values.Source, at: float) -> tuple[SourceTrack, ...]:
    """Return the trails after a source of an estimate came ``at`` a time [s].

    It goes on with the nearest trail that nobody else of this estimate goes on with. One that nobody goes on with stays
    a while, for a source that is still on its way.
    """
    others = [trail for trail in trails if at - trail.at < TRACK_TIMEOUT_S]
    mine = [trail for trail in others if trail.estimate == source.estimate and trail.source == source.source]
    free = [trail for trail in others if trail.estimate != source.estimate and _apart(trail, source) < MAX_STEP]
    before = mine[0] if mine else min(free, key=lambda trail: _apart(trail, source), default=None)
    points = () if before is None else before.points
    if not points or points[-1][1] != source.azimuth:
        points = (*points, (at, source.azimuth))[-MOST_POINTS:]
    fresh = SourceTrack(source.source, points, source.estimate, source.earth, at)
    kept = [trail for trail in others if trail is not before]
    return tuple(sorted([*kept, fresh], key=lambda trail: -trail.at)[:MOST_TRACKS])


def _apart(trail: SourceTrack, source: values.Source) -> float:
    """Return how far a source is from the end of a trail [rad]; infinite: they count from different zeros."""
    return abs(wrap(trail.points[-1][1] - source.azimuth)) if trail.earth == source.earth else math.inf
