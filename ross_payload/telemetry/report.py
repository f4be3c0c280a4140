"""The reporter: what the mission says and how things stand, as MAVLink values at the right times.

It owns no port, no clock and no thread: values go to ``send``, time comes from ``time_usec`` and ``tick``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

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
from ross_payload.telemetry.texts import PREFIX, Limiter, line
from ross_protocols.codec import chunks
from ross_protocols.values import (
    Alignment,
    CandidateState,
    Heartbeat,
    Information,
    Separation,
    Severity,
    Source,
    Status,
    Value,
)

HEARTBEAT_PERIOD = 1.0  # [s]
STATUS_PERIOD = 0.25  # [s]
INFORMATION_PERIOD = 10.0  # [s]
REPEAT_PERIOD = 5.0  # [s], of what was found out, for those who join late or lost it
TEXT_BURST = 8
TEXT_PERIOD = 2.0  # [s]
SAME_ANGLE = 1e-6  # [rad]


@dataclass(frozen=True, slots=True)
class Snapshot:
    """How things stand at one moment; angles in radians, counter-clockwise."""

    mission_time: float  # [s]
    earth: bool  # headings are in the earth frame
    heading: float | None = None
    mount_yaw: float | None = None
    present: bool = False  # an actuator reports; else what follows means nothing
    joint: float | None = None
    joint_rate: float | None = None  # [rad/s]
    settled: bool = False
    homed: bool = False
    open_loop: bool = False
    fault: str = ""


class Every:
    """Tells when something periodic is due; the first time at once, without drift, without catching up.

    >>> second = Every(1.0)
    >>> [second.due(now) for now in (0.0, 0.9, 1.05, 2.0, 7.0, 7.5)]
    [True, False, True, True, True, False]
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self._next: float | None = None

    def due(self, now: float) -> bool:
        """Tell whether it is due at ``now`` [s], once."""
        if self._next is not None and now < self._next - 1e-9:
            return False
        upcoming = now if self._next is None else self._next
        self._next = upcoming + self._period if upcoming + self._period > now else now + self._period
        return True


class Reporter:
    """Turns a mission into telemetry."""

    def __init__(
        self,
        send: Callable[[Value], None],
        time_usec: Callable[[], int],
        information: Information,
        *,
        rotation_max: int,
        criterion: float,
    ) -> None:
        self._send = send
        self._time_usec = time_usec
        self._information = information
        self._criterion = criterion
        self._state: State | None = None
        self._status = Status(0, 0.0, State.IDLE, earth=False, criterion=criterion, rotation_max=rotation_max)
        self._headings: list[float] = []  # of the orientations of this exploration [rad]
        self._sources: list[Source] = []
        self._alignments: list[Alignment] = []
        self._separations: list[Separation] = []
        self._numbers = {"estimate": 0, "plan": 0, "separation": 0, "text": 0}
        self._fault = ""
        self._limiter = Limiter(TEXT_BURST, TEXT_PERIOD)
        self._heartbeat = Every(HEARTBEAT_PERIOD)
        self._informing = Every(INFORMATION_PERIOD)
        self._reporting = Every(STATUS_PERIOD)
        self._repeating = Every(REPEAT_PERIOD)

    def tick(self, now: float, snapshot: Snapshot) -> None:
        """Send what is due at ``now`` [s]; to be called at least every 100 ms or so."""
        self._settle(snapshot)
        if self._heartbeat.due(now):
            self._beat()
        if self._informing.due(now):
            self._emit(replace(self._information, time_usec=self._time_usec()))
        if self._reporting.due(now):
            self._report(snapshot)
        if self._repeating.due(now):
            self._emit_all([*self._sources, *self._alignments, *self._separations])

    def handle(self, event: Event, snapshot: Snapshot) -> None:
        """Tell what the mission has just said."""
        stamp = Stamp(self._time_usec(), snapshot.earth)
        match event:
            case StateChanged():
                self._enter(event)
            case NoiseMeasured():
                self._know(noise_measured=event.level_db is not None)
            case OrientationHeard():
                self._orient(event)
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
                found = event.outcome is Outcome.TARGET_FOUND
                self._know(outcome=int(event.outcome), target_found=found, heading_goal=None)
        said = line(event)
        if said is not None:
            self._say(*said)
        self._report(snapshot)

    def _enter(self, event: StateChanged) -> None:
        before, self._state = scene.health(self._state), event.state
        self._know(state=int(event.state))
        if scene.health(event.state) is not before:
            self._beat()

    def _orient(self, event: OrientationHeard) -> None:
        if event.index == 0:
            self._headings = []
        self._headings.append(event.heading)
        self._know(rotation=event.index)

    def _estimate(self, event: SourcesEstimated, stamp: Stamp) -> None:
        axis = scene.common_axis(self._headings)
        self._sources = scene.sources(event.estimate, self._count("estimate"), stamp, axis, event.final)
        self._alignments, self._separations = [], []  # they speak of the sources of an older estimate
        self._know(k=event.estimate.k, certain=event.estimate.certain, target=None, target_found=False)
        self._emit_all(self._sources)

    def _plan(self, event: AlignmentPlanned, stamp: Stamp) -> None:
        self._alignments = scene.alignments(event, self._count("plan"), stamp)
        self._emit_all(self._alignments)

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
        self._emit_all(self._sources)
        if isinstance(event, Checked):
            tried = [a for a in self._alignments if a.source == event.candidate.source]
            self._mark(tried, scene.verdict(event))
        self._separations = scene.separations(event, self._count("separation"), stamp, self._criterion)
        self._emit_all(self._separations)

    def _mark(self, changed: list[Alignment], state: CandidateState) -> None:
        self._alignments = [replace(a, state=state) if a in changed else a for a in self._alignments]
        self._emit_all(a for a in self._alignments if a.candidate in {c.candidate for c in changed})

    def _settle(self, snapshot: Snapshot) -> None:
        if snapshot.settled and self._status.heading_goal is not None:
            self._know(heading_goal=None)
        if snapshot.fault and snapshot.fault != self._fault:
            self._say(Severity.ERROR, f"fault: {snapshot.fault}")
        self._fault = snapshot.fault

    def _report(self, snapshot: Snapshot) -> None:
        status = replace(
            self._status,
            time_usec=self._time_usec(),
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
        )
        self._emit(status)

    def _beat(self) -> None:
        self._emit(Heartbeat(scene.health(self._state), int(self._state or State.IDLE)))

    def _say(self, severity: Severity, text: str) -> None:
        if self._limiter.passes(severity, self._time_usec() / 1e6):
            self._emit_all(chunks(severity, PREFIX + text, self._count("text") % 65535 + 1))

    def _know(self, **changes: float | bool | None) -> None:
        self._status = replace(self._status, **changes)  # type: ignore[arg-type]

    def _count(self, what: str) -> int:
        self._numbers[what] += 1
        return self._numbers[what]

    def _emit_all(self, values: Iterable[Value]) -> None:
        for value in values:
            self._emit(value)

    def _emit(self, value: Value) -> None:
        self._send(value)
