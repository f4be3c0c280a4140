"""Point by hand: what a ground station or an autopilot asks for, until it is reached or another task is ordered.

A set-point takes the place of the one before without a halt. A heading is held while the base turns; a rate is asked
of the motor a few seconds ahead, so that what nobody renews comes to rest by itself.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from ross_payload.events import Outcome, State
from ross_payload.interfaces import Input, Output, Result
from ross_payload.mission.context import LOST, Context, Ended, FrameChanged, Step, exchange, obey
from ross_payload.mission.heading_control import LEAD, STILL
from ross_payload.orders import Order, Point
from ross_payload.pointing import nearest_joint, nearest_limit

LINGER = 1.0  # [s] at rest behind the last set-point: then others may begin without ending anything
AHEAD = 3.0  # [s] of a turn at a rate that are asked for at once
LATE, SLACK = 3.0, math.radians(5)  # [s] and [rad] that the motor may be behind: then it is waited for
RENEW = 1.0  # [s] after which they are asked for again
SLOWEST = math.radians(0.01)  # rate below which nothing turns [rad/s]
FOLLOW = math.radians(0.25)  # a heading that is off by more is corrected [rad]


def by_hand(context: Context, first: Point) -> Step[Result]:
    """Follow set-points, this one first, until the array rests where the last one wants it.

    Raises
    ------
    Ended
        When another order or a fault ends it.
    FrameChanged
        When a heading is to be held and the attitude of the base is lost.
    """
    context.enter(State.TURN, "by hand")
    context.yields = True
    controller = _SetPointController(context, first)
    while not controller.over():
        heard = yield from exchange(context, controller.wish())
        point = _latest(context, heard.orders)
        if heard.fault:
            raise Ended(Outcome.FAULT, heard.fault)
        if point is not None:
            controller.follow(point)
        if controller.point.heading is not None and not heard.pointing.earth:
            raise FrameChanged(Outcome.FAULT, LOST)
    return Result(Outcome.COMPLETED, "at rest")


def unreachable(point: Point, here: Input) -> str:
    """Return why a set-point cannot be followed; empty when it can."""
    unknown = point.heading is not None and not here.pointing.earth
    return "the attitude of the vehicle is not known" if unknown else ""


def _sensible(point: Point) -> float | None:
    """Return the rate of a set-point, none that is too slow to be one."""
    if not point.rate or abs(point.rate) >= SLOWEST:
        return point.rate
    return 0.0 if point.joint is None and point.heading is None else SLOWEST


def _latest(context: Context, orders: Sequence[Order]) -> Point | None:
    """Return the last set-point among some orders, and obey the others."""
    latest = None
    for place, order in enumerate(orders, start=1):
        if isinstance(order, Point):
            latest = order
            continue
        try:
            obey(context, (order,))
        except Ended:
            context.later.extend(orders[place:])
            raise
    return latest


class _SetPointController:
    """The set-point in force, and what has been asked of the motor for it."""

    def __init__(self, context: Context, point: Point) -> None:
        self._context = context
        self.point = Point()
        self._goal = context.pointing.joint  # that is wanted at last [rad]; set-points are on the turn nearest to it
        self.follow(point)

    def follow(self, point: Point) -> None:
        """Follow this set-point from here."""
        if self.point.joint is None and self.point.heading is None:
            self._goal = self._context.pointing.joint
        self.point = replace(point, rate=0.0 if self._leads_out(point) else _sensible(point))
        self._start, self._since = self._context.pointing.joint, self._context.time
        self._asked = math.nan  # joint angle that the motor was asked for [rad]
        self._left, self._asked_at = 0.0, -math.inf  # of the way there then [rad], and when that was [s]

    def _leads_out(self, point: Point) -> bool:
        """Whether a rate alone leads further beyond a limit: to turn back to it would be the opposite."""
        if point.joint is not None or point.heading is not None or not point.rate:
            return False
        settings, joint = self._context.settings, self._context.pointing.joint
        return joint > settings.upper if point.rate > 0 else joint < settings.lower

    def wish(self) -> Output:
        """Return what to ask of the motor now, if anything."""
        if self.point.joint is None and self.point.heading is None and not self.point.rate:
            halted, self._goal = self._asked == self._start, self._start
            self._asked = self._start
            return Output(halt=not halted)
        self._goal = self._meant()
        asked = self._within_reach()
        known = asked == self._asked or abs(asked - self._asked) <= self._tolerance(asked)
        if known and not self._goes_on():
            return Output()
        self._asked, self._asked_at = asked, self._context.time
        self._left = abs(asked - self._context.pointing.joint)
        return Output(goal=asked, rate=abs(self.point.rate) if self.point.rate else None)

    def _goes_on(self) -> bool:
        """Whether it is still on its way at its rate, back from beyond a limit or from where it has braked.

        It may take as long again then; a motor that cannot turn may not.
        """
        rate = abs(self.point.rate or 0.0)
        if not rate or self._left <= rate * (AHEAD + RENEW) or self._context.time - self._asked_at < RENEW:
            return False
        return abs(self._asked - self._context.pointing.joint) <= self._left - 1.5 * RENEW * rate

    def over(self) -> bool:
        """Tell whether nothing is left to do."""
        if self.point.heading is not None or self._context.time - self._since < LINGER:
            return False
        return abs(self._asked - self._goal) <= STILL and self._context.here.settled

    def _meant(self) -> float:
        """Return the joint angle that the set-point means [rad]; beyond a limit it is the limit."""
        settings, here = self._context.settings, self._context.pointing
        if self.point.park and self.point.joint is not None:
            return min(max(self.point.joint, settings.lower), settings.upper)  # a cable is wound by no turn more
        if self.point.heading is not None:
            angle = self.point.heading - here.zero - LEAD * here.base_rate
        elif self.point.joint is not None:
            angle = self.point.joint
        else:
            return settings.upper if (self.point.rate or 0.0) > 0 else settings.lower
        joint = nearest_joint(angle, self._goal, settings.lower, settings.upper)
        return nearest_limit(angle, settings.lower, settings.upper) if joint is None else joint

    def _within_reach(self) -> float:
        """Return the goal, or as much of the way as its rate covers in the time to come."""
        if not self.point.rate:
            return self._goal
        way, seconds = self._goal - self._start, self._context.time - self._since
        turned = max(math.copysign(1.0, way) * (self._context.pointing.joint - self._start), 0.0)
        rate = abs(self.point.rate)
        reach = min(rate * (seconds + AHEAD), turned + rate * (LATE + AHEAD) + SLACK)
        settings, there = self._context.settings, self._start + math.copysign(reach, way)
        return self._goal if abs(way) <= reach else min(max(there, settings.lower), settings.upper)

    def _tolerance(self, asked: float) -> float:
        """Return how far the motor's goal may be from the one that is wanted [rad]."""
        if self.point.rate and asked != self._goal:
            return abs(self.point.rate) * RENEW
        return STILL if self.point.heading is None else FOLLOW
