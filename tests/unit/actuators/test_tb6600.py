"""The TB6600 driver and its far end: what crosses the wire, what the module says of it, what the motor does."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from examples import examples
from rigs import rig_of
from ross_payload.actuators.tb6600.pulse_segments import PulseLine
from ross_payload.errors import ActuatorFault, ConfigError, LinkError, NotHomed
from ross_sim.clock import QUANTUM
from ross_sim.devices.far_end import Fault
from tb6600_bench import Bench


def test_90_degrees_are_800_pulses_at_sixteenth_steps() -> None:
    assert len(Bench().go(90).rises()) == 800


def test_segments_are_contiguous_and_end_40_ms_ahead_at_every_poll() -> None:
    bench = Bench()
    bench.guard.command(2.0)
    for _ in range(100):
        bench.clock.sleep(QUANTUM)
        assert bench.far.port.sent[-1].end == pytest.approx(bench.clock.now() + 0.040, abs=QUANTUM)
        assert bench.far.port.sent[-1].end < bench.clock.now() + 0.040 + 1e-9
    moving = bench.far.port.sent[1:]
    for before, after in pairwise(moving):
        assert after.start == pytest.approx(before.end, abs=1e-12)
    assert not moving[0].edges.flags.writeable


@pytest.mark.parametrize(
    ("ahead_ms", "pause", "survived"), [(40, 0.040, True), (40, 0.050, False), (500, 0.500, True), (500, 0.510, False)]
)
def test_a_move_survives_a_pause_of_the_program_that_is_no_longer_than_it_plans_ahead(
    ahead_ms: float, pause: float, survived: bool
) -> None:
    bench = Bench(ahead_ms=ahead_ms)
    bench.guard.command(3.0)
    bench.clock.sleep(0.8)
    bench.cancel()
    bench.clock.sleep(pause)
    bench.guard.poll(bench.clock.now())
    assert bench.guard.state().healthy is survived


def test_a_move_ends_where_it_should_after_a_pause_of_nearly_half_a_second() -> None:
    bench = Bench(ahead_ms=500)
    bench.guard.command(math.radians(90.0))
    bench.clock.sleep(0.8)
    bench.cancel()
    bench.clock.sleep(0.48)  # and 10 ms until the next poll
    bench.clock.every(QUANTUM, lambda: bench.guard.poll(bench.clock.now()))
    bench.clock.sleep(3.0)
    assert bench.guard.state().settled
    assert bench.true_deg == pytest.approx(90.0, abs=1e-9)
    assert bench.far.complaints() == []


def test_where_a_motor_turns_a_stop_begins_in_a_tenth_of_a_second() -> None:
    with pytest.raises(ConfigError, match="expected at most 100 with a motor, got 150"):
        Bench(port="pulses:tcp:127.0.0.1:40002", ahead_ms=150)


@pytest.mark.parametrize("options", [{"invert_direction": True}, {"enable_means_off": False}, {"gear_ratio": 3.0}])
@pytest.mark.parametrize("microsteps", [1, 8, 32])
def test_every_way_to_wire_it_turns_counter_clockwise_for_positive_angles(
    options: dict[str, Any], microsteps: int
) -> None:
    bench = Bench(microsteps=microsteps, **options).go(45.0)
    assert bench.true_deg == pytest.approx(45.0, abs=1e-9)
    assert bench.far.complaints() == []


def test_the_wrong_microsteps_turn_by_the_wrong_angle() -> None:
    bench = Bench(microsteps=16)
    bench.far._options = bench.far._options.model_copy(update={"microsteps": 8})
    assert bench.go(45.0).true_deg == pytest.approx(90.0, abs=1e-9)


def test_no_edge_comes_before_the_torque_has_had_its_lead() -> None:
    bench = Bench(enable_lead_ms=700).go(9.0)
    edges = bench.edges()
    on = edges["time"][edges["line"] == PulseLine.ENABLE][0]
    others = edges["time"][edges["line"] != PulseLine.ENABLE]
    assert 0.7 <= others.min() - on < 0.8


def test_an_unknown_zero_needs_homing_and_has_no_torque_until_then() -> None:
    bench = Bench(zero="unknown")
    with pytest.raises(NotHomed):
        bench.guard.command(0.1)
    assert len(bench.rises()) == 0
    bench.guard.home()
    bench.clock.sleep(0.2)
    assert bench.guard.state().homed
    assert bench.go(9.0).true_deg == pytest.approx(9.0, abs=1e-9)
    assert bench.far.complaints() == []


def test_after_release_the_position_is_unknown_until_homed() -> None:
    bench = Bench().go(10.0)
    bench.guard.release()
    bench.clock.sleep(2.0)
    assert not bench.guard.state().homed
    with pytest.raises(NotHomed):
        bench.guard.command(0.0)
    assert bench.true_deg == pytest.approx(1.8 * 6, abs=1e-6)  # the detent nearest to 10 deg
    bench.guard.home()
    bench.clock.sleep(0.5)
    assert bench.guard.state().angle == 0.0


def test_a_home_asked_for_in_flight_waits_for_rest() -> None:
    bench = Bench()
    bench.guard.command(2.0)
    bench.clock.sleep(0.5)
    bench.guard.home()
    with pytest.raises(NotHomed):
        bench.guard.command(0.0)
    bench.clock.sleep(3.0)
    state = bench.guard.state()
    assert state.homed
    assert state.settled
    assert state.angle == 0.0
    assert bench.true_deg > 10
    assert bench.far.complaints() == []


def test_pulses_that_run_out_in_mid_move_are_a_fault_that_loses_the_position() -> None:
    bench = Bench()
    bench.guard.command(3.0)
    bench.clock.sleep(0.8)
    bench.cancel()
    bench.clock.sleep(0.2)
    bench.guard.poll(bench.clock.now())
    state = bench.guard.state()
    assert "pulse underrun" in state.fault
    assert not state.homed
    assert not state.settled
    with pytest.raises(ActuatorFault):
        bench.guard.command(0.0)


def test_segments_that_the_wire_gets_too_late_are_a_fault_that_loses_the_position() -> None:
    """The program knows nothing of a pause of the wire; the other end does."""
    bench = Bench()
    bench.guard.command(3.0)
    bench.clock.sleep(0.8)
    bench.far.afflict(Fault.SATURATED)
    bench.clock.sleep(0.2)
    state = bench.guard.state()
    assert state.fault.startswith("pulse underrun: edges arrived too late")
    assert not state.homed
    bench.far.afflict(Fault.SATURATED, on=False)
    bench.clock.sleep(0.5)
    bench.guard.home()
    bench.clock.sleep(0.5)
    bench.guard.rearm()
    here = bench.true_deg
    assert bench.go(9.0).true_deg - here == pytest.approx(9.0, abs=0.12)


@pytest.mark.parametrize(
    ("options", "pulses"),
    [
        ({"microsteps": 32, "gear_ratio": 5.0}, 20000),
        ({"max_speed_deg_s": 1700.0}, 15111),
        ({"max_pulse_rate_hz": 1990.0}, 2000),  # 2000 would do
    ],
)
def test_a_speed_that_needs_more_pulses_than_the_cap_is_refused(options: dict[str, Any], pulses: int) -> None:
    with pytest.raises(ConfigError, match=rf"needs {pulses} pulses/s, expected at most .*max_pulse_rate_hz"):
        Bench(**options)


@pytest.mark.parametrize("stays", [Fault.STALL, Fault.STUCK, Fault.SLIP])
def test_what_happens_behind_an_open_loop_the_driver_cannot_know(stays: Fault) -> None:
    bench = Bench()
    bench.guard.command(math.radians(90))
    bench.clock.sleep(0.8)
    bench.far.afflict(stays)
    bench.clock.sleep(3.0)
    state = bench.guard.state()
    assert state.healthy
    assert state.settled
    assert math.degrees(state.angle) == pytest.approx(90.0)
    assert abs(bench.true_deg - 90.0) > 5


def test_a_process_that_dies_at_full_speed_leaves_at_most_40_ms_of_pulses() -> None:
    bench = Bench()
    bench.guard.command(3.0)
    bench.clock.sleep(1.5)
    here, rate = bench.true_deg, math.degrees(bench.guard.state().rate)
    bench.cancel()
    bench.clock.sleep(2.0)
    assert bench.true_deg - here < rate * 0.05 + 7.2


def test_the_state_follows_the_shaft_within_half_a_degree_while_turning() -> None:
    bench = Bench()
    bench.guard.command(math.radians(180))
    for _ in range(260):
        bench.clock.sleep(QUANTUM)
        assert abs(math.degrees(bench.guard.state().angle) - bench.true_deg) < 0.5


step = st.tuples(st.floats(-199, 199), st.floats(1, 400), st.integers(1, 80), st.booleans())


@settings(max_examples=examples(20))
@given(steps=st.lists(step, min_size=1, max_size=6), microsteps=st.sampled_from([1, 4, 16, 32]))
def test_no_sequence_of_goals_and_stops_breaks_the_module_s_timing_or_the_caps(
    steps: list[tuple[float, float, int, bool]], microsteps: int
) -> None:
    bench = Bench(guard={"max_speed_deg_s": 225, "max_acceleration_deg_s2": 112.5}, microsteps=microsteps)
    for goal, rate, quanta, stop in steps:
        bench.guard.command(math.radians(goal), math.radians(rate))
        bench.clock.sleep(quanta * QUANTUM)
        if stop:
            bench.guard.stop()
            bench.guard.rearm()
    bench.guard.stop()
    bench.clock.sleep(3.0)
    assert bench.far.violations == ()
    assert bench.far.full_steps_lost == 0
    _keeps_its_distances(bench.edges(), microsteps)
    assert bench.far.angle() == pytest.approx(bench.guard.state().angle, abs=1e-9)


def _keeps_its_distances(edges: np.ndarray, microsteps: int) -> None:
    """Rises 1/15 kHz apart at least, and never faster than 225 deg/s between steps in one direction."""
    order = edges[np.argsort(edges["time"], kind="stable")]
    assert np.array_equal(order["time"], edges["time"])
    rises = edges["time"][(edges["line"] == PulseLine.STEP) & edges["level"]]
    turns = edges["time"][edges["line"] == PulseLine.DIRECTION]
    assert np.all(np.diff(rises) >= 1 / 15000 - 1e-9)
    same = np.searchsorted(turns, rises[1:]) == np.searchsorted(turns, rises[:-1])
    fastest = 1.8 / microsteps / 225
    assert np.all(np.diff(rises)[same] >= fastest * (1 - 1e-4) - 1e-9)


def test_a_wire_that_fails_while_it_is_closed_does_not_play_the_turn_to_its_end() -> None:
    rig = rig_of("tb6600").open()
    rig.actuator.command(3.0)
    rig.clock.sleep(0.8)
    here = rig.far_end.angle()
    rig.held_up = True

    def fails() -> list[Any]:
        raise LinkError("/dev/gpiochip0: bad handle")

    rig.wire.receive = fails  # type: ignore[method-assign]
    rig.actuator.__exit__(None, None, None)
    rig.clock.sleep(5.0)
    assert rig.far_end.angle() - here < math.radians(60)


def test_a_segment_that_the_wire_refuses_is_a_fault_that_loses_the_position() -> None:
    rig = rig_of("tb6600").open()
    rig.actuator.command(math.radians(90))
    rig.clock.sleep(0.8)
    send, refused = rig.wire.send, []

    def refuses_one(segment: Any) -> None:
        if not refused:
            refused.append(segment)
            raise LinkError("/dev/gpiochip0: no memory")
        send(segment)

    rig.wire.send = refuses_one  # type: ignore[method-assign]
    rig.clock.sleep(3.0)
    assert rig.state.fault == "/dev/gpiochip0: no memory"
    assert not rig.state.homed
    with pytest.raises(ActuatorFault, match="the position is lost"):
        rig.actuator.rearm()
    rig.home()
    rig.actuator.rearm()
    here = rig.far_end.angle()
    rig.actuator.command(math.radians(9))
    rig.settle(within=5.0)
    assert rig.far_end.angle() - here == pytest.approx(math.radians(9), abs=rig.tolerance)


def test_a_wire_that_refuses_the_last_pulses_is_closed_all_the_same() -> None:
    rig = rig_of("tb6600").open()
    rig.actuator.command(3.0)
    rig.clock.sleep(0.8)
    rig.held_up = True
    close, closed = rig.wire.close, []

    def fails(segment: Any) -> None:
        raise LinkError("/dev/gpiochip0: no memory")

    def notes() -> None:
        closed.append(True)
        close()

    rig.wire.send, rig.wire.close = fails, notes  # type: ignore[method-assign]
    with pytest.raises(LinkError):
        rig.actuator.__exit__(None, None, None)
    assert closed
