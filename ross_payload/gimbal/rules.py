"""Who is obeyed when. The last explicit act counts: an order for a task, or taking control; what streams does not.

- While a task of the mission runs, the mission is in control, and nobody else points.
- Taking control by CONFIGURE ends the task. The array is at rest, and the mission does not go on by itself.
- Ordering a task takes control back from whoever had it.
- A set-point that was said in vain is not obeyed later, unless it changes.
- A rate counts as long as somebody renews it.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import replace

from ross_payload.events import Answer, Answered, Event
from ross_payload.gimbal.body import Body
from ross_payload.gimbal.control import NOBODY, Control
from ross_payload.gimbal.hand import Hand, Said
from ross_payload.gimbal.watch import Watch
from ross_payload.orders import Order
from ross_payload.telemetry.requests import ACCEPTED, Verdict
from ross_protocols.commands import Result
from ross_protocols.gimbal import Address
from ross_protocols.own_gimbal import Aim

PATIENCE = 1.5  # [s] that a rate counts: ground stations send one every 0.5 s, and links lose some

log = logging.getLogger(__name__)


class Rules:
    """Judges set-points and control, and gives the orders that follow.

    Parameters
    ----------
    body
        What would turn.
    give
        Hands an order to the runner.
    payload
        Tells the address of the mission.
    """

    def __init__(self, body: Body, give: Callable[[Order], None], payload: Callable[[], Address]) -> None:
        self._body = body
        self._payload = payload
        self._watch = Watch()
        self._hand = Hand(give, body.park)
        self._said = Said()
        self._control = Control()
        self._streams = NOBODY  # who sent the last set-point that nobody acknowledges

    @property
    def control(self) -> Control:
        """Who is in control, the mission while a task of it runs."""
        return replace(self._control, primary=self._payload()) if self._watch.busy else self._control

    @property
    def aim(self) -> Aim | None:
        """What the array follows, or has reached, by hand."""
        return self._hand.aim

    def said(self, event: Event) -> None:
        """Take what the mission says."""
        busy = self._watch.busy
        self._watch.said(event)
        if self._watch.busy and not busy:
            self._control = Control()
            self._hand.forget()
        elif self._watch.barred:
            self._cancel()
        elif isinstance(event, Answered) and event.order < 0:
            self._answered(event)

    def tick(self, now: float) -> None:
        """End what nobody renews."""
        self._hand.tick(now)

    def point(self, aim: Aim, who: Address, now: float) -> Verdict:
        """Obey a command."""
        verdict = self._judged(aim, who, now)
        if verdict is ACCEPTED:
            self._said.forget(who)
            self._hand.forget()  # also what is in force already is ordered once more
            self._hand.point(aim, self._body.offset(), now + PATIENCE)
        return verdict

    def stream(self, aim: Aim, who: Address, now: float, patience: float = PATIENCE) -> None:
        """Obey a message, one of many that nobody acknowledges, unless it only repeats what was said in vain.

        A rate alone counts for ``patience`` [s].
        """
        if self._forbidden(who) or self._watch.barred:
            self._said.note(who, aim)
        elif self._said.is_news(who, aim) and not self._body.unable(aim, now):
            self._streams = who
            self._hand.point(aim, self._body.offset(), now + patience)

    def meet(self, aim: Aim, who: Address) -> None:
        """Note what somebody said before we listened: it is no order."""
        self._said.note(who, aim)

    def configure(self, control: Control, who: Address, taken: bool) -> None:
        """Let others be in control; who takes it finds the array at rest, and so does who comes after a release."""
        if control.primary == self._payload():
            control = replace(control, primary=NOBODY)
        if control.primary != NOBODY and taken:
            self._said.forget(control.primary)
            if self._watch.busy:
                self._watch.cancelled(self._hand.cancel())
        if control.primary != self._control.primary:
            log.info("%s is in control, as %d/%d requested", _named(control.primary), *who)
            if self._watch.hand or self._hand.aim is not None:
                self._hand.still()
        self._control = control

    def _answered(self, event: Answered) -> None:
        """Forget what the mission does not follow, or not any more."""
        if event.answer is Answer.CANCELLED:
            self._cancel()
        elif event.answer is Answer.FAILED or (event.answer is Answer.REFUSED and event.order == self._hand.latest):
            self._hand.forget()

    def _cancel(self) -> None:
        """Forget what somebody has ended: it does not begin again because it goes on being streamed."""
        if self._hand.aim is not None:
            self._said.note(self._streams, self._hand.aim)
        self._hand.forget()

    def _judged(self, aim: Aim, who: Address, now: float) -> Verdict:
        forbidden = self._forbidden(who)
        if forbidden:
            return Verdict(Result.DENIED, forbidden)
        reason = self._watch.barred or self._body.unable(aim, now)
        return Verdict(Result.TEMPORARILY_REJECTED, reason) if reason else ACCEPTED

    def _forbidden(self, who: Address) -> str:
        if self._watch.busy:
            return "a task of the mission runs: take control first"
        return "" if self._control.allows(who) else "another component is in control"


def _named(who: Address) -> str:
    return "nobody" if who == NOBODY else f"{who[0]}/{who[1]}"
