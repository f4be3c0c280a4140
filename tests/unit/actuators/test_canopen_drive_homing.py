"""How a CANopen drive finds where it is, and which options make sense."""

import itertools
import math

import pytest

from drive_bench import OPENING, Bench
from examples import rows_in_soak
from ross_payload.actuators.canopen_drive.options import Options
from ross_payload.errors import ConfigError, NotHomed
from ross_protocols.canopen import cia402
from ross_protocols.canopen.cia402 import State
from ross_sim.devices.far_end import Fault

# -------------------------------------------------------------------------------------------------- homing


@pytest.mark.parametrize(
    ("method", "gear"),
    [
        ("negative_limit", 20.0),
        ("switch_positive", -20.0),
        *rows_in_soak(("negative_limit", -20.0), ("switch_positive", 20.0)),
        *rows_in_soak(*itertools.product(("positive_limit", "switch_negative"), (20.0, -20.0))),
    ],
)
def test_homing_finds_the_switch_and_then_the_angle_is_true(method, gear):
    towards = (1 if "positive" in method else -1) * (1 if gear > 0 else -1)
    bench = Bench(homing=method, zero_deg=towards * 50.0, gear_ratio=gear, homing_deg_s=40.0, angle=5.0).open()
    assert not bench.state.homed
    with pytest.raises(NotHomed):
        bench.go(0)
    bench.home()
    assert bench.state.angle == pytest.approx(bench.far_end.angle(), abs=math.radians(0.02))
    assert bench.true_deg == pytest.approx(towards * 50.0, abs=3)
    bench.go(0)
    bench.settle()
    assert bench.true_deg == pytest.approx(0, abs=0.1)


def test_homing_here_takes_the_place_for_zero():
    bench = Bench(homing="here", zero_deg=15.0, angle=15.0).open()
    bench.home()
    assert math.degrees(bench.state.angle) == pytest.approx(15, abs=0.02)
    bench.go(-15)
    bench.settle()
    assert bench.true_deg == pytest.approx(-15, abs=0.1)


def test_home_is_found_again_after_it_was_found_before():
    bench = Bench(homing="negative_limit", zero_deg=-50.0, homing_deg_s=40.0).open()
    bench.home()
    bench.go(0)
    bench.settle()
    bench.actuator.home()
    bench.clock.sleep(0.2)
    assert not bench.state.homed
    bench.home()
    assert bench.true_deg == pytest.approx(-50, abs=3)


def test_a_slip_is_put_right_by_homing_with_a_switch():
    bench = Bench(homing="negative_limit", zero_deg=-50.0, homing_deg_s=40.0).open()
    bench.home()
    bench.far_end.afflict(Fault.SLIP)
    bench.clock.sleep(0.5)
    assert abs(bench.state.angle - bench.far_end.angle()) > math.radians(9)
    bench.home()
    assert bench.state.angle == pytest.approx(bench.far_end.angle(), abs=math.radians(0.02))
    assert bench.actuator.capabilities.finds_zero


def test_a_stop_ends_homing_and_the_place_stays_unknown():
    bench = Bench(homing="negative_limit", zero_deg=-90.0).open()
    bench.actuator.home()
    bench.clock.sleep(1.0)
    bench.actuator.stop()
    bench.clock.sleep(1.0)
    stopped = bench.true_deg
    bench.clock.sleep(3.0)
    assert -40 < bench.true_deg == stopped
    assert not bench.state.homed


def test_a_homing_error_is_told():
    bench = Bench(homing="negative_limit", zero_deg=-90.0).open()
    bench.set(cia402.HOMING_METHOD, 1)  # which the drive does not have
    bench.actuator.home()
    bench.clock.sleep(0.5)
    assert bench.fault == "homing failed: the drive reports a homing error"


@pytest.mark.parametrize(("homing", "known"), [("none", True), ("here", False)])
def test_after_a_restart_only_an_absolute_encoder_knows_where_it_is(homing, known):
    bench = Bench(homing=homing).open()
    bench.home()
    bench.go(60, 0.5)
    bench.far_end.afflict(Fault.REBOOT)
    bench.clock.sleep(2.0)
    assert bench.fault == "the drive at node 5 has restarted"
    assert not bench.state.homed or known
    assert bench.drive_state is State.SWITCH_ON_DISABLED
    bench.actuator.home()
    bench.clock.sleep(OPENING)
    bench.actuator.rearm()
    if known:
        bench.go(-20)
        bench.settle()
        assert bench.true_deg == pytest.approx(-20, abs=0.1)


# -------------------------------------------------------------------------------------------------- options


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"lower_deg": 10, "upper_deg": 10}, "expected lower_deg below upper_deg, got 10 and 10"),
        ({"node_id": 7, "own_node_id": 7}, "both 7"),
        ({"gear_ratio": 0.0}, "too near to 0"),
        ({"counts_per_turn": 1e9, "gear_ratio": 100}, "32 bits"),
        ({"port": "serial:/dev/null"}, "port"),
        ({"homing": "index"}, "homing"),
        ({"counts_per_turn": math.nan}, "counts_per_turn"),
        ({"node_id": 128}, "node_id"),
    ],
)
def test_options_that_make_no_sense_are_refused(options, words):
    with pytest.raises(ConfigError, match=words):
        Bench(**options)


def test_counts_and_angles_are_inverse():
    options = Options(counts_per_turn=10000, gear_ratio=-50.0, zero_deg=-12.5)
    for degrees in (-200, -12.5, 0, 77.7, 200):
        joint = math.radians(degrees)
        assert options.joint(options.counts(joint)) == pytest.approx(joint, abs=2 * math.pi / 500000)


def test_a_goal_that_is_given_while_it_homes_comes_after():
    bench = Bench(homing="here").open()
    bench.home()
    bench.go(20)
    bench.settle()
    bench.actuator.home()
    bench.go(10)
    bench.settle()
    assert bench.true_deg == pytest.approx(30, abs=0.1)


def test_a_drive_that_was_closed_may_have_been_switched_off_meanwhile():
    bench = Bench(homing="here").open()
    bench.home()
    bench.close()
    bench.open()
    assert not bench.state.homed
