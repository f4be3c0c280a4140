"""What one payload did, told from its messages in their order."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from ross_payload.ground.model.decoder_state import is_late
from ross_payload.ground.model.payload_state import Moment
from ross_payload.ground.model.state_reducer import SOURCES, is_overtaken
from ross_payload.ground.model.stream_rows import lasting
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common, ross
from ross_protocols.mavlink.stream_values import StreamReport
from ross_protocols.mavlink.values import Alignment, Heartbeat, Information, Named, Separation, Source, Status

EXPLORING = (ross.ROSS_STATE_EXPLORE_TURN, ross.ROSS_STATE_EXPLORE_LISTEN)
TIMELINE_MESSAGES = (
    common.MAVLINK_MSG_ID_HEARTBEAT,
    common.MAVLINK_MSG_ID_NAMED_VALUE_FLOAT,
    ross.MAVLINK_MSG_ID_ROSS_INFORMATION,
    ross.MAVLINK_MSG_ID_ROSS_STATUS,
    ross.MAVLINK_MSG_ID_ROSS_SOURCE,
    ross.MAVLINK_MSG_ID_ROSS_ALIGNMENT,
    ross.MAVLINK_MSG_ID_ROSS_SEPARATION,
    ross.MAVLINK_MSG_ID_ROSS_STREAM,
)  # messages that a `MissionTimeline` reads


@dataclass(slots=True)
class StateSpan:
    """A state, as long as it lasted."""

    state: int  # ROSS_STATE
    at: float  # [s]
    until: float  # [s]


@dataclass(slots=True)
class Exploration:
    """One exploration and what it found."""

    at: float  # [s]
    until: float  # [s]
    rotations: int = 0
    k: list[tuple[float, int]] = field(default_factory=list)  # at [s], K: whenever it changed
    estimate: int | None = None  # the latest, its number
    final: bool = False
    sources: dict[int, Source] = field(default_factory=dict)  # of that estimate, by index


@dataclass(slots=True)
class TriedCandidate:
    """An alignment candidate, as it was said last."""

    at: float  # heard of first [s]
    candidate: Alignment


@dataclass(slots=True)
class TimedSeparation:
    """One separation and its groups by index."""

    at: float  # [s]
    groups: dict[int, Separation] = field(default_factory=dict)


@dataclass(slots=True)
class StreamSpan:
    """A stream of live listening, as long as it went on without a change."""

    at: float  # [s]
    until: float  # [s]
    stream: StreamReport  # as it was told last


class MissionTimeline:
    """Listens to the values of one payload; what is repeated is told once."""

    def __init__(self, who: ComponentId) -> None:
        self.who = who
        self.information: Information | None = None
        self.status: Status | None = None
        self.states: list[StateSpan] = []
        self.explorations: list[Exploration] = []
        self.tried: dict[tuple[int, int, int], TriedCandidate] = {}
        self.separated: dict[tuple[int, int], TimedSeparation] = {}
        self.sources: dict[int, Source] = {}  # of the latest estimate
        self.streams: list[StreamSpan] = []
        self._streams_on: dict[int, StreamSpan] = {}  # by number
        self.moments: list[Moment] = []
        self._mirrors: dict[str, float] = {}

    def on_value(self, value: Any, at: float) -> None:
        """Take a value that came ``at`` a time [s]."""
        match value:
            case Information():
                self.information = value
            case Status() if not is_late(self.status, value):
                if self.status is not None and value.time_usec < self.status.time_usec:
                    self.sources = {}  # it has restarted
                self.status = value
                self._stay(value.state, at)
                self._explored(value.state, value.k, at, value.rotation)
                self.moments.append(Moment.of(value, at))
            case Source():
                self._source(value)
            case Alignment():
                key = (value.time_usec, value.plan, value.candidate)
                self.tried.setdefault(key, TriedCandidate(at, value)).candidate = value
            case Separation():
                number = (value.time_usec, value.separation)
                self.separated.setdefault(number, TimedSeparation(at)).groups[value.group] = value
            case StreamReport():
                self._stream(value, at)
            case Heartbeat() if self.status is None:
                self._stay(value.state, at)
            case Named() if self.status is None:
                self._mirror(value, at)

    def _stream(self, stream: StreamReport, at: float) -> None:
        before = self._streams_on.pop(stream.number, None)
        if before is not None:
            before.until = at
        if not stream.on:
            return
        if before is None or lasting(before.stream) != lasting(stream):
            before = StreamSpan(at, at, stream)
            self.streams.append(before)
        before.stream = stream
        self._streams_on[stream.number] = before

    def _mirror(self, named: Named, at: float) -> None:
        """Take what a payload says to those who do not know its dialect."""
        self._mirrors[named.name] = named.value
        state, k = self._mirrors.get("ross_state"), self._mirrors.get("ross_k")
        if named.name != "ross_state" or state is None:
            return
        self._explored(int(state), None if k is None else int(k), at, 0)
        score = self._mirrors.get("ross_score")
        self.moments.append(Moment(at, named.time, int(state), None if k is None else int(k), score, None, None))

    def _stay(self, state: int, at: float) -> None:
        if self.states:
            self.states[-1].until = at
        if not self.states or self.states[-1].state != state:
            self.states.append(StateSpan(state, at, at))

    def _explored(self, state: int, k: int | None, at: float, rotation: int) -> None:
        """Tell of an exploration; one that goes on when its state comes again."""
        before = self.moments[-1].state if self.moments else None
        if state in EXPLORING and before not in EXPLORING:
            self.explorations.append(Exploration(at, at))
        if state not in EXPLORING and before not in EXPLORING:
            return
        running = self.explorations[-1]
        running.until, running.rotations = at, max(running.rotations, rotation)
        if k is not None and (not running.k or running.k[-1][1] != k):
            running.k.append((at, k))

    def _source(self, source: Source) -> None:
        if is_overtaken(self.sources.values(), source, SOURCES):
            return
        if any(each.estimate != source.estimate for each in self.sources.values()):
            self.sources = {}
        self.sources[source.source] = source
        if not self.explorations or source.tracked:  # followed afterwards: not what the exploration found
            return
        latest = self.explorations[-1]
        exploring = self.moments[-1].state in EXPLORING
        if source.estimate != latest.estimate and (exploring or (source.final and not latest.final)):
            latest.estimate, latest.sources = source.estimate, {}
        if source.estimate == latest.estimate:
            latest.sources[source.source] = source
            latest.final |= source.final
