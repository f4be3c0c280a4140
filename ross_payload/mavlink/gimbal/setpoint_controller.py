"""Set-points of somebody to orders for the mission: given once, renewed as long as they are fresh."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import count

from ross_payload.angles import wrap
from ross_payload.events import Answer, Answered
from ross_payload.orders import Cancel, Order, Point
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.gimbal_device import Aim, Rest

SAME = math.radians(0.05)  # [rad]: what is asked for again is no other set-point
CHANGE = math.radians(1.0)  # [rad]: what somebody has said for long is an order when it changes by more
ENDED = (Answer.DONE, Answer.FAILED, Answer.CANCELLED)
SENDERS = 16  # whose set-points are remembered


def alike(one: Aim, other: Aim, within: float) -> bool:
    """Tell whether two aims ask for the same, their yaws ``within`` so much [rad]."""
    if (one.earth, one.rest, one.rate, one.yaw is None) != (other.earth, other.rest, other.rate, other.yaw is None):
        return False
    return one.yaw is None or other.yaw is None or abs(wrap(one.yaw - other.yaw)) <= within


class VainRequests:
    """What somebody said when it could not be obeyed: only a change of it is an order.

    >>> vain, who = VainRequests(), ComponentId(1, 1)
    >>> vain.note(who, Aim(1.0))
    >>> vain.is_news(who, Aim(1.0)), vain.is_news(who, Aim(1.1)), vain.is_news(who, Aim(1.0))
    (False, True, True)
    """

    def __init__(self) -> None:
        self._past: dict[ComponentId, Aim] = {}

    def note(self, who: ComponentId, aim: Aim) -> None:
        """Remember what somebody says in vain."""
        self.forget(who)
        self._past[who] = aim
        if len(self._past) > SENDERS:
            self.forget(next(iter(self._past)))

    def forget(self, who: ComponentId) -> None:
        """Take whatever somebody says next for an order."""
        self._past.pop(who, None)

    def is_news(self, who: ComponentId, aim: Aim) -> bool:
        """Tell whether somebody says something else than what could not be obeyed; then all that follows is news."""
        if who in self._past and alike(aim, self._past[who], CHANGE):
            return False
        self.forget(who)
        return True


class SetpointController:
    """Gives the mission what is asked for, the latest at every tick: a flood of set-points is one.

    Parameters
    ----------
    give
        Hands an order to the runner.
    park
        Joint angle of the retracted position [rad].
    """

    def __init__(self, give: Callable[[Order], None], park: float) -> None:
        self.aim: Aim | None = None  # in force
        self.latest = 0  # number of the last order
        self._give = give
        self._park = park
        self.followed = False  # the mission follows a set-point of ours
        self._numbers = count(-1, -1)
        self._cancel = 0  # number of the order that ends the task, until it is answered
        self._waiting: Point | None = None  # for the next tick
        self._fresh = math.inf  # until then a rate counts [s]

    def point(self, aim: Aim, offset: float, until: float) -> None:
        """Ask for an aim; ``offset`` is the yaw at joint angle 0 [rad], a rate alone counts ``until`` then [s]."""
        self._fresh = until if aim.yaw is None and aim.rate else math.inf
        if self.aim is None or not alike(aim, self.aim, SAME):
            self.aim, self._waiting = aim, self._order(aim, offset)

    def still(self) -> None:
        """Ask for rest."""
        self.forget()
        self._fresh = math.inf
        self._ask(Point(rate=0.0))

    def cancel(self) -> None:
        """End the task that runs."""
        self.forget()
        self._ask(Cancel())
        self._cancel = self.latest

    @property
    def cancelling(self) -> bool:
        """Whether the task that runs is being ended: what is ordered behind that finds the mission at rest."""
        return self._cancel != 0

    def on_answer(self, event: Answered) -> None:
        """Note what the mission answers to our orders; these have numbers below 0."""
        if event.order >= 0:
            return
        if event.order == self._cancel:
            self._cancel = 0
        elif event.answer is Answer.ACCEPTED:
            self.followed = True
        elif event.answer in ENDED:
            self.followed = False

    def forget(self) -> None:
        """Nothing is in force any more; a rate that is on its way to the mission ends in time all the same."""
        self.aim = self._waiting = None

    def tick(self, now: float) -> None:
        """Order what was asked for last, and the end of a rate that nobody has renewed."""
        if now > self._fresh:
            self.still()
        elif self._waiting is not None:
            order, self._waiting = self._waiting, None
            self._ask(order)

    def _ask(self, order: Order) -> None:
        self.latest = next(self._numbers)
        self._give(replace(order, number=self.latest))

    def _order(self, aim: Aim, offset: float) -> Point:
        if aim.rest is not None:
            retracted = aim.rest is Rest.RETRACTED
            return Point(joint=self._park, park=True) if retracted else Point(joint=-offset)
        if aim.yaw is None:
            return Point(rate=aim.rate)
        if aim.earth:
            return Point(heading=aim.yaw, rate=aim.rate)
        return Point(joint=wrap(aim.yaw - offset), rate=aim.rate)
