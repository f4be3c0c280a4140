"""Five degrees and back: what an actuator reports on the way, and what that says about it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from ross_payload.actuators.guard import Guard
from ross_payload.actuators.motion import Trapezoid
from ross_payload.doctor.findings import Finding, fail, ok, warn
from ross_payload.errors import ActuatorError
from ross_payload.interfaces import ActuatorState, Capabilities, Clock, Feedback

REACH_RAD = math.radians(5)  # how far it goes [rad]
MAX_SPEED_RAD_S = math.radians(5)  # at most how fast [rad/s]
LOOK_PERIOD_S = 0.01  # between two looks [s]
IMPOSSIBLE_RAD = 3 * REACH_RAD  # beyond that no move has gone: somebody else reports, or the place was lost [rad]
SETTLING_TIMEOUT_S = 5.0  # with settling, after a move should be over [s]
MAX_PLAY_RAD = math.radians(0.3)  # of overshoot or play: more is worth a word [rad]
MAX_SETTLE_S = 1.0  # of settling: more is worth a word [s]
MIDDLE = (0.3, 0.7)  # of the way, where the speed is taken


@dataclass(frozen=True, slots=True)
class Leg:
    """One move and its reports."""

    plan: Trapezoid
    begin: float  # [s]
    reports: tuple[ActuatorState, ...]  # the last one is the one that ended it
    arrived: bool

    @property
    def sign(self) -> float:
        """Which way it should go."""
        return math.copysign(1.0, self.plan.goal - self.plan.start)

    @property
    def end(self) -> ActuatorState:
        """The report that ended it."""
        return self.reports[-1]

    @property
    def progress(self) -> tuple[float, ...]:
        """How far it has come at each report [rad]; negative: the wrong way."""
        return tuple(self.sign * (report.angle - self.plan.start) for report in self.reports)

    @property
    def overshoot(self) -> float:
        """How far it was ever beyond its goal [rad]."""
        return max(0.0, max(self.progress) - abs(self.plan.goal - self.plan.start))

    @property
    def speed(self) -> float:
        """Mean reported speed in the middle of the way, as a share of the one asked for; NaN without two reports."""
        way = abs(self.plan.goal - self.plan.start)
        middle = [
            (report.time, gone)
            for report, gone in zip(self.reports, self.progress, strict=True)
            if MIDDLE[0] * way <= gone <= MIDDLE[1] * way
        ]
        if len(middle) < 2 or middle[-1][0] <= middle[0][0]:
            return math.nan
        return (middle[-1][1] - middle[0][1]) / (middle[-1][0] - middle[0][0]) / self.plan.speed


@dataclass(frozen=True, slots=True)
class Figures:
    """What the moves have shown."""

    error_deg: float  # the largest at the end of a move
    overshoot_deg: float
    settle_s: float  # the longest, after the move should have been over
    speed: float  # reported, as a share of the one asked for
    play_deg: float  # between both ways of reaching one goal


def goals(here: float, able: Capabilities) -> tuple[float, ...]:
    """Where to go [rad]: out and back, through the middle from both sides, towards the farther limit.

    >>> able = Capabilities(-1.0, 1.0, 1.0, 1.0, 0.01, False, Feedback.MEASURED)
    >>> [round(math.degrees(goal), 3) for goal in goals(math.radians(50), able)]
    [45.0, 47.5, 50.0, 47.5, 50.0]
    """
    way = REACH_RAD if able.upper - here >= here - able.lower else -REACH_RAD
    return here + way, here + way / 2, here, here + way / 2, here


def go(guard: Guard, clock: Clock, goal: float) -> Leg:
    """Make one move and collect its reports.

    Raises
    ------
    ActuatorError
        When the move is refused.
    """
    able, start = guard.capabilities, guard.state().angle
    speed = min(MAX_SPEED_RAD_S, able.max_speed)
    plan = Trapezoid(start, goal, speed, able.max_acceleration)
    begin = clock.now()
    guard.command(goal, speed)
    reports = [guard.state()]
    while clock.now() < begin + plan.duration + SETTLING_TIMEOUT_S:
        clock.sleep(LOOK_PERIOD_S)
        state = guard.state()
        if state.time > reports[-1].time or not state.healthy or state.settled:
            reports.append(state)
        if not state.healthy or state.settled:
            break
    return Leg(plan, begin, tuple(reports), reports[-1].settled)


def make(guard: Guard, clock: Clock, legs: list[Leg]) -> Finding | None:
    """Go out and back, adding to ``legs``; return what ended it early."""
    for goal in goals(guard.state().angle, guard.capabilities):
        try:
            leg = go(guard, clock, goal)
        except ActuatorError as error:
            return fail("move", str(error), "see 'what happens when' on the page of this actuator")
        legs.append(leg)
        if not leg.arrived:
            guard.stop()
            return _why(leg, guard.capabilities)
    return None


def _why(leg: Leg, able: Capabilities) -> Finding:
    """Say why a move did not arrive."""
    state, gone = leg.end, leg.progress
    if -IMPOSSIBLE_RAD < min(gone) < -max(MAX_PLAY_RAD, 3 * able.resolution):
        found = f"it went {math.degrees(-min(gone)):.1f} deg the wrong way; {state.fault}".rstrip("; ")
        return fail("direction", found, "swap the ends of its travel, or invert its direction, in actuator.options")
    if state.fault:
        return fail("move", state.fault, "see 'what happens when' on the page of this actuator")
    if max(gone) <= max(2 * able.resolution, MAX_PLAY_RAD):
        return fail("move", "it did not move", "is it powered, free to turn, and is this its wire?")
    missing = math.degrees(abs(leg.plan.goal - state.angle))
    late = f"{missing:.2f} deg from its goal {SETTLING_TIMEOUT_S:g} s after it should have been there"
    return fail("move", late, "too heavy, too fast, or the numbers of its gear and travel are wrong")


def figures(legs: list[Leg]) -> Figures:
    """Condense the legs of a whole probe."""
    speeds = [leg.speed for leg in legs if not math.isnan(leg.speed)]
    return Figures(
        error_deg=math.degrees(max(abs(leg.end.angle - leg.plan.goal) for leg in legs)),
        overshoot_deg=math.degrees(max(leg.overshoot for leg in legs)),
        settle_s=max(leg.end.time - leg.begin - leg.plan.duration for leg in legs),
        speed=sum(speeds) / len(speeds) if speeds else math.nan,
        play_deg=math.degrees(abs(legs[1].end.angle - legs[3].end.angle)),
    )


def judge(seen: Figures, able: Capabilities) -> Iterator[Finding]:
    """Say what the figures mean."""
    step = math.degrees(able.resolution)
    play = max(math.degrees(MAX_PLAY_RAD), 2 * step)
    if able.feedback is Feedback.MODEL:
        found = f"commanded {math.degrees(REACH_RAD):g} deg and back; not measured"
        yield warn(
            "direction", found, "check by eye, from above: first counter-clockwise (near the upper limit clockwise)?"
        )
    else:
        yield ok("direction", "it turns the way it is commanded")
    yield _at_most("error", seen.error_deg, step * 1.5, "deg", "coarser than its resolution says")
    yield _at_most("overshoot", seen.overshoot_deg, play, "deg", "tune its control loop")
    yield _at_most("settling", seen.settle_s, MAX_SETTLE_S, "s", "it creeps: tune its control loop, or lower settle_ms")
    yield _at_most("play", seen.play_deg, play, "deg", "reduce the backlash")
    if not 0.8 <= seen.speed <= 1.2:  # NaN is not either
        found = f"{seen.speed:.2f} of the commanded speed"
        yield warn("speed", found, "the numbers of its gear and travel, or its own limits, may be wrong")
    else:
        yield ok("speed", f"{seen.speed:.2f} of the commanded speed")


def _at_most(check: str, value: float, most: float, unit: str, todo: str) -> Finding:
    found = f"{value:.3f} {unit}"
    return ok(check, found) if value <= most else warn(check, f"{found}, more than {most:.3f}", todo)
