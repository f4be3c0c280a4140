"""What the pump knows of the mission: enough to refuse at once what the mission would refuse later.

The mission's thread may be computing for seconds; a ground station wants its answer now. The mission has the last
word: what passes here may still be refused there.
"""

from __future__ import annotations

from ross_payload.events import Answer, Answered, Event, State, StateChanged
from ross_payload.mavlink.command_server import Verdict
from ross_payload.mission_state import BUSY, STOPPED, MissionState, reduce
from ross_payload.orders import Enrol, Home, ListenTo, Order, Rearm, Stop, Task
from ross_protocols.mavlink.commands import Result

ENDED = (Answer.REFUSED, Answer.DONE, Answer.FAILED, Answer.CANCELLED)


class CommandGate:
    """Follows orders and events, and tells what cannot be ordered at present."""

    def __init__(self) -> None:
        self._mission = MissionState()
        self._unanswered: dict[int, Order] = {}
        self._running: int | None = None  # number of the task that is going on

    def on_order(self, order: Order) -> None:
        """Note an order on its way to the mission."""
        self._unanswered[order.number] = order

    def on_event(self, event: Event) -> None:
        """Note what the mission says."""
        self._mission = reduce(self._mission, event)
        if isinstance(event, Answered):
            self._answered(event)
        elif isinstance(event, StateChanged) and self._mission.resting:
            self._running = None

    def _answered(self, event: Answered) -> None:
        order = self._unanswered.get(event.order)
        if event.answer is Answer.ACCEPTED and isinstance(order, Task):
            self._running = event.order
        if event.answer is not Answer.PROGRESS:
            self._unanswered.pop(event.order, None)
        if event.answer in ENDED and event.order == self._running:
            self._running = None

    def refusal(self, order: Order) -> Verdict | None:
        """Return why an order cannot be obeyed at present; None: as far as is known here, it can."""
        stopping = any(isinstance(other, Stop) for other in self._unanswered.values())
        if isinstance(order, Rearm):
            busy = self._running is not None or self._waiting
            return Verdict(Result.TEMPORARILY_REJECTED, BUSY) if busy and not stopping else None
        if not isinstance(order, Task):
            return None
        reason = self._state_forbids(order, stopping=stopping)
        if reason:
            return Verdict(Result.TEMPORARILY_REJECTED, reason)
        known = self._mission.known
        source = source_of(order)
        if source is not None and known is not None and source >= known:
            return Verdict(Result.DENIED, f"source: expected 0 to {known - 1}, got {source}")
        return None

    def _state_forbids(self, order: Task, *, stopping: bool) -> str:
        mission = self._mission
        if stopping:
            return STOPPED
        if mission.barred and not (mission.state is State.FAULT and isinstance(order, Home)):
            return mission.barred
        if self._waiting or (self._running is not None and mission.state is not State.RUN):
            return BUSY
        if source_of(order) is not None and mission.known is None:
            return "no source is known: explore first"
        return ""

    @property
    def _waiting(self) -> bool:
        """A task is on its way to the mission."""
        return any(isinstance(order, Task) for order in self._unanswered.values())


def source_of(order: Order) -> int | None:
    """Return the source of the latest estimate that an order means; None: it means none."""
    return order.source if isinstance(order, ListenTo | Enrol) else None
