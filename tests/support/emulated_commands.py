"""What obeys commands in an emulated payload: tasks take two seconds, a stop ends them, and nothing turns."""

from ross_payload.config import Config
from ross_payload.events import Answer, Answered, Estimate, SourceEstimate, SourcesEstimated, State, StateChanged
from ross_payload.mavlink.message_board import Board
from ross_payload.mavlink.message_requests import MessageRequests
from ross_payload.mavlink.message_scheduler import MessageScheduler, periods
from ross_payload.mavlink.mission_commands import MissionCommands
from ross_payload.orders import Cancel, Rearm, Stop, Task

TASK = 2.0  # [s]
TALKERS = 3


class EmulatedCommands:
    """Obeys orders in its own time; ``state`` is what the payload is in because of them, None: none was given."""

    def __init__(self, links, component, say):
        self.state = None
        self._now = 0.0
        self._task, self._end = None, 0.0
        self._events = []
        scheduler = MessageScheduler(Board(), links, component, periods(Config().telemetry))
        self._server = MissionCommands(component, self._give, lambda on: "", say, MessageRequests(component, scheduler))
        source = SourceEstimate(0.0, 0.1, 0.9, True)
        self._server.on_event(SourcesEstimated(0.0, Estimate((source,) * TALKERS), 4, final=True))

    def tick(self, now):
        self._now = now
        if self._task is not None and now >= self._end:
            self._close(Answer.DONE, "done")
        events, self._events = self._events, []
        for event in events:
            self._server.on_event(event)
        self._server.tick(now)

    def _give(self, order):
        if isinstance(order, (Stop, Cancel)) and self._task is not None:
            self._close(Answer.CANCELLED, "ended by command")
        if isinstance(order, Stop):
            self._enter(State.STOPPED)
        elif isinstance(order, Rearm):
            self._enter(State.IDLE)
        self._answer(order, Answer.ACCEPTED)
        if isinstance(order, Task):
            self._task, self._end = order, self._now + TASK
            self._enter(State.RUN)
            self._answer(order, Answer.PROGRESS, progress=0.5)

    def _close(self, answer, reason):
        self._answer(self._task, answer, reason)
        self._task = None
        self._enter(State.DONE)

    def _enter(self, state):
        self.state = int(state)
        self._events.append(StateChanged(self._now, state))

    def _answer(self, order, answer, reason="", progress=0.0):
        self._events.append(Answered(self._now, order.number, answer, reason, progress=progress))
