"""The mission on a DroneCAN bus: status and sources as broadcasts, news as log messages, health in the heartbeat.

`heard` and `said` are called on the mission's thread and only leave things where the pump finds them; `poll` runs on
the pump and does the rest.
"""

from __future__ import annotations

from collections.abc import Callable
from queue import SimpleQueue

from ross_payload.config import Config
from ross_payload.dronecan.node import Node
from ross_payload.events import (
    AlignmentCandidate,
    AlignmentPlanned,
    Checked,
    Event,
    SourcesEstimated,
    State,
    StateChanged,
    TurnStarted,
)
from ross_payload.interfaces import Actuator, Feedback, Input
from ross_payload.telemetry.report import SAME_ANGLE, Reporter
from ross_payload.telemetry.scene import RESTING
from ross_payload.telemetry.service import drained
from ross_payload.telemetry.standing import Moment, Snapshot, standing
from ross_payload.telemetry.streams import Board, Every
from ross_payload.telemetry.texts import BURST, PERIOD, Limiter
from ross_payload.timebase import Timebase
from ross_protocols import values
from ross_protocols.dronecan import Health, LogMessage, Mode
from ross_protocols.dronecan_ross import RossSource, RossSources, RossStatus
from ross_protocols.values import Severity

NAME = "ross"  # of the source of our log messages
INFO, WARNING, ERROR = 1, 2, 3  # levels of a log message
LEVELS = {Severity.INFO: INFO, Severity.NOTICE: INFO, Severity.WARNING: WARNING}


class DronecanReport:
    """Observes a mission and speaks for it on the bus.

    Parameters
    ----------
    node
        Ours.
    actuator
        What turns.
    timebase
        Tells the time.
    config
        Tells what is in force.
    """

    def __init__(self, node: Node, actuator: Actuator, timebase: Timebase, config: Callable[[], Config]) -> None:
        self._node = node
        self._actuator = actuator
        self._timebase = timebase
        self._config = config
        self._open_loop = actuator.capabilities.feedback is Feedback.MODEL
        self._events: SimpleQueue[tuple[Event, Input]] = SimpleQueue()
        self._latest: Input | None = None
        self._reporter = Reporter(Board(), self._say)
        self._limiter = Limiter(BURST, PERIOD)
        self._now = 0.0
        self._state: State | None = None
        self._alignment: AlignmentCandidate | None = None
        self._planned: tuple[AlignmentCandidate, ...] = ()
        self._told: RossSources | None = None
        rates = config().dronecan
        self._status_due, self._sources_due = Every(1 / rates.status_hz), Every(1 / rates.sources_hz)

    @property
    def resting(self) -> bool:
        """Whether no task runs, as far as is known here."""
        return self._state in (*RESTING, State.FAULT)

    # ------------------------------------------------------------------------------------- from any thread

    def heard(self, heard: Input) -> None:
        """Keep what was heard last."""
        self._latest = heard

    def said(self, event: Event, heard: Input) -> None:
        """Leave what the mission has just said to the pump."""
        self._events.put((event, heard))

    # ------------------------------------------------------------------------------------- on the pump

    def poll(self, now: float) -> None:
        """Take in what was left here, and broadcast what is due at ``now`` [s]."""
        self._now = now
        for event, heard in drained(self._events):
            self._reporter.handle(event, self._snapshot(heard))
            self._follow(event)
        if self._latest is not None and self._status_due.due(now):  # before that the actuator is not ready either
            self._reporter.observe(self._snapshot(self._latest))
            self._node.stands(health(self._state), Mode.OPERATIONAL, int(self._state or State.IDLE))
            self._node.send(status_of(self._reporter.status, self._alignment))
        sources = sources_of(self._reporter.sources)
        if self._sources_due.due(now) or sources != self._told:
            self._told = sources
            self._node.send(sources)

    def _follow(self, event: Event) -> None:
        """Remember the state, and which candidate the array is turned to for."""
        match event:
            case StateChanged():
                self._state = event.state
            case SourcesEstimated():
                self._planned, self._alignment = (), None
            case AlignmentPlanned():
                self._planned = event.candidates
                self._alignment = event.candidates[0] if event.candidates else None
            case TurnStarted() if self._state is State.ALIGN_TURN:
                near = (each for each in self._planned if abs(each.joint - event.joint) < SAME_ANGLE)
                self._alignment = next(near, self._alignment)
            case Checked():
                self._alignment = event.candidate

    def _snapshot(self, heard: Input | None) -> Snapshot:
        moment = Moment(self._timebase.usec(), self._timebase.unix, self._config(), self._open_loop)
        return standing(heard, self._actuator.state(), moment)

    def _say(self, severity: Severity, text: str) -> None:
        if self._limiter.passes(severity, self._now):
            self._node.send(LogMessage(LEVELS.get(severity, ERROR), NAME, text))


def health(state: State | None) -> Health:
    """Return the health of a node: a fault is an error, a stop by order is none.

    >>> health(State.FAULT).name, health(State.STOPPED).name
    ('ERROR', 'OK')
    """
    return Health.ERROR if state is State.FAULT else Health.OK


def status_of(status: values.Status, alignment: AlignmentCandidate | None) -> RossStatus:
    """Return what is broadcast of a status."""
    return RossStatus(
        state=status.state,
        outcome=status.outcome,
        k=status.k,
        target=status.target,
        rotation=status.rotation,
        heading=status.heading,
        heading_goal=status.heading_goal,
        alignment=None if alignment is None else alignment.heading,
        joint=status.joint,
        score=status.score,
        gain_db=None if alignment is None else alignment.gain_db,
        earth=status.earth,
        actuator=status.actuator_present,
        settled=status.settled,
        homed=status.homed,
        fault=status.fault,
        open_loop=status.open_loop,
        target_found=status.target_found,
        certain=status.certain,
    )


def sources_of(sources: list[values.Source]) -> RossSources:
    """Return what is broadcast of the sources of one estimate."""
    told = (
        RossSource(
            azimuth=source.azimuth,
            sigma=source.sigma,
            confidence=source.confidence,
            mirror=source.mirror,
            elevation=source.elevation,
            score=source.score,
            resolved=source.resolved,
            target=source.target,
        )
        for source in sources
    )
    if not sources:
        return RossSources(0)
    first = sources[0]
    return RossSources(first.estimate, tuple(told), earth=first.earth, final=first.final)
