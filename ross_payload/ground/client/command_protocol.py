"""The client of the command protocol: orders to payloads, and what becomes of them. No port, no clock.

``on_packet`` gets what arrives and ``tick`` the time; messages go to ``send``. Nothing waits behind anything else.

A link loses frames and doubles them, and an acknowledgement names its command but not which one of several alike. So a
frame is sent again until it is answered, and so is one whose answers ended too early; within `DEDUP_S` the payload
answers what is said again once more and does not do it again. A final answer so soon that it may be one to the order
before is asked for again. After that time nothing is sent again: the payload would take it for a new order. Nor is what
a later order has ended or undone, unless the payload is known to have it: then a high confirmation says so.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from ross_payload.ground.client.command_status import (
    ACKNOWLEDGED,
    AFTER_STOP,
    CANCELLED,
    DONE,
    ENDS,
    FAILED,
    IN_PROGRESS,
    NO_ANSWER,
    NO_RESULT,
    NOT_ANSWERED,
    OVERTAKEN,
    REFUSED,
    REPLACED,
    RESTARTED,
    SENT,
    CommandStatus,
    reason_in,
)
from ross_payload.ground.client.command_types import Cancel, Order, Rearm, Stop, undoes
from ross_payload.ground.client.open_command import LATE_ACK_S, OpenCommand, Peer
from ross_payload.ground.model.payload_state import PayloadState, StatusText
from ross_payload.ground.model.status_text import EXPLANATION_S
from ross_protocols.mavlink.codec import Packet
from ross_protocols.mavlink.commands import (
    HEARD,
    MOST_CONFIRMATION,
    Acknowledged,
    Result,
    acknowledged_of,
    cancel_message,
    long_message,
)
from ross_protocols.mavlink.component_id import ComponentId

ACK_TIMEOUT_S, RESENDS = 1.0, 4  # [s] without an answer until a frame is sent again, and how often
STOP_ACK_TIMEOUT_S, STOP_RESENDS = 0.2, 10
STOP_LASTS_S = 30.0  # [s] that a stop is sent while nobody answers: once that was told as seldom as others
PROGRESS_TIMEOUT_S, PROGRESS_POLL_S = 2.0, 0.5  # [s] without progress until it is asked for, and how often
DEDUP_S = 4.0  # [s] within which the payload knows what is said again: it remembers for 5, and a frame may be late
REPEATED_S = 10.0  # [s] after an order, in which the payload may take its like that is said again for it
MOST_STATUSES = 50
ROUNDING_S = 1e-6  # [s], of rounding


class CommandProtocol:
    """Orders of one ground station, ``system_id`` and ``component_id``, to any number of payloads.

    >>> from ross_payload.ground.client.command_types import Turn
    >>> sent = []
    >>> orders = CommandProtocol(lambda message, who: sent.append(message.get_type()), 255, 190)
    >>> number = orders.order(ComponentId(1, 191), Turn(40.0))
    >>> sent, orders.doing[-1].words, orders.doing[-1].state
    (['COMMAND_LONG'], 'turn to 40 deg', 'sent')
    """

    def __init__(self, send: Callable[[Any, ComponentId], None], system_id: int, component_id: int) -> None:
        self._send = send
        self._us = ComponentId(system_id, component_id)
        self._doing: dict[int, CommandStatus] = {}
        self._open: dict[int, OpenCommand] = {}
        self._peers: dict[ComponentId, Peer] = {}
        self._count = 0
        self._now = 0.0

    @property
    def doing(self) -> tuple[CommandStatus, ...]:
        """The latest orders, newest last."""
        return tuple(self._doing.values())

    @property
    def stopping(self) -> frozenset[ComponentId]:
        """The payloads to which a stop is sent that they have not acknowledged."""
        return frozenset(one.who for one in self._open.values() if self._goes_unheard(one))

    def order(self, who: ComponentId, order: Order) -> int:
        """Order something at once; return the number of what becomes of it.

        Raises
        ------
        ValueError
            When a number of the order is none; nothing is sent then.
        """
        order.check()
        self._give_way(who, order)
        while len(self._doing) >= MOST_STATUSES and (oldest := self._oldest()) is not None:
            del self._doing[oldest]
            self._open.pop(oldest, None)
        self._count += 1
        peer, number = self._peer(who), order.number
        self._doing[self._count] = CommandStatus(self._count, who, order, SENT, self._now, self._now)
        self._open[self._count] = OpenCommand(
            self._count, who, order, self._now,
            self._now - peer.sent.get(number, -math.inf) < REPEATED_S,
            *peer.trusted(order),
            lasts=self._now + STOP_LASTS_S if isinstance(order, Stop) else -math.inf,
        )  # fmt: skip
        peer.sent[number] = self._now
        self._send_order(self._open[self._count])
        return self._count

    def _oldest(self) -> int | None:
        """Return the oldest order that is over, else the oldest that is no stop, which is told until it is answered."""
        going_on = {number: one for number, one in self._open.items() if not one.over}
        over = (number for number in self._doing if number not in going_on)
        others = (number for number, one in going_on.items() if not isinstance(one.order, Stop))
        return next(over, next(others, None))

    def cancel(self, number: int) -> None:
        """Ask to end an order; one that is over stays as it is, and so does a stop, which only a re-arming ends."""
        wanted = self._open.get(number)
        if wanted is not None and not (wanted.over or isinstance(wanted.order, Stop)):
            wanted.cancelling = 0
            self._send_cancel(wanted)

    def on_state(self, payload: PayloadState) -> None:
        """Learn of a payload, whenever it is heard: one that restarted does not do what it was told before."""
        peer = self._peer(payload.who)
        restarted = peer.boots is not None and payload.boots > peer.boots
        if restarted:
            for one in [one for one in self._of(payload.who) if not (one.over or self._goes_unheard(one))]:
                self._end(one, FAILED, RESTARTED)
            self._peers[payload.who] = peer = Peer()
        if restarted or peer.boots is None:
            for one in [one for one in self._of(payload.who) if self._goes_unheard(one)]:
                one.sent, one.due = min(one.sent, 1), self._now  # all its tries are before it
        peer.on_state(payload)

    def on_packet(self, packet: Packet, now: float) -> None:
        """Take a packet; what is no answer passes by."""
        self._now = now
        who = packet.sender
        peer = self._peers.get(who)
        if peer is None:
            return
        acknowledged = acknowledged_of(packet.message)
        if acknowledged is not None and acknowledged.target.includes(self._us):
            self._answered(who, acknowledged)
        for text in peer.texts.on_packet(packet, now):
            self._explain(who, text)

    def tick(self, now: float) -> None:
        """Send again what was not answered; give up what never is."""
        self._now = now
        for one in [one for one in self._open.values() if now >= one.due - ROUNDING_S]:
            self._resend(one)

    # ------------------------------------------------------------------------------------------------ sending

    def _send_order(self, one: OpenCommand) -> None:
        """Send an order, first or again.

        What is done at once is harmless when done twice, and must not be taken for its like of a moment ago: arm,
        stop, arm; a stop never is. A task must not be done twice, nor what the payload has already, or may have, and a
        later order may follow: after a cancel a task, after a re-arming a stop of somebody else. Of stops in a row the
        latest is sent for all: a key that is held must not fill a slow link.
        """
        answered = one.answered is not None or one.doubted > 0
        heard = one.heard or (isinstance(one.order, (Cancel, Rearm)) and answered)
        new = one.repeated and not (one.order.task or heard or isinstance(one.order, Stop))
        urgent = isinstance(one.order, Stop) and one.sent <= STOP_RESENDS
        one.due = self._now + (STOP_ACK_TIMEOUT_S if urgent else ACK_TIMEOUT_S)
        confirmation = 0 if new else min(one.sent + (HEARD if one.heard else 0), MOST_CONFIRMATION)
        one.sent += 1
        who = one.who
        if not isinstance(one.order, Stop) or all(other.over for other in self._later(one)):
            self._send(long_message(one.order.number, one.order.numbers, who, confirmation), who)

    def _give_way(self, who: ComponentId, order: Order) -> None:
        """What was never answered is not said again where it would undo this order.

        That is anything after a stop, a task after another one or a cancel, and a cancel after any order. A task may
        have been heard all the same: it stays open for its answers. So does a stop, which ends after its tries when
        it is ordered once more, or something is re-armed.
        """
        for one in self._of(who):
            one.lasts = -math.inf if isinstance(order, Stop | Rearm) else one.lasts
            one.undone |= {self._count + 1} if undoes(order, one.order) else set()
            overtaken = self._doing[one.number].reason == OVERTAKEN
            unanswered = one.answered is None and not one.over
            if (unanswered or overtaken) and isinstance(order, Stop) and not isinstance(one.order, Stop):
                self._end(one, CANCELLED, AFTER_STOP)
                for other in (other for other in self._of(who) if other.order.number == one.order.number):
                    other.refusable = self._now + LATE_ACK_S
            elif unanswered and isinstance(one.order, Cancel):
                self._end(one, NO_ANSWER, OVERTAKEN)
            elif not one.over and order.replaces(one.order):
                self._end(one, CANCELLED, REPLACED)
            elif unanswered and one.order.task and (order.task or isinstance(order, Cancel)):
                self._give_up(one, OVERTAKEN)

    def _resend(self, one: OpenCommand) -> None:
        """Say it again where that can help; a cancel stands for its order, and would end a later one of its kind."""
        times = STOP_RESENDS if isinstance(one.order, Stop) else RESENDS
        if one.cancelling > RESENDS:
            self._give_up(one)
        elif one.cancelling:
            self._send_cancel(one, again=True)
        elif one.answered is None:
            tries_left = one.sent <= times
            if not tries_left and self._peer(one.who).boots is not None:  # one never heard may be heard any moment
                self._tell(one, NO_ANSWER, self._why_unanswered(one))
            self._send_order(one) if tries_left or self._now < one.lasts else self._give_up(one)
        elif self._now - one.answered > DEDUP_S:
            self._give_up(one)
        else:
            if not self._is_overtaken(one):
                self._send_order(one)
            one.due = self._now + PROGRESS_POLL_S

    def _is_overtaken(self, one: OpenCommand) -> bool:
        """Whether a later one may have replaced, ended or undone it: said again, it would be done after that."""
        if isinstance(one.order, Cancel):
            return any(each.number > one.number and each.who == one.who for each in self.doing)
        if one.undone and not one.heard:
            return True
        return one.order.task and (one.unheard or bool(self._later(one)))

    def _later(self, one: OpenCommand) -> list[OpenCommand]:
        """Return what is open of its kind and was ordered after it."""
        alike = (other for other in self._of(one.who) if other.order.number == one.order.number)
        return [other for other in alike if other.number > one.number]

    def _goes_unheard(self, one: OpenCommand) -> bool:
        """Whether it is a stop that was not answered: whoever is heard, for the first time or anew, has not stopped."""
        return isinstance(one.order, Stop) and one.answered is None and not one.over

    def _send_cancel(self, one: OpenCommand, *, again: bool = False) -> None:
        one.cancelling += 1
        one.due = self._now + ACK_TIMEOUT_S
        if again and self._later(one):
            return
        self._send(cancel_message(one.order.number, one.who), one.who)

    def _give_up(self, one: OpenCommand, reason: str = "") -> None:
        if one.undone and one.answered is not None:
            self._end(one, NO_ANSWER, NO_RESULT)  # it has ended: what is heard from now on is about later ones
            return
        one.over, one.due = True, math.inf
        one.unheard = one.unheard or one.answered is None
        self._tell(one, NO_ANSWER, reason or (self._why_unanswered(one) if one.answered is None else NO_RESULT))

    def _why_unanswered(self, one: OpenCommand) -> str:
        doing = self._doing.get(one.number)
        return NOT_ANSWERED if doing is None else self._peer(one.who).why_unanswered(doing)

    # ------------------------------------------------------------------------------------------------ hearing

    def _answered(self, who: ComponentId, ack: Acknowledged) -> None:
        """Find out which order of its kind an acknowledgement is for."""
        alike = [one for one in self._of(who) if one.order.number == ack.number]
        if not alike:
            ended = self._peer(who).ended
            if ack.number in ended and ack.result is not Result.IN_PROGRESS:
                ended[ack.number] = self._now, ENDS[ack.result][0]  # more may come
            return
        *older, newest = alike
        going_on = [one for one in older if one.answered is not None]
        heard = newest.sure if newest.order.task else newest.answered is not None
        rivals = older if newest.order.task and not newest.cancelling else going_on  # it may be to one of these
        if ack.result is Result.IN_PROGRESS:
            if going_on and newest.over and not heard:
                newest = going_on.pop()  # the latest that the payload is known to have heard
                rivals = going_on
            self._goes_on(newest, ack.progress, rivals)
        elif newest.repeated and newest.cancelling and newest.answered is None and ack.result is Result.ACCEPTED:
            self._end(newest, NO_ANSWER, NO_RESULT)  # a cancel of what was never heard is answered with its like before
        elif ENDS[ack.result][0] == REFUSED or heard or not rivals:
            self._is_over(newest, older, ack.result)
        elif not going_on:
            newest.doubted = newest.doubted or newest.sent  # asked once more: the answer may be to one before
        else:
            *others, latest = going_on
            if latest.unheard:  # it was taken for begun without asking, and is not known to be
                self._end(latest, NO_ANSWER, NO_RESULT)
            else:
                self._is_over(latest, others, ack.result)
            newest.trusted, newest.after_done = self._peer(who).trusted(newest.order)  # the end may come doubled
            self._doubt(newest)

    def _goes_on(self, one: OpenCommand, progress: float | None, older: list[OpenCommand]) -> None:
        """Take an order for begun; beside an older one of its kind it is asked once more: the answer may be to that.

        When it goes on then, it has taken the place of the older ones.
        """
        first, given_up, one.over = one.answered is None, one.over, False
        one.answered = self._now
        sure = not older or one.sure
        certain = self._now >= one.trusted + LATE_ACK_S  # what the payload is told that it has it does not begin
        one.heard = one.heard or (not older and certain)
        one.doubted = one.doubted or one.sent
        if given_up or (sure and not one.cancelling):
            one.due = self._now + PROGRESS_TIMEOUT_S
        for other in older:
            if other.answered is not None:
                other.answered = self._now  # it may be to that
            if sure and one.order.task:
                self._end(other, CANCELLED, REPLACED)
        state = ACKNOWLEDGED if first and progress is None else IN_PROGRESS
        self._change(one, state, "", progress=progress)

    def _is_over(self, one: OpenCommand, older: list[OpenCommand], result: Result) -> None:
        state, reason = ENDS[result]
        one.trusted = self._now + LATE_ACK_S if one.trusted == math.inf else one.trusted  # this may be to one before
        refused = state == REFUSED
        doubtful = max(
            -math.inf if refused and one.after_done else one.trusted, one.refusable if refused else -math.inf
        )
        if self._now < doubtful and not (one.undone and state == CANCELLED):
            one.due = min(one.due, doubtful) if not one.over else math.inf  # what was given up is not sent again
            self._doubt(one)
            return
        for other in older if state != REFUSED else []:
            self._end(other, *((state, reason) if other.order == one.order else (CANCELLED, REPLACED)))
        self._end(one, state, reason)
        for other in self._of(one.who) if refused else []:  # they go on
            other.undone.discard(one.number)
            other.refusable = self._now + LATE_ACK_S if other in older else other.refusable

    def _doubt(self, one: OpenCommand) -> None:
        """Note that an answer may be to this one of what is done at once; it is not said as a new one again then."""
        if not one.order.task:
            one.doubted = one.doubted or one.sent

    def _end(self, one: OpenCommand, state: str, reason: str) -> None:
        self._open.pop(one.number, None)
        peer = self._peer(one.who)
        if state != NO_ANSWER:
            peer.ended[one.order.number] = self._now, state
        self._change(one, state, reason, progress=1.0 if state == DONE else None)
        for text in peer.texts.latest(self._now):
            self._explain(one.who, text)

    def _explain(self, who: ComponentId, text: StatusText) -> None:
        """Let a text say why something was refused, or failed, around the time it came.

        What came before an order is about an earlier one: the payload does not send a text for every refusal.
        """
        for doing in reversed(self.doing):
            near = doing.who == who and doing.since <= text.at and abs(doing.at - text.at) < EXPLANATION_S
            if near and (reason := reason_in(text, doing)):
                self._doing[doing.number] = replace(doing, reason=reason)
                return

    def _tell(self, one: OpenCommand, state: str, reason: str) -> None:
        """Tell what has become of an order, unless that was told."""
        doing = self._doing.get(one.number)
        if doing is not None and (doing.state, doing.reason) != (state, reason):
            self._change(one, state, reason)

    def _change(self, one: OpenCommand, state: str, reason: str, progress: float | None = None) -> None:
        doing = self._doing.get(one.number)
        if doing is not None:
            self._doing[one.number] = replace(doing, state=state, reason=reason, progress=progress, at=self._now)

    def _of(self, who: ComponentId) -> list[OpenCommand]:
        return [one for one in self._open.values() if one.who == who]

    def _peer(self, who: ComponentId) -> Peer:
        return self._peers.setdefault(who, Peer())
