"""The client of the command protocol: orders to payloads, and what becomes of them. No port, no clock.

``heard`` takes what arrives and ``tick`` the time; messages go to ``send``. Nothing waits behind anything else.

A link loses frames and doubles them, and an acknowledgement names its command but not which one of several alike. So a
frame is sent again until it is answered, and so is one whose answers ended too early; within `REMEMBERED` the payload
answers what is said again once more and does not do it again. A final answer so soon that it may be one to the order
before is asked for again. After that time nothing is sent again: the payload would take it for a new order.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

from ross_payload.ground.clients.asking import (
    Cancel,
    Explore,
    Home,
    Listen,
    Noise,
    Order,
    Park,
    Rearm,
    Record,
    Stop,
    Turn,
    order_of,
)
from ross_payload.ground.clients.doing import (
    ACKNOWLEDGED,
    AFTER_STOP,
    CANCELLED,
    DONE,
    ENDS,
    FAILED,
    IN_PROGRESS,
    NO_ANSWER,
    OVERTAKEN,
    REFUSED,
    REPLACED,
    SENT,
    SILENCE,
    STARTED_ANEW,
    UNHEARD,
    Doing,
    reason_in,
)
from ross_payload.ground.picture.known import Payload, Said, Who
from ross_payload.ground.picture.texts import Texts
from ross_protocols.codec import Packet
from ross_protocols.commands import Acknowledged, Result, acknowledged_of, cancel_message, long_message
from ross_protocols.values import Text

__all__ = [
    "Cancel", "Doing", "Explore", "Home", "Listen", "Noise", "Order", "Orders", "Park", "Rearm", "Record", "Stop",
    "Turn", "order_of",
]  # fmt: skip

AGAIN, TIMES = 1.0, 4  # [s] without an answer until a frame is sent again, and how often
STOP_AGAIN, STOP_TIMES = 0.2, 10
LOOKED_FOR = 30.0  # [s] that a stop is sent to a payload that was never heard; when it is, all tries are before it
SILENT, ASKING = 2.0, 0.5  # [s] without progress until it is asked for, and how often
REMEMBERED = 4.0  # [s] within which the payload knows what is said again: it remembers for 5, and a frame may be late
LIKE = 10.0  # [s] after an order, in which the payload may take its like that is said again for it
DOUBT = 1.0  # [s] after the end of an order, in which an answer to the next of its kind may be one to it
EXPLAINED = 1.5  # [s] around a refusal, in which the payload says why
KEPT = 50
EARLY = 1e-6  # [s], of rounding


@dataclass(slots=True)
class _Open:
    """An order that is not over."""

    number: int
    who: Who
    order: Order
    due: float  # when it is said again [s]
    repeated: bool  # its like ended a moment ago: what the payload remembers may be that
    trusted: float  # [s]: a final answer before may be a late one to its like
    sent: int = 0  # frames
    heard: float | None = None  # the latest answer [s]
    cancelling: int = 0  # COMMAND_CANCEL, so often
    over: bool = False  # given up, until something is heard after all


@dataclass(slots=True)
class _Peer:
    """What is remembered of a payload."""

    boots: int | None = None
    texts: Texts = field(default_factory=Texts)
    lately: list[Said] = field(default_factory=list)
    ended: dict[int, float] = field(default_factory=dict)  # when [s], by MAV_CMD
    sent: dict[int, float] = field(default_factory=dict)  # when [s], by MAV_CMD


class Orders:
    """Orders of one ground station, ``system_id`` and ``component_id``, to any number of payloads.

    >>> sent = []
    >>> orders = Orders(lambda message, who: sent.append(message.get_type()), 255, 190)
    >>> number = orders.order(Who(1, 191), Turn(40.0))
    >>> sent, orders.doing[-1].words, orders.doing[-1].state
    (['COMMAND_LONG'], 'turn to 40 deg', 'sent')
    """

    def __init__(self, send: Callable[[Any, Who], None], system_id: int, component_id: int) -> None:
        self._send = send
        self._us = system_id, component_id
        self._doing: dict[int, Doing] = {}
        self._open: dict[int, _Open] = {}
        self._peers: dict[Who, _Peer] = {}
        self._count = 0
        self._now = 0.0

    @property
    def doing(self) -> tuple[Doing, ...]:
        """The latest orders, newest last."""
        return tuple(self._doing.values())

    def order(self, who: Who, order: Order) -> int:
        """Order something at once; return the number of what becomes of it."""
        self._give_way(who, order)
        self._count += 1
        peer, number = self._peer(who), order.number
        self._doing[self._count] = Doing(self._count, who, order, SENT, self._now, self._now)
        self._open[self._count] = _Open(
            self._count, who, order, self._now,
            repeated=self._now - peer.sent.get(number, -math.inf) < LIKE,
            trusted=self._trusted(peer, order),
        )  # fmt: skip
        while len(self._doing) > KEPT:
            oldest = next(iter(self._doing))
            del self._doing[oldest]
            self._open.pop(oldest, None)
        peer.sent[number] = self._now
        self._say(self._open[self._count])
        return self._count

    def cancel(self, number: int) -> None:
        """Ask to end an order; one that is over stays as it is."""
        wanted = self._open.get(number)
        if wanted is not None and not wanted.over:
            wanted.cancelling = 0
            self._say_cancel(wanted)

    def met(self, payload: Payload) -> None:
        """Learn of a payload, whenever it is heard: one that started anew does not do what it was told before."""
        peer = self._peer(payload.who)
        if peer.boots is not None and payload.boots > peer.boots:
            for one in [one for one in self._of(payload.who) if not one.over]:
                self._end(one, FAILED, STARTED_ANEW)
            self._peers[payload.who] = peer = _Peer()
        elif peer.boots is None:
            for one in [one for one in self._of(payload.who) if isinstance(one.order, Stop) and one.heard is None]:
                one.sent, one.due = min(one.sent, 1), self._now
        peer.boots = payload.boots

    def heard(self, packet: Packet, now: float) -> None:
        """Take a packet; what is no answer passes by."""
        self._now = now
        who = Who(packet.system_id, packet.component_id)
        peer = self._peers.get(who)
        if peer is None:
            return
        acknowledged = acknowledged_of(packet.message)
        if acknowledged is not None and acknowledged.is_for(*self._us):
            self._answered(who, acknowledged)
        elif packet.name == "STATUSTEXT" and isinstance(packet.value, Text):
            fresh = peer.texts.heard(packet.value, now)
            peer.lately = [said for said in (*peer.lately, *fresh) if now - said.at < EXPLAINED]
            for said in fresh:
                self._explain(who, said)

    def tick(self, now: float) -> None:
        """Send again what was not answered; give up what never is."""
        self._now = now
        for one in [one for one in self._open.values() if now >= one.due - EARLY]:
            self._remind(one)

    # ------------------------------------------------------------------------------------------------ sending

    def _say(self, one: _Open) -> None:
        """Send an order, first or again.

        What is done at once is harmless when done twice, and must not be taken for its like of a moment ago: arm,
        stop, arm. A task must not be done twice.
        """
        anew = one.repeated and not one.order.task
        one.due = self._now + (STOP_AGAIN if isinstance(one.order, Stop) else AGAIN)
        confirmation = 0 if anew else min(one.sent, 255)
        one.sent += 1
        who = one.who
        self._send(long_message(one.order.number, one.order.numbers, who.system, who.component, confirmation), who)

    def _give_way(self, who: Who, order: Order) -> None:
        """What was never answered is not said again after a stop; nor is a cancel after any order: it would end it."""
        for one in self._of(who):
            unheard = one.heard is None and not one.over
            if unheard and isinstance(order, Stop) and not isinstance(one.order, Stop):
                self._end(one, CANCELLED, AFTER_STOP)
            elif unheard and isinstance(one.order, Cancel):
                self._end(one, NO_ANSWER, OVERTAKEN)
            elif one.over and one.order.number == order.number:
                del self._open[one.number]

    def _remind(self, one: _Open) -> None:
        """Say it again where that can help; a cancel stands for its order."""
        times = STOP_TIMES if isinstance(one.order, Stop) else TIMES
        if one.cancelling:
            self._say_cancel(one) if one.cancelling <= TIMES else self._give_up(one)
        elif one.heard is None:
            self._say(one) if one.sent <= times or self._looked_for(one) else self._give_up(one)
        elif self._now - one.heard > REMEMBERED:
            self._give_up(one)
        else:
            self._say(one)
            one.due = self._now + ASKING

    def _looked_for(self, one: _Open) -> bool:
        """Whether it is a stop for somebody who was never heard, but may be any moment: we may have just started."""
        unmet = isinstance(one.order, Stop) and self._peer(one.who).boots is None
        return unmet and self._now - self._doing[one.number].since < LOOKED_FOR

    def _say_cancel(self, one: _Open) -> None:
        one.cancelling += 1
        one.due = self._now + AGAIN
        self._send(cancel_message(one.order.number, one.who.system, one.who.component), one.who)

    def _give_up(self, one: _Open) -> None:
        one.over, one.due = True, math.inf
        self._change(one, NO_ANSWER, UNHEARD if one.heard is None else SILENCE)

    def _trusted(self, peer: _Peer, order: Order) -> float:
        """Return from when on a final answer is one to this order; a stop is only in doubt after it was re-armed."""
        ended = peer.ended.get(order.number, -math.inf)
        armed = peer.sent.get(Rearm.number, -math.inf) >= ended > -math.inf
        return ended + DOUBT if armed or not isinstance(order, Stop) else -math.inf

    # ------------------------------------------------------------------------------------------------ hearing

    def _answered(self, who: Who, told: Acknowledged) -> None:
        """Find out which order of its kind an acknowledgement is for."""
        alike = [one for one in self._of(who) if one.order.number == told.number]
        if not alike:
            return
        *older, newest = alike
        going_on = [one for one in older if one.heard is not None]
        if told.result is Result.IN_PROGRESS:
            self._goes_on(newest, told.progress, alone=not going_on)
        elif ENDS[told.result][0] == REFUSED or newest.heard is not None or not going_on:
            self._is_over(newest, older, told.result)
        else:
            self._is_over(going_on[-1], [], told.result)

    def _goes_on(self, one: _Open, progress: float | None, *, alone: bool) -> None:
        """Take an order for begun; beside an older one of its kind it is asked once more: the answer may be to that."""
        first, one.over = one.heard is None, False
        one.heard = self._now
        if not one.cancelling and (alone or not first):
            one.due = self._now + SILENT
        state = ACKNOWLEDGED if first and progress is None else IN_PROGRESS
        self._change(one, state, "", progress=progress)

    def _is_over(self, one: _Open, older: list[_Open], result: Result) -> None:
        if self._now < one.trusted:
            one.due = min(one.due, one.trusted)
            return
        state, reason = ENDS[result]
        for other in older if state != REFUSED else []:
            self._end(other, *((state, reason) if other.order == one.order else (CANCELLED, REPLACED)))
        self._end(one, state, reason)

    def _end(self, one: _Open, state: str, reason: str) -> None:
        self._open.pop(one.number, None)
        peer = self._peer(one.who)
        if state != NO_ANSWER:
            peer.ended[one.order.number] = self._now
        self._change(one, state, reason, progress=1.0 if state == DONE else None)
        for said in peer.lately:
            self._explain(one.who, said)

    def _explain(self, who: Who, said: Said) -> None:
        """Let a text say why something was refused, or failed, around the time it came."""
        for doing in reversed(self.doing):
            near = doing.who == who and abs(doing.at - said.at) < EXPLAINED
            if near and (reason := reason_in(said, doing)):
                self._doing[doing.number] = replace(doing, reason=reason)
                return

    def _change(self, one: _Open, state: str, reason: str, progress: float | None = None) -> None:
        doing = self._doing.get(one.number)
        if doing is not None:
            self._doing[one.number] = replace(doing, state=state, reason=reason, progress=progress, at=self._now)

    def _of(self, who: Who) -> list[_Open]:
        return [one for one in self._open.values() if one.who == who]

    def _peer(self, who: Who) -> _Peer:
        return self._peers.setdefault(who, _Peer())
