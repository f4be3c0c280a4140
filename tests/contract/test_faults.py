"""Every fault in every driver where it makes sense: noticed in time, motion ended, cause named, never 'settled'.

A fault begins in the middle of a move or at rest before one, and when it is over the actuator comes back: home, rearm,
and a move that ends where it should. Every back end meets every fault in mid-move, and at rest too what is not noticed
by the move alone (`AT_REST`); in its other roles (`ROLES`) it meets what it notices in another way there.
`make soak` has 20 moments of each fault in each role, and the return after both.
"""

from __future__ import annotations

import math
from contextlib import suppress

import numpy as np
import pytest

from detections import DETECTIONS, Detection
from rigs import KINDS, Rig, rig_of
from ross_payload.errors import ActuatorError
from ross_sim.clock import QUANTUM
from ross_sim.devices.far_end import Fault

pytestmark = pytest.mark.lockstep

STILL = math.radians(0.3)  # between two looks a second apart [rad]
CASES = [
    pytest.param(kind, fault, detection, id=f"{kind}-{fault}")
    for (kind, fault), detection in DETECTIONS.items()
    if detection is not None
]
ROLES = {
    ("mavlink_gimbal:manager", Fault.TAKEN),  # somebody else's set-points, not another one's control
    ("dronecan_servo:gimbal", Fault.STALL),  # angles come in another message
    ("dronecan_servo:model", Fault.SILENT),  # what is silent tells no angle
    ("vehicle_yaw:offboard", Fault.MODE),
    ("vehicle_yaw:offboard", Fault.PILOT),
    ("vehicle_yaw:offboard", Fault.DISARMED),
    ("vehicle_yaw:offboard", Fault.LANDED),
}
AT_REST = {  # that begin at rest with every test too: the others are noticed by the move, as those of mid-move
    Fault.SILENT, Fault.REBOOT, Fault.TAKEN, Fault.DUPLICATE, Fault.PILOT, Fault.MODE, Fault.DISARMED,
    Fault.LANDED,
}  # fmt: skip
EVERY_BACK_END = [case for case in CASES if ":" not in str(case.values[0]) or case.values[:2] in ROLES]
ARRIVAL = 8.0  # of a move that a fault does not hinder [s]
BACK = 20.0  # in which it must be well again after the fault is over [s]


def at_rest(rig: Rig, chance: np.random.Generator) -> None:
    """Let it hold a random goal."""
    rig.settle(within=5.0)
    rig.actuator.command(math.radians(chance.uniform(-60, 60)))
    rig.settle(within=8.0)


def far_away(rig: Rig, chance: np.random.Generator) -> float:
    """A goal at least 60 deg away, within the limits also where somebody else has turned it far [rad]."""
    here, way = rig.state.angle, math.radians(chance.uniform(60, 120) * chance.choice([-1, 1]))
    return here + way if abs(here + way) < rig.upper else here - way


def truly_settled(rig: Rig, goal: float) -> bool:
    """Whether it says that it settled; then it must be there."""
    settled = rig.state.settled
    assert not settled or abs(rig.far_end.angle() - goal) <= rig.tolerance, f"settled elsewhere: {rig.state}"
    return settled


def noticed(rig: Rig, goal: float, detection: Detection) -> None:
    """Wait until the fault is noticed; until then it may be at the goal, if it really is there."""
    end = rig.clock.now() + detection.within
    while rig.state.healthy:
        truly_settled(rig, goal)
        assert rig.clock.now() < end, f"not noticed: {rig.state}"
        rig.clock.sleep(QUANTUM)
    assert detection.matches(rig.state.fault), rig.state.fault


def noticed_or_there(rig: Rig, goal: float, detection: Detection) -> bool:
    """Wait until the fault is noticed, or the goal is reached all the same."""
    end = rig.clock.now() + max(detection.within, ARRIVAL)
    while rig.state.healthy:
        if truly_settled(rig, goal):
            return False
        assert rig.clock.now() < end, f"neither noticed nor there: {rig.state}"
        rig.clock.sleep(QUANTUM)
    assert detection.matches(rig.state.fault, began_at_rest=True), rig.state.fault
    return True


def comes_to_rest(rig: Rig, detection: Detection) -> None:
    """Braking is over and nothing moves, nor says that it settled."""
    rig.clock.sleep(rig.speed / rig.actuator.capabilities.max_acceleration + detection.rest)
    here = rig.far_end.angle()
    for _ in range(100):
        rig.clock.sleep(QUANTUM)
        assert not rig.state.settled
    assert rig.far_end.angle() == pytest.approx(here, abs=STILL)


def comes_back(rig: Rig) -> None:
    """The fault is over: home, rearm, and a move that ends where it should."""
    rig.clock.sleep(1.0)
    rig.actuator.home()
    end = rig.clock.now() + BACK
    while not rig.state.settled:
        rig.clock.sleep(0.1)
        assert rig.clock.now() < end, f"not well again: {rig.state}"
        with suppress(ActuatorError):
            rig.actuator.rearm()
    start, here = rig.state.angle, rig.far_end.angle()
    way = -math.copysign(0.4, start)
    rig.actuator.command(start + way)
    rig.settle(within=5.0)
    assert rig.far_end.angle() - here == pytest.approx(way, abs=0.01)


def at_rest_before_a_move(rig: Rig, fault: Fault, detection: Detection, chance: np.random.Generator) -> None:
    """It holds a goal already."""
    held = goal = rig.state.angle
    rig.far_end.afflict(fault)
    for _ in range(chance.integers(1, 150)):
        rig.clock.sleep(QUANTUM)
        truly_settled(rig, held)
    if rig.state.healthy:
        goal = far_away(rig, chance)
        rig.actuator.command(goal)
    if noticed_or_there(rig, goal, detection):
        comes_to_rest(rig, detection)
    rig.far_end.afflict(fault, on=False)


def in_mid_move(rig: Rig, fault: Fault, detection: Detection, chance: np.random.Generator) -> None:
    """It holds a goal already."""
    goal = far_away(rig, chance)
    rig.actuator.command(goal)
    rig.clock.sleep(chance.uniform(0.1, 0.8))
    rig.far_end.afflict(fault)
    noticed(rig, goal, detection)
    comes_to_rest(rig, detection)
    rig.far_end.afflict(fault, on=False)


@pytest.mark.parametrize(("kind", "fault", "detection"), EVERY_BACK_END)
def test_a_fault_is_noticed_in_mid_move_in_time_and_in_words_and_at_rest_with_the_next_move_at_the_latest(
    kind: str, fault: Fault, detection: Detection
) -> None:
    rig, chance = rig_of(kind).open(), np.random.default_rng(1)
    at_rest(rig, chance)
    in_mid_move(rig, fault, detection, chance)
    comes_back(rig)
    if fault in AT_REST:
        if abs(rig.far_end.angle() - rig.state.angle) > rig.tolerance:  # its zero is where it was told to home
            rig.actuator.__exit__(None, None, None)
            rig = rig_of(kind).open()
            at_rest(rig, chance)
        at_rest_before_a_move(rig, fault, detection, chance)
    rig.actuator.__exit__(None, None, None)


@pytest.mark.soak
@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize(("kind", "fault", "detection"), CASES)
def test_faults_are_noticed_at_20_moments(kind: str, fault: Fault, detection: Detection, seed: int) -> None:
    for happens in (in_mid_move, at_rest_before_a_move):
        rig, chance = rig_of(kind).open(), np.random.default_rng(seed)
        at_rest(rig, chance)
        happens(rig, fault, detection, chance)
        comes_back(rig)
        rig.actuator.__exit__(None, None, None)


@pytest.mark.parametrize("kind", KINDS)
def test_every_fault_of_a_far_end_has_its_row(kind: str) -> None:
    rows = {fault for name, fault in DETECTIONS if name == kind}
    assert rows == rig_of(kind).far_end.faults
