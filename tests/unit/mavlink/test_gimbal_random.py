"""Anybody asks anything at any time: limits hold, a stop holds, nothing fails, and afterwards it obeys and rests."""

import math
import random
from contextlib import ExitStack

import pytest

from examples import in_soak
from gimbal_bench import CONFIGURE, FOLLOW, GIVE, LOCK, NAN, POINT, TAKE, GimbalBench, deg, pitchyaw, set_attitude
from hand_bench import Base
from ross_payload.events import Answer, Answered, State, StateChanged
from ross_payload.orders import Cancel, Explore, Rearm, Stop, TurnTo

pytestmark = pytest.mark.lockstep

LOWER, UPPER = -70.0, 110.0  # [deg]
BUSY, LENGTH, QUIET = 2.0, 20.0, 11.0  # [s] before, during and after the noise
SLACK = 0.01  # [deg]


def script(bench, dice):
    """Random steps of three stations and an operator."""
    stations = (bench.ground, bench.other, bench.autopilot)
    for _ in range(40):
        time, station = dice.uniform(BUSY, BUSY + LENGTH), dice.choice(stations)
        yaw = dice.choice([NAN, math.inf, dice.uniform(-200, 200)])
        rate = dice.choice([NAN, NAN, 0.0, dice.uniform(-400, 400)])
        flags = dice.choice([0, 1, 2, 12, 28, FOLLOW, LOCK, 48, 64])
        kind = dice.randrange(6)
        if kind == 0:
            yield station.command(time, CONFIGURE, *dice.choice([TAKE, GIVE, (0, 0, 0, 0), (-1, -1, -2, -2)]), 0, 0, 1)
        elif kind == 1:
            yield station.command(time, POINT, 0, yaw, NAN, rate, flags, 0, 1)
        elif kind == 2:
            yield from station.stream(time, time + dice.uniform(0, 3), pitchyaw(deg(yaw), deg(rate), flags), 0.1)
        elif kind == 3:
            yield from station.stream(
                time, time + dice.uniform(0, 3), set_attitude(deg(yaw), deg(rate), flags & 0xFFFF)
            )
        else:
            order = dice.choice([Explore(), TurnTo(deg(dice.uniform(-60, 100))), Cancel(), Stop(), *[Rearm()] * 4])
            yield bench.order(time, order)


def peace(bench, mode):
    """Steps behind them: the operator puts things in order, and somebody points to 40 deg clockwise."""
    end = BUSY + LENGTH
    yield bench.order(end + 4.0, Cancel())
    yield bench.order(end + 5.0, Rearm())
    if mode == "standalone":
        yield bench.ground.command(end + 6.0, CONFIGURE, *TAKE, 0, 0, 1)
        yield bench.ground.command(end + 6.5, POINT, 0, 40, NAN, NAN, FOLLOW, 0, 1)
    else:
        yield from bench.autopilot.stream(end + 4.0, end + 6.0, set_attitude(deg(-30)))
        yield from bench.autopilot.stream(end + 6.0, end + 8.0, set_attitude(deg(40)))


def stops(bench):
    """The times [s] at which it was stopped, and re-armed or the end."""
    states = [(event.time, event.state) for event in bench.events if isinstance(event, StateChanged)]
    begin = None
    for time, state in states:
        if state is State.STOPPED and begin is None:
            begin = time
        elif state is not State.STOPPED and begin is not None:
            yield begin, time
            begin = None


@pytest.mark.parametrize("mode", ["standalone", *in_soak("device")])
@pytest.mark.parametrize("seed", [0, *[pytest.param(seed, marks=pytest.mark.soak) for seed in range(1, 50)]])
def test_whatever_is_asked(mode, seed):
    dice = random.Random(seed)  # noqa: S311
    with ExitStack() as stack:
        base = Base(dice.choice([None, 0.5]), deg(3))
        one = GimbalBench(stack, mode, base, guard={"lower_deg": LOWER, "upper_deg": UPPER})
        one.live(BUSY + LENGTH + QUIET, *script(one, dice), *peace(one, mode))
    angles = [math.degrees(angle) for _, angle, _ in one.trace]
    assert min(angles) >= LOWER - SLACK
    assert max(angles) <= UPPER + SLACK
    assert State.FAULT not in [state for state, _ in one.states()]
    assert not [event for event in one.events if isinstance(event, Answered) and event.answer is Answer.FAILED]
    assert angles[-1] == angles[-100] == pytest.approx(-40, abs=0.1)
    start = one.trace[0][0] - 0.01
    for begin, end in stops(one):
        if end - begin > 3.0:
            assert one.angle(start + begin + 3.0) == one.angle(start + end)
    assert one.far_end.complaints() == []
