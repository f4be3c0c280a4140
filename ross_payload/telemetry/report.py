"""The reporter: what the mission says and how things stand, put on the board.

It owns no port, no clock and no thread: values go to the board, texts to ``say``, time comes with every call.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ross_payload.events import (
    AlignmentPlanned,
    Checked,
    Event,
    Finished,
    NoiseMeasured,
    OrientationHeard,
    Outcome,
    ScoreDropped,
    Separated,
    SourcesEstimated,
    State,
    StateChanged,
    TurnStarted,
)
from ross_payload.telemetry import scene
from ross_payload.telemetry.scene import Stamp
from ross_payload.telemetry.standing import Snapshot
from ross_payload.telemetry.streams import Board, Rank
from ross_payload.telemetry.texts import line
from ross_protocols.values import (
    Alignment,
    CandidateState,
    Density,
    Heartbeat,
    Separation,
    Severity,
    Source,
    Status,
)

SAME_ANGLE = 1e-6  # [rad]
FOUND = {Outcome.TARGET_FOUND: True, Outcome.NO_TARGET: False}  # other ends leave it as it was


class Reporter:
    """Turns a mission into what there is to tell; one that lives through many tasks."""

    def __init__(self, board: Board, say: Callable[[Severity, str], None]) -> None:
        self._board = board
        self._say = say
        self._state: State | None = None
        self._status = Status(0, 0.0, State.IDLE, earth=False)
        self._headings: list[float] = []  # of the orientations of this exploration [rad]
        self._densities: list[Density] = []
        self._sources: list[Source] = []
        self._alignments: list[Alignment] = []
        self._separations: list[Separation] = []
        self._numbers = {"exploration": 0, "estimate": 0, "plan": 0, "separation": 0}
        self._fault = ""
        self._beat()

    @property
    def status(self) -> Status:
        """The mission at a glance."""
        return self._status

    @property
    def sources(self) -> list[Source]:
        """The sources of the latest estimate."""
        return self._sources

    def observe(self, snapshot: Snapshot) -> None:
        """Take in how things stand."""
        if snapshot.settled and self._status.heading_goal is not None:
            self._know(heading_goal=None)
        if snapshot.fault and snapshot.fault != self._fault:
            self._say(Severity.ERROR, f"fault: {snapshot.fault}")
        self._fault = snapshot.fault
        self._stand(snapshot)
        self._board.put(Rank.STATUS, [self._status])

    def handle(self, event: Event, snapshot: Snapshot) -> None:
        """Take in what the mission has just said."""
        self._stand(snapshot)
        self._learn(event, Stamp(snapshot.time_usec, snapshot.earth))
        said = line(event)
        if said is not None:
            self._say(*said)
        self._board.tell(Rank.STATUS, [self._status])

    def _learn(self, event: Event, stamp: Stamp) -> None:
        match event:
            case StateChanged():
                self._enter(event)
            case NoiseMeasured():
                self._know(noise_measured=event.level_db is not None)
            case OrientationHeard():
                self._orient(event, stamp)
            case SourcesEstimated():
                self._estimate(event, stamp)
            case AlignmentPlanned():
                self._plan(event, stamp)
            case TurnStarted():
                self._turn(event)
            case Checked() | Separated():
                self._separate(event, stamp)
            case ScoreDropped():
                self._know(target_found=False, target=None, score=event.value)
            case Finished():
                found = FOUND.get(event.outcome, self._status.target_found)
                self._know(outcome=int(event.outcome), target_found=found, heading_goal=None)

    def _enter(self, event: StateChanged) -> None:
        self._state = event.state
        begun = event.state not in scene.RESTING and event.state is not State.FAULT
        self._know(state=int(event.state), **({"outcome": None} if begun else {}))
        self._beat()

    def _orient(self, event: OrientationHeard, stamp: Stamp) -> None:
        if event.index == 0:
            self._headings, self._densities = [], []
            self._count("exploration")
        self._headings.append(event.heading)
        self._densities += scene.densities(event, self._numbers["exploration"], stamp)
        self._board.tell(Rank.DENSITY, self._densities)
        self._know(rotation=event.index)

    def _estimate(self, event: SourcesEstimated, stamp: Stamp) -> None:
        axis = scene.common_axis(self._headings)
        self._sources = scene.sources(event.estimate, self._count("estimate"), stamp, axis, event.final)
        self._alignments, self._separations = [], []  # they speak of the sources of an older estimate
        self._know(k=event.estimate.k, certain=event.estimate.certain, target=None, target_found=False)
        self._board.tell(Rank.SOURCE, self._sources)
        for rank in (Rank.ALIGNMENT, Rank.SEPARATION, Rank.ISOLATION):
            self._board.tell(rank, [])

    def _plan(self, event: AlignmentPlanned, stamp: Stamp) -> None:
        number = self._count("plan")
        self._alignments = scene.alignments(event, number, stamp)
        self._board.tell(Rank.ALIGNMENT, self._alignments)
        self._board.tell(Rank.ISOLATION, scene.isolations(event, number, stamp))

    def _turn(self, event: TurnStarted) -> None:
        self._know(heading_goal=event.heading)
        if self._state is State.ALIGN_TURN:
            here = [a for a in self._alignments if abs(a.joint - event.joint) < SAME_ANGLE]
            self._mark(here, CandidateState.TURNING)

    def _separate(self, event: Checked | Separated, stamp: Stamp) -> None:
        group = scene.chosen(event)
        preferred = event.candidate.source if isinstance(event, Checked) else self._status.target
        target = None if group is None else scene.target_of(event.groups[group], preferred)
        self._know(target=target, target_found=group is not None, score=scene.leading_score(event))
        self._sources = scene.scored(self._sources, event.groups, target)
        self._board.tell(Rank.SOURCE, self._sources)
        if isinstance(event, Checked):
            tried = [a for a in self._alignments if a.source == event.candidate.source]
            self._mark(tried, scene.verdict(event))
        number, criterion = self._count("separation"), self._status.criterion
        self._separations = scene.separations(event, number, stamp, criterion)
        self._board.tell(Rank.SEPARATION, self._separations)

    def _mark(self, changed: list[Alignment], state: CandidateState) -> None:
        self._alignments = [replace(a, state=state) if a in changed else a for a in self._alignments]
        self._board.tell(Rank.ALIGNMENT, self._alignments)

    def _stand(self, snapshot: Snapshot) -> None:
        self._know(
            time_usec=snapshot.time_usec,
            time_unix=snapshot.unix,
            mission_time=snapshot.mission_time,
            earth=snapshot.earth,
            heading=snapshot.heading,
            mount_yaw=snapshot.mount_yaw,
            joint=snapshot.joint,
            joint_rate=snapshot.joint_rate,
            actuator_present=snapshot.present,
            settled=snapshot.settled,
            homed=snapshot.homed,
            fault=bool(snapshot.fault),
            open_loop=snapshot.open_loop,
            rotation_max=snapshot.rotation_max,
            criterion=snapshot.criterion,
        )

    def _beat(self) -> None:
        self._board.tell(Rank.HEARTBEAT, [Heartbeat(scene.health(self._state), int(self._state or State.IDLE))])

    def _know(self, **changes: float | bool | None) -> None:
        self._status = replace(self._status, **changes)  # type: ignore[arg-type]

    def _count(self, what: str) -> int:
        self._numbers[what] += 1
        return self._numbers[what]
