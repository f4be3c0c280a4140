"""Every fault in every driver where it makes sense: noticed in time, motion ended, cause named, never 'settled'."""

from __future__ import annotations

import math

import numpy as np
import pytest

from detections import DETECTIONS, Detection
from rigs import KINDS, Rig, rig_of
from ross_sim.clock import QUANTUM
from ross_sim.far_end import Fault

STILL = math.radians(0.3)  # between two looks a second apart [rad]
CASES = [(kind, fault, detection) for (kind, fault), detection in DETECTIONS.items() if detection is not None]


def moving(kind: str, seed: int) -> tuple[Rig, float]:
    """A rig in the middle of a random move of at least 60 deg, and its goal [rad]."""
    chance = np.random.default_rng(seed)
    rig = rig_of(kind).open()
    rig.settle(within=5.0)
    start = math.radians(chance.uniform(-60, 60))
    rig.actuator.command(start)
    rig.settle(within=8.0)
    goal = start + math.radians(chance.uniform(60, 120) * chance.choice([-1, 1]))
    rig.actuator.command(goal)
    rig.clock.sleep(chance.uniform(0.1, 0.8))
    return rig, goal


def suffer(rig: Rig, goal: float, detection: Detection) -> None:
    """Wait until the fault is noticed; it may be at the goal before, if it really is there."""
    end = rig.clock.now() + detection.within
    while rig.state.healthy:
        assert rig.clock.now() < end, f"not noticed: {rig.state}"
        rig.clock.sleep(QUANTUM)
        assert not rig.state.settled or abs(rig.far_end.angle() - goal) <= rig.tolerance, "settled elsewhere"
    assert detection.matches(rig.state.fault), rig.state.fault


def comes_to_rest(rig: Rig) -> None:
    """Braking is over and nothing moves, nor says that it settled."""
    rig.clock.sleep(rig.speed / rig.actuator.capabilities.max_acceleration + 1.0)
    here = rig.far_end.angle()
    for _ in range(100):
        rig.clock.sleep(QUANTUM)
        assert not rig.state.settled
    assert rig.far_end.angle() == pytest.approx(here, abs=STILL)


def noticed(kind: str, fault: Fault, detection: Detection, seed: int) -> None:
    rig, goal = moving(kind, seed)
    rig.far_end.afflict(fault)
    suffer(rig, goal, detection)
    comes_to_rest(rig)
    rig.actuator.__exit__(None, None, None)


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize(("kind", "fault", "detection"), CASES)
def test_a_fault_is_noticed_in_time_and_in_words(kind: str, fault: Fault, detection: Detection, seed: int) -> None:
    noticed(kind, fault, detection, seed)


@pytest.mark.soak
@pytest.mark.parametrize(("kind", "fault", "detection"), CASES)
def test_a_fault_is_noticed_in_time_and_in_words_at_20_moments(kind: str, fault: Fault, detection: Detection) -> None:
    for seed in range(20):
        noticed(kind, fault, detection, seed)


@pytest.mark.parametrize("kind", KINDS)
def test_every_fault_of_a_far_end_has_its_row(kind: str) -> None:
    rows = {fault for name, fault in DETECTIONS if name == kind}
    assert rows == rig_of(kind).far_end.faults
