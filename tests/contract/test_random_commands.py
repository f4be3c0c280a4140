"""No sequence of commands exceeds a limit, a speed or an acceleration, nor confuses a driver; 10,000 in `make soak`."""

from __future__ import annotations

import math
from contextlib import suppress
from typing import Any

import pytest
from hypothesis import HealthCheck, Phase, example, given, settings
from hypothesis import strategies as st

from detections import DETECTIONS
from examples import examples, in_soak
from monitor import Monitor, tolerated
from rigs import KINDS, Rig, kinds, rig_of
from ross_payload.errors import ActuatorError
from ross_sim.clock import QUANTUM
from ross_sim.devices.far_end import Fault

pytestmark = pytest.mark.lockstep

MANY = math.ceil(10_000 / len(KINDS))
BRAKING = 300  # quanta in which everything comes to rest
FEW = settings(max_examples=examples(20), suppress_health_check=list(HealthCheck))
SOAK = settings(FEW, max_examples=MANY, phases=[Phase.explicit, Phase.generate])

goals = st.one_of(st.floats(-250, 250), st.sampled_from([-200.0, 0.0, 200.0, math.nan, math.inf]))
rates = st.one_of(st.none(), st.floats(1, 400), st.sampled_from([0.0, -1.0, math.nan]))
whats = st.sampled_from(["go", "go", "go", "go", "halt", "stop", "rearm", "rearm", "home", "release"])
steps_of_any = st.lists(st.tuples(whats, goals, rates, st.integers(0, 90)), min_size=1, max_size=8)

# A gimbal's loop that catches up with a plan: its rate changes by more than the plan's within 10 ms.
SPEEDING_UP = [("go", -1.0, 1.0, 57), ("go", 40.0, None, 62), ("go", 0.0, None, 44), ("go", 42.0, None, 10)]
# A stop between two set-points of a gimbal that follows their rhythm.
OUT_OF_STEP = [("go", -187.0, None, 87), ("stop", 0.0, None, 60)]
# The highest set-point of a move that turns back: twice the same.
TURNING_BACK = [("go", 0.0, 96.5, 76), ("go", -178.4, None, 117), ("go", 200.0, None, 93), ("go", 0.0, None, 59)]
# A stop while it homes, in the middle of a move.
HOMING = [("go", 117.0, 184.0, 50), ("home", 0.0, None, 16), ("stop", 0.0, None, 20)]

Step = tuple[str, float, float | None, int]


def ask(rig: Rig, step: Step) -> bool:
    """Ask for one thing; whether it was taken."""
    what, goal, rate, _ = step
    with suppress(ActuatorError):
        if what == "go":
            rig.actuator.command(math.radians(goal), None if rate is None else math.radians(rate))
        else:
            getattr(rig.actuator, what)()
        return True
    return False


def obeys(kind: str, steps: list[Step]) -> None:
    rig = rig_of(kind).open()
    monitor = Monitor(rig)
    monitor.run(20)
    for step in steps:
        ask(rig, step)
        if step[0] == "release":
            monitor.let_go()
        if step[0] in {"release", "home"}:
            monitor.lost()
        monitor.run(step[3])
        assert monitor.worst.within(tolerated(kind)), monitor.worst
    rig.actuator.stop()
    monitor.run(BRAKING)
    assert monitor.worst.within(tolerated(kind)), monitor.worst
    assert rig.state.rate == 0.0
    assert rig.far_end.complaints() == []
    rig.actuator.__exit__(None, None, None)


@pytest.mark.parametrize("kind", kinds())
def test_no_sequence_of_commands_breaks_a_limit_or_a_cap(kind: str) -> None:
    @FEW
    @given(steps=steps_of_any)
    @example(steps=HOMING)
    @example(steps=[("home", 0.0, None, 0)])  # a stop in the same moment
    def holds(steps: list[Any]) -> None:
        obeys(kind, steps)

    holds()


@pytest.mark.parametrize(
    "steps", [SPEEDING_UP, OUT_OF_STEP, TURNING_BACK], ids=["speeding up", "out of step", "turning back"]
)
@pytest.mark.parametrize("kind", ["mavlink_gimbal", "dronecan_servo:gimbal", *in_soak("mavlink_gimbal:manager")])
def test_what_a_gimbal_once_did_wrong_breaks_no_limit_or_cap(kind: str, steps: list[Step]) -> None:
    obeys(kind, steps)


@pytest.mark.soak
@pytest.mark.timeout(7200)
@pytest.mark.parametrize("kind", KINDS)
def test_no_sequence_of_10_000_breaks_a_limit_or_a_cap(kind: str) -> None:
    @SOAK
    @given(steps=steps_of_any)
    def holds(steps: list[Any]) -> None:
        obeys(kind, steps)

    holds()


# ------------------------------------------------------------------------------------------ with faults


def noticeable(kind: str) -> list[Fault]:
    return sorted(fault for (name, fault), row in DETECTIONS.items() if name == kind and row is not None)


def troubled_steps(kind: str) -> st.SearchStrategy[list[Any]]:
    suffering = st.tuples(st.sampled_from(["begins", "ends"]), st.sampled_from(noticeable(kind)), st.integers(0, 200))
    return st.lists(st.one_of(st.tuples(whats, goals, rates, st.integers(0, 90)), suffering), min_size=1, max_size=12)


def survives(kind: str, steps: list[Any]) -> None:
    """Nothing raises but what may be refused, nothing claims to be where it is not, and a stop ends it all."""
    rig = rig_of(kind).open()
    goal: float | None = None
    for step in steps:
        if step[0] in {"begins", "ends"}:
            rig.far_end.afflict(step[1], on=step[0] == "begins")
        elif ask(rig, step):
            goal = math.radians(step[1]) if step[0] == "go" else None
        for _ in range(step[-1]):
            rig.clock.sleep(QUANTUM)
            where = f"{rig.state}, truly at {rig.far_end.angle():.3f} rad"
            assert goal is None or not rig.state.settled or abs(rig.state.angle - goal) <= rig.tolerance, where
    for fault in noticeable(kind):
        rig.far_end.afflict(fault, on=False)
    rig.actuator.stop()
    rig.clock.sleep(2 * BRAKING * QUANTUM)
    here = rig.far_end.angle()
    rig.clock.sleep(1.0)
    assert rig.far_end.angle() == pytest.approx(here, abs=math.radians(0.3))
    rig.actuator.__exit__(None, None, None)


@pytest.mark.parametrize("kind", kinds())
def test_no_sequence_of_commands_and_faults_confuses_a_driver(kind: str) -> None:
    @FEW
    @given(steps=troubled_steps(kind))
    def holds(steps: list[Any]) -> None:
        survives(kind, steps)

    holds()


@pytest.mark.soak
@pytest.mark.timeout(7200)
@pytest.mark.parametrize("kind", [kind for kind in KINDS if noticeable(kind)])
def test_no_sequence_of_200_commands_and_faults_confuses_a_driver(kind: str) -> None:
    @settings(SOAK, max_examples=200)
    @given(steps=troubled_steps(kind))
    def holds(steps: list[Any]) -> None:
        survives(kind, steps)

    holds()
