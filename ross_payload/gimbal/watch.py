"""What the mission does, from what it says: whether a task of its own runs, ours, or none, and what bars any motion."""

from __future__ import annotations

from ross_payload.events import Answer, Answered, Event, State, StateChanged

RESTING = (State.IDLE, State.DONE, State.STOPPED, State.FAULT)
ENDED = (Answer.DONE, Answer.FAILED, Answer.CANCELLED)


class Watch:
    """Follows the mission. Orders of ours have numbers below 0.

    >>> watch = Watch()
    >>> watch.said(StateChanged(0.0, State.EXPLORE_TURN))
    >>> watch.busy
    True
    >>> watch.cancelled(-1)
    >>> watch.busy
    False
    """

    def __init__(self) -> None:
        self.hand = False  # a set-point of ours is followed
        self.barred = ""  # why nothing may move
        self._running = False
        self._cancel = 0  # number of the order that ends the task, until it is answered

    @property
    def busy(self) -> bool:
        """Whether a task runs that is not ours, and that nobody has ended."""
        return self._running and not self.hand and not self._cancel

    def cancelled(self, number: int) -> None:
        """Note that an order with this number ends the task: what comes behind it finds the mission at rest."""
        self._cancel = number

    def said(self, event: Event) -> None:
        """Note what the mission says."""
        if isinstance(event, StateChanged):
            self._running = event.state not in RESTING
            self.barred = ""
            if event.state is State.STOPPED:
                self.barred = "stopped: re-arm first"
            elif event.state is State.FAULT:
                self.barred = f"fault: {event.detail}"
        elif isinstance(event, Answered) and event.order < 0:
            self._answered(event)

    def _answered(self, event: Answered) -> None:
        if event.order == self._cancel:
            self._cancel = 0
        elif event.answer is Answer.ACCEPTED:
            self.hand = True
        elif event.answer in ENDED:
            self.hand = False
