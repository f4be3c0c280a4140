"""The emulated TB6600 module and its motor: torque that is not enough, and edges that break a rule."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from examples import in_soak
from ross_payload.actuators.registry import checked_options
from ross_payload.actuators.tb6600.pulse_segments import EDGE, PulseLine, RanOut, Segment
from ross_payload.config import Config
from ross_sim.devices.stepper import Motor
from ross_sim.devices.tb6600_far_end import Tb6600FarEnd, far_end
from tb6600_bench import Bench

# ------------------------------------------------------------------------------------------ torque


def heavy(torque_needed: float, acceleration_deg: float) -> Motor:
    """A load that needs a fraction of the holding torque at an acceleration."""
    inertia = torque_needed * Motor().holding_torque / math.radians(acceleration_deg)
    return replace(Motor(), load_inertia=inertia, coulomb=0.0, viscous=1e-3)


@pytest.mark.soak
@pytest.mark.parametrize("acceleration_deg", [112.5, *in_soak(6000.0)])
def test_half_the_torque_is_enough_and_one_and_a_half_is_not(acceleration_deg: float) -> None:
    options: dict[str, Any] = {"max_acceleration_deg_s2": acceleration_deg}
    fine = Bench(heavy(0.5, acceleration_deg), **options).go(90.0, 20.0)
    assert fine.far.full_steps_lost == 0
    lost = Bench(heavy(1.5, acceleration_deg), **options).go(90.0, 20.0)
    assert lost.far.complaints()[0].startswith("steps lost since")


def test_steps_are_lost_by_four_and_the_driver_cannot_know() -> None:
    bench = Bench(replace(heavy(1.5, 6000.0), viscous=0.02), max_acceleration_deg_s2=6000.0).go(90.0, 10.0)
    lost = bench.far.full_steps_lost
    assert lost != 0
    assert lost % 4 == 0
    assert bench.true_deg == pytest.approx(90.0 + 1.8 * lost, abs=1e-6)
    assert bench.guard.state().healthy
    assert bench.guard.state().angle == pytest.approx(math.radians(90.0))
    assert f"{lost:+d} full steps" in bench.far.complaints()[0]


def pull_out(motor: Motor, speed: float) -> float:
    """Greatest torque [N m] at a speed [rad/s]: above the corner speed it falls with the inductance of the windings."""
    return motor.holding_torque / math.hypot(1.0, speed / motor.corner_speed)


def test_speed_beyond_the_pull_out_torque_loses_steps() -> None:
    weak = replace(Motor(), corner_speed=3.0, viscous=0.03)
    slow = Bench(weak, max_speed_deg_s=100.0, max_acceleration_deg_s2=112.5).go(190.0)
    assert pull_out(weak, math.radians(100)) > 0.03 * math.radians(100) + weak.coulomb
    assert slow.far.complaints() == []
    quick = Bench(weak, max_speed_deg_s=700.0, max_acceleration_deg_s2=3000.0).go(190.0)
    assert pull_out(weak, math.radians(700)) < 0.03 * math.radians(700) + weak.coulomb
    assert quick.far.complaints()


# ------------------------------------------------------------------------------------------ the module's rules

UP = [(1.0, PulseLine.DIRECTION, True)]

PULSE = [(1.1, PulseLine.STEP, True), (1.1 + 1e-5, PulseLine.STEP, False)]


@pytest.mark.parametrize(
    ("edges", "rule", "found"),
    [
        ([*UP, (1.1, PulseLine.STEP, True), (1.1 + 1e-6, PulseLine.STEP, False)], "STEP high", 1e-6),
        ([*UP, *PULSE, (1.1 + 1.2e-5, PulseLine.STEP, True), (1.2, PulseLine.STEP, False)], "STEP low", 2e-6),
        ([(1.1 - 3e-6, PulseLine.DIRECTION, True), *PULSE], "DIRECTION set-up", 3e-6),
        (
            [*UP, (1.1, PulseLine.STEP, True), (1.1 + 4e-6, PulseLine.DIRECTION, False), (1.2, PulseLine.STEP, False)],
            "DIRECTION hold",
            4e-6,
        ),
        ([(1.0, PulseLine.ENABLE, True), (1.1 - 2e-6, PulseLine.ENABLE, False), *PULSE], "ENABLE lead", 2e-6),
        ([(1.0, PulseLine.ENABLE, True), *PULSE, (1.2, PulseLine.ENABLE, False)], "STEP while off", 0.0),
    ],
)
def test_the_module_names_the_rule_that_is_broken(edges: list[Any], rule: str, found: float) -> None:
    module = played(edges)
    assert [violation.rule for violation in module.violations] == [rule]
    assert module.violations[0].found == pytest.approx(found, abs=1e-12)
    assert module.complaints()[0].startswith(f"{rule}: expected ")
    assert f" us, got {found * 1e6:.2f} us, at " in module.complaints()[0]


def test_clean_edges_break_no_rule_in_one_piece_or_in_many() -> None:
    edges = [*UP, *PULSE, (1.2, PulseLine.DIRECTION, False), (1.3, PulseLine.STEP, True), (1.4, PulseLine.STEP, False)]
    whole, pieces = played(edges), played(*([edge] for edge in edges))
    assert whole.violations == pieces.violations == ()
    assert whole.count == pieces.count == 0


def test_edges_handed_over_late_are_noticed() -> None:
    module = played([])
    module.port.send(segment_of([*UP, *PULSE]))
    module.advance(3.0)
    assert module.violations[0].rule == "handed over late"
    assert any(isinstance(report, RanOut) for report in module.port.receive())


def test_torque_that_comes_on_late_loses_no_position() -> None:
    module = played([])
    module.port.send(segment_of([(0.0, PulseLine.ENABLE, True), (0.0, PulseLine.ENABLE, False), *UP]))
    module.advance(3.0)
    assert module.violations == ()
    assert not any(isinstance(report, RanOut) for report in module.port.receive())


def played(*parts: Iterable[Any]) -> Tb6600FarEnd:
    """Play edges on a fresh module, one segment per part, until 2 s."""
    module = far_end.make(checked_options(Config.model_validate({"actuator": {"kind": "tb6600"}})))
    module.port.send(segment_of([(0.5, PulseLine.ENABLE, True), (0.6, PulseLine.ENABLE, False)]))
    for part in parts:
        module.port.send(segment_of(part))
    for quantum in range(1, 201):
        module.advance(quantum * 0.01)
    return module


def segment_of(edges: Iterable[Any]) -> Segment:
    return Segment(0.0, 2.0, np.array(list(edges), dtype=EDGE))
