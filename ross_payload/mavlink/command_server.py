"""The command server of a component: who may command, how often, what obeys, and what is acknowledged."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Mapping
from typing import NamedTuple

from ross_payload.mavlink.component import Component, Received
from ross_payload.token_bucket import TokenBucket
from ross_protocols.mavlink.commands import (
    COMMAND_CANCEL,
    COMMAND_INT,
    COMMAND_LONG,
    CancelRequest,
    Command,
    Result,
    acknowledgement,
)
from ross_protocols.mavlink.component_id import ComponentId

BURST, RATE = 40, 20.0  # commands of one sender at once, and [1/s]; what is more is not even answered
SENDERS = 64  # that have an allowance of their own


class Verdict(NamedTuple):
    """What becomes of a command, and why."""

    result: Result
    reason: str = ""


ACCEPTED = Verdict(Result.ACCEPTED)

Handler = Callable[[Command, Received, float], Verdict | None]  # at a time [s]; None: it acknowledges by itself


def ignore_cancel(request: CancelRequest, received: Received) -> None:
    """Cancel nothing: no command of the component takes time."""


def know_nothing(command: Command, received: Received, now: float) -> bool:
    """Take nothing for a repetition: every command is answered at once."""
    return False


def explain_nothing(command: Command, reason: str) -> None:
    """Refuse in silence: nobody reads what the component says."""


class CommandServer:
    """Answers the commands that are meant for one component.

    Parameters
    ----------
    component
        Ours.
    handlers
        What obeys commands, by their number.
    urgent
        Numbers of commands that are obeyed however often they arrive; their handler sees to what is answered.
    on_cancel
        Ends a command that is in progress.
    repeated
        Answers a command that is only sent again; tells whether it is.
    explain
        Tells an operator why a command is refused.
    """

    def __init__(
        self,
        component: Component,
        handlers: Mapping[int, Handler],
        *,
        urgent: frozenset[int] = frozenset(),
        on_cancel: Callable[[CancelRequest, Received], None] = ignore_cancel,
        repeated: Callable[[Command, Received, float], bool] = know_nothing,
        explain: Callable[[Command, str], None] = explain_nothing,
    ) -> None:
        self._component = component
        self._handlers = handlers
        self._urgent = urgent
        self._on_cancel = on_cancel
        self._repeated = repeated
        self._explain = explain
        self._buckets: OrderedDict[ComponentId, TokenBucket] = OrderedDict()
        self._now = 0.0
        component.subscribe(self.on_packet, COMMAND_LONG, COMMAND_INT, COMMAND_CANCEL)

    def on_packet(self, received: Received) -> None:
        """Take a packet; what is no command, or not for us, passes by."""
        request, sender = received.request, received.packet.sender
        if request is None or not request.target.includes(self._component.id):
            return
        if isinstance(request, CancelRequest):
            self._on_cancel(request, received)
        elif received.may_order and request.number in self._urgent:
            self._handlers[request.number](request, received, self._now)
        elif self.allows(sender):
            verdict = self._verdict(request, received)
            if verdict is not None and (verdict is ACCEPTED or not request.target.is_broadcast):
                self.answer(request, sender, verdict)  # of what is refused nobody asked us in particular

    def tick(self, now: float) -> None:
        """Take the time [s]."""
        self._now = now

    def allows(self, sender: ComponentId) -> bool:
        """Tell whether a sender may be answered once more; it may not ask too often."""
        bucket = self._buckets.setdefault(sender, TokenBucket(BURST, RATE))
        self._buckets.move_to_end(sender)
        if len(self._buckets) > SENDERS:
            self._buckets.popitem(last=False)
        return bucket.spend(self._now)

    def answer(self, command: Command, sender: ComponentId, verdict: Verdict) -> None:
        """Acknowledge a command, and explain why it is refused."""
        self.acknowledge(command, sender, verdict.result)
        if verdict.reason:
            self._explain(command, verdict.reason)

    def acknowledge(self, command: Command, sender: ComponentId, result: Result, progress: float | None = None) -> None:
        """Tell a sender what has become of its command; ``progress`` is 0 to 1, None: not known."""
        self._component.send(acknowledgement(command.number, result, sender, progress))

    def _verdict(self, command: Command, received: Received) -> Verdict | None:
        if received.waited and self._repeated(command, received, self._now):
            return None
        if not received.may_order:
            return Verdict(Result.TEMPORARILY_REJECTED if received.waited else Result.DENIED, received.refusal)
        handler = self._handlers.get(command.number)
        return Verdict(Result.UNSUPPORTED) if handler is None else handler(command, received, self._now)
