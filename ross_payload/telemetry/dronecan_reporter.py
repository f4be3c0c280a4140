"""The mission on a DroneCAN bus: status and sources as broadcasts, news as log messages, health in the heartbeat.

`on_input` and `on_event` run on the mission's thread and only leave things where the pump finds them; `poll` runs on
the pump and does the rest.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from queue import SimpleQueue
from typing import Any

from ross_payload.clock import Every
from ross_payload.config import Config
from ross_payload.dronecan.node import Node
from ross_payload.events import AlignmentCandidate, Event, State
from ross_payload.interfaces import Actuator, Feedback, Input
from ross_payload.mavlink.message_board import Board
from ross_payload.telemetry.reporter import Reporter
from ross_payload.telemetry.snapshot import Moment, Snapshot, standing
from ross_payload.telemetry.status_texts import may_say, operator_texts
from ross_payload.timebase import Timebase
from ross_payload.transport.async_task import drained
from ross_protocols.dronecan.messages import Health, LogMessage, Mode
from ross_protocols.dronecan.ross_types import RossSource, RossSources, RossStatus
from ross_protocols.mavlink import values
from ross_protocols.mavlink.values import Severity

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
    sought
        A voice is enrolled from the beginning, and scores say how much others sound like it.
    """

    def __init__(
        self, node: Node, actuator: Actuator, timebase: Timebase, config: Callable[[], Config], *, sought: bool = True
    ) -> None:
        self._node = node
        self._actuator = actuator
        self._timebase = timebase
        self._config = config
        self._open_loop = actuator.capabilities.feedback is Feedback.MODEL
        self._events: SimpleQueue[tuple[Event, Input]] = SimpleQueue()
        self._latest: Input | None = None
        self._reporter = Reporter(Board(), self._send_text, sought=sought)
        self._bucket = operator_texts()
        self._now = 0.0
        self._last_sources: RossSources | None = None
        rates = config().dronecan
        self._status_due, self._sources_due = Every(1 / rates.status_hz), Every(1 / rates.sources_hz)

    @property
    def resting(self) -> bool:
        """Whether no task runs, as far as is known here."""
        return self._reporter.mission.resting

    # ------------------------------------------------------------------------------------- from any thread

    def on_input(self, hop: Input) -> None:
        """Keep what was heard last."""
        self._latest = hop

    def on_event(self, event: Event, hop: Input) -> None:
        """Leave what the mission has just said to the pump."""
        self._events.put((event, hop))

    # ------------------------------------------------------------------------------------- on the pump

    def poll(self, now: float) -> None:
        """Take in what was left here, and broadcast what is due at ``now`` [s]."""
        self._now = now
        for event, heard in drained(self._events):
            self._reporter.handle(event, self._snapshot(heard))
        if self._latest is not None and self._status_due.due(now):  # before that the actuator is not ready either
            self._reporter.observe(self._snapshot(self._latest))
            mission = self._reporter.mission
            self._node.stands(health(mission.state), Mode.OPERATIONAL, int(mission.state or State.IDLE))
            self._node.send(status_of(self._reporter.status, mission.alignment))
        sources = sources_of(self._reporter.sources)
        if self._sources_due.due(now) or sources != self._last_sources:
            self._last_sources = sources
            self._node.send(sources)

    def _snapshot(self, hop: Input | None) -> Snapshot:
        moment = Moment(self._timebase.usec(), self._timebase.unix, self._config(), self._open_loop)
        return standing(hop, self._actuator.state(), moment)

    def _send_text(self, severity: Severity, text: str) -> None:
        if may_say(self._bucket, severity, self._now):
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
        **_shared(RossStatus, status),
        actuator=status.actuator_present,
        alignment=None if alignment is None else alignment.heading,
        gain_db=None if alignment is None else alignment.gain_db,
    )


def sources_of(sources: list[values.Source]) -> RossSources:
    """Return what is broadcast of the sources of one estimate."""
    if not sources:
        return RossSources(0)
    first = sources[0]
    broadcast = tuple(RossSource(**_shared(RossSource, source)) for source in sources)
    return RossSources(first.estimate, broadcast, earth=first.earth, final=first.final)


def _shared(kind: type[RossStatus | RossSource], value: values.Value) -> dict[str, Any]:
    """Return the attributes of a value that a broadcast has under the same names."""
    return {each.name: getattr(value, each.name) for each in fields(kind) if hasattr(value, each.name)}
