"""Point by hand: what a ground station or an autopilot asks for, until it is reached or another task is ordered.

A set-point takes the place of the one before without a halt. A heading is held while the base turns; a rate is asked
of the motor a few seconds ahead, so that what nobody renews comes to rest by itself.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import replace

from ross_payload.angles import wrap
from ross_payload.events import Outcome, State
from ross_payload.interfaces import Input, Output, Result
from ross_payload.mission.context import LOST, Context, Ended, FrameChanged, Step, exchange, obey
from ross_payload.mission.follower import LEAD, STILL, TRAIL, base
from ross_payload.orders import Order, Point

LINGER = 1.0  # [s] at rest behind the last set-point: then others may begin without ending anything
AHEAD = 3.0  # [s] of a turn at a rate that are asked for at once
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
    hand = _Hand(context, first)
    while not hand.over():
        heard = yield from exchange(context, hand.wish())
        point = _latest(context, heard.orders)
        if heard.fault:
            raise Ended(Outcome.FAULT, heard.fault)
        if point is not None:
            hand.take(point)
        if hand.point.heading is not None and not heard.attitude.known:
            raise FrameChanged(Outcome.FAULT, LOST)
    return Result(Outcome.COMPLETED, "at rest")


def unreachable(point: Point, here: Input) -> str:
    """Return why a set-point cannot be followed; empty when it can."""
    unknown = point.heading is not None and not here.attitude.known
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


class _Hand:
    """The set-point in force, and what has been asked of the motor for it."""

    def __init__(self, context: Context, point: Point) -> None:
        self._context = context
        self.point = Point()
        self._goal = context.here.joint  # that is wanted at last [rad]; set-points are on the turn nearest to it
        self._trail: deque[tuple[float, float]] = deque()  # time [s], heading at joint angle 0 [rad]
        self.take(point)

    def take(self, point: Point) -> None:
        """Follow this set-point from here."""
        if self.point.joint is None and self.point.heading is None:
            self._goal = self._context.here.joint
        self.point = replace(point, rate=_sensible(point))
        self._start, self._since = self._context.here.joint, self._context.time
        self._asked = math.nan  # joint angle that the motor was asked for [rad]

    def wish(self) -> Output:
        """Return what to ask of the motor now, if anything."""
        if self.point.joint is None and self.point.heading is None and not self.point.rate:
            halted, self._goal = self._asked == self._start, self._start
            self._asked = self._start
            return Output(halt=not halted)
        self._goal = self._meant()
        asked = self._within_reach()
        if asked == self._asked or abs(asked - self._asked) <= self._tolerance(asked):
            return Output()
        self._asked = asked
        return Output(goal=asked, rate=abs(self.point.rate) if self.point.rate else None)

    def over(self) -> bool:
        """Tell whether nothing is left to do."""
        if self.point.heading is not None or self._context.time - self._since < LINGER:
            return False
        return self._asked == self._goal and self._context.here.settled

    def _meant(self) -> float:
        """Return the joint angle that the set-point means [rad]; beyond a limit it is the limit."""
        settings, here = self._context.settings, self._context.here
        if self.point.heading is not None:
            angle = self.point.heading - base(here) - LEAD * self._turning()
        elif self.point.joint is not None:
            angle = self.point.joint
        else:
            return settings.upper if (self.point.rate or 0.0) > 0 else settings.lower
        near = self._goal + wrap(angle - self._goal)
        turns = (near, near - 2 * math.pi, near + 2 * math.pi)
        inside = [turn for turn in turns if settings.lower <= turn <= settings.upper]
        if inside:
            return inside[0]
        return min((settings.lower, settings.upper), key=lambda limit: abs(wrap(near - limit)))

    def _turning(self) -> float:
        """Return how fast the base turns [rad/s]."""
        self._trail.append((self._context.time, base(self._context.here)))
        while self._context.time - self._trail[0][0] > TRAIL + STILL:
            self._trail.popleft()
        (begin, first), (end, last) = self._trail[0], self._trail[-1]
        return wrap(last - first) / (end - begin) if end > begin else 0.0

    def _within_reach(self) -> float:
        """Return the goal, or as much of the way as its rate covers in the time to come."""
        if not self.point.rate:
            return self._goal
        reach = abs(self.point.rate) * (self._context.time - self._since + AHEAD)
        return self._start + min(max(self._goal - self._start, -reach), reach)

    def _tolerance(self, asked: float) -> float:
        """Return how far the motor's goal may be from the one that is wanted [rad]."""
        if self.point.rate and asked != self._goal:
            return abs(self.point.rate) * RENEW
        return STILL if self.point.heading is None else FOLLOW
