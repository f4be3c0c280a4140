"""One contract for everything that turns; each back end adds its name to `rigs.KINDS`."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from clocks import StallingClock
from device_rig import device_rig
from examples import in_soak
from rigs import ACCELERATION, LOWER, SWING, UPPER, Rig, kinds, rig_of
from ross_payload.actuators.registry import open_actuator
from ross_payload.config import Config
from ross_payload.errors import ActuatorFault, ConfigError, LimitError
from ross_payload.interfaces import Feedback, Services
from ross_payload.mission.sweep import Sweep
from ross_sim.clock import QUANTUM, SimClock

pytestmark = pytest.mark.lockstep


TOLD_OTHERWISE = ("mavlink_gimbal:manager", "dronecan_servo:gimbal", "vehicle_yaw:offboard")  # what a goal is said with
# [s]: after a longer pause of the payload the watchdog of a device, its autopilot or the guard has ended the move
LONGEST_PAUSE = {
    "tb6600": 0.0,
    "tb6600:switch": 0.0,
    "canopen_drive": 0.3,
    "grbl": 0.4,
    "mavlink_gimbal:manager": 0.4,
    "vehicle_yaw:offboard": 0.4,
}
LONGEST_PAUSE_AT_REST = {"canopen_drive": 0.3, "vehicle_yaw:offboard": 0.9}  # [s]: its own watchdog, its autopilot's
ROLES = {  # that run with every test; the other tests take every back end in its first role, and all roles in soak
    "test_it_reaches_every_goal_the_long_way_round_too_and_settles_there": TOLD_OTHERWISE,
    "test_stop_halts_within_the_braking_distance_and_100_ms_of_travel": TOLD_OTHERWISE,
    "test_it_is_never_settled_on_stale_feedback_and_the_guard_says_so": TOLD_OTHERWISE,
}


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Take every kind; a real device where a test asks for no more than a device can show, with --actuator."""
    if "kind" in metafunc.fixturenames:
        real = metafunc.definition.get_closest_marker("on_device") and metafunc.config.getoption("--actuator")
        device = [pytest.param(f"device:{real}", marks=pytest.mark.hardware)] if real else []
        metafunc.parametrize("kind", [*kinds(*ROLES.get(metafunc.definition.originalname, ())), *device])


@pytest.fixture
def rig(kind: str) -> Iterator[Rig]:
    if kind.startswith("device:"):
        with device_rig(Path(kind.removeprefix("device:"))) as rig:
            yield rig
        return
    rig = rig_of(kind).open()
    yield rig
    rig.actuator.__exit__(None, None, None)


@pytest.mark.on_device
def test_it_reaches_every_goal_the_long_way_round_too_and_settles_there(rig: Rig) -> None:
    """Joint angles do not wrap: 190 deg is not -170 deg."""
    able = rig.actuator.capabilities
    for goal in np.radians([0.0, 0.5, 15.0, -200.0, 190.0, 200.0]).tolist():
        if not able.lower <= goal <= able.upper:
            continue  # beyond the travel of this device
        within = 5.0 + max(abs(goal - rig.state.angle) - math.radians(200), 0.0) / rig.speed
        rig.actuator.command(goal)
        rig.settle(within)
        assert rig.state.angle == pytest.approx(goal, abs=rig.tolerance)
        assert rig.far_end.angle() == pytest.approx(goal, abs=rig.tolerance)
        assert rig.state.rate == 0.0
        assert rig.far_end.complaints() == []


@pytest.mark.soak
def test_at_rest_the_true_angle_is_the_reported_angle(rig: Rig) -> None:
    rig.actuator.command(math.radians(77.7))
    rig.settle(within=5.0)
    rig.clock.sleep(0.3)
    measured = rig.actuator.capabilities.feedback is Feedback.MEASURED
    assert rig.far_end.angle() == pytest.approx(rig.state.angle, abs=max(rig.tolerance / 2 if measured else 0, 1e-6))


@pytest.mark.soak
def test_15_degrees_take_what_the_paper_s_acceleration_allows(rig: Rig) -> None:
    rig.actuator.command(math.radians(15))
    began, last = rig.clock.now(), math.nan
    for _ in range(150):
        rig.clock.sleep(QUANTUM)
        last = rig.clock.now() if rig.state.rate != 0.0 else last
    assert -2 * QUANTUM <= last - began - 2 * math.sqrt(15 / 112.5) <= 2 * QUANTUM + rig.lag


@pytest.mark.on_device
def test_it_is_not_settled_between_the_command_and_the_goal(rig: Rig) -> None:
    rig.actuator.command(1.0)
    assert not rig.state.settled
    while abs(rig.far_end.angle() - 1.0) > 0.02:
        rig.clock.sleep(QUANTUM)
        assert not rig.state.settled


@pytest.mark.parametrize("second", [-1.0, *in_soak(2.5, 0.5)])
def test_a_goal_replaced_in_flight_is_reached_without_a_jump_in_speed(rig: Rig, second: float) -> None:
    rig.actuator.command(2.0)
    rig.clock.sleep(0.8)
    assert rig.state.rate > 1.0
    rig.actuator.command(second)
    end, before = rig.clock.now() + 7.0, rig.state.rate
    while not rig.state.settled:
        rig.clock.sleep(QUANTUM)
        assert abs(rig.state.rate - before) <= ACCELERATION * QUANTUM * 1.001 + rig.ripple
        assert rig.clock.now() < end, rig.state
        before = rig.state.rate
    assert rig.far_end.angle() == pytest.approx(second, abs=rig.tolerance)


@pytest.mark.parametrize("after", [0.2, *(pytest.param(each, marks=pytest.mark.soak) for each in (0.5, 0.8)), 1.1])
def test_stop_halts_within_the_braking_distance_and_100_ms_of_travel(rig: Rig, after: float) -> None:
    rig.actuator.command(rig.upper)
    rig.clock.sleep(after - QUANTUM)
    before = rig.far_end.angle()
    rig.clock.sleep(QUANTUM)
    here = rig.far_end.angle()
    speed = (here - before) / QUANTUM if rig.ripple else rig.state.rate  # what is measured comes late
    rig.actuator.stop()
    rig.clock.sleep(2.0)
    assert rig.state.rate == 0.0
    allowed = speed**2 / (2 * ACCELERATION) + (0.1 + rig.late) * (speed + ACCELERATION * 0.05) + SWING
    assert 0.0 <= rig.far_end.angle() - here <= allowed
    assert rig.far_end.angle() < rig.upper - 0.1
    assert rig.far_end.complaints() == []


def test_stop_ends_a_turn_back_and_forth_and_the_next_goal_of_it_is_refused(rig: Rig) -> None:
    """As a mission turns that explores without a pause."""
    sweep = Sweep((math.radians(20), 0.0), math.radians(30))
    while not (sweep.index == 1 and rig.far_end.angle() < math.radians(15)):
        assert rig.clock.now() < 20.0
        goal = sweep.next_goal()
        if goal is not None:
            rig.actuator.command(goal, sweep.rate)
        rig.clock.sleep(QUANTUM)
        sweep.update(settled=rig.state.settled)
    here = rig.far_end.angle()
    rig.actuator.stop()
    with pytest.raises(ActuatorFault, match="re-arm"):
        rig.actuator.command(sweep.goal, sweep.rate)
    rig.clock.sleep(2.0)
    assert rig.state.rate == 0.0
    braking = sweep.rate**2 / (2 * ACCELERATION)
    assert 0.0 <= here - rig.far_end.angle() <= braking + (0.1 + rig.late) * sweep.rate + SWING
    assert rig.far_end.complaints() == []


def test_a_move_goes_on_after_the_payload_was_held_up(rig: Rig, kind: str) -> None:
    """What is led by set-points has come to rest meanwhile, and is led on from there."""
    begin_a_move_and_pause(rig, LONGEST_PAUSE.get(kind, 3.0))
    rig.settle(within=6.0)
    assert rig.far_end.angle() == pytest.approx(rig.upper - 0.2, abs=rig.tolerance)
    assert rig.far_end.complaints() == []


@pytest.mark.parametrize("polled_first", [True, False])
def test_a_pause_of_the_whole_computer_is_no_fault(rig: Rig, kind: str, polled_first: bool) -> None:
    """Nothing arrives meanwhile, and what is simulated on the same computer makes up for it in a hurry."""
    if LONGEST_PAUSE.get(kind, 1.0) == 0.0 or not isinstance(rig.clock, StallingClock):
        return
    for goal in (rig.upper - 0.2, -1.0):
        rig.actuator.command(goal)
        rig.clock.sleep(0.8)
        rig.clock.stand_still(0.36)
        if polled_first:
            rig.actuator.poll(rig.clock.now())
        rig.settle(within=8.0)
        assert rig.state.healthy
        assert rig.far_end.angle() == pytest.approx(goal, abs=rig.tolerance)


@pytest.mark.parametrize("pause", [0.7, *in_soak(1.5, 4.0)])
def test_a_pause_of_the_payload_at_rest_is_no_fault(rig: Rig, kind: str, pause: float) -> None:
    """But where a watchdog of the device has taken its torque, or the autopilot has left its mode."""
    if pause > LONGEST_PAUSE_AT_REST.get(kind, 5.0):
        return
    rig.actuator.command(0.3)
    rig.settle(within=5.0)
    rig.clock.sleep(0.5)
    rig.pause(pause)
    for _ in range(100):
        rig.clock.sleep(QUANTUM)
        assert rig.state.healthy, rig.state
    assert rig.state.settled
    rig.actuator.command(0.5)
    rig.settle(within=5.0)


@pytest.mark.parametrize("pause", [0.3, 0.4, *in_soak(1.0, 3.0)])
def test_a_stop_after_the_payload_was_held_up_halts_as_any_other(rig: Rig, pause: float) -> None:
    begin_a_move_and_pause(rig, pause)
    here = rig.far_end.angle()
    rig.actuator.stop()
    rig.clock.sleep(2.0)
    assert rig.state.rate == 0.0
    assert abs(rig.far_end.angle() - here) <= rig.speed**2 / (2 * ACCELERATION) + (0.1 + rig.late) * rig.speed + SWING
    assert rig.far_end.complaints() == []


def test_a_stop_after_the_payload_was_held_up_halts_also_while_nothing_is_heard(rig: Rig) -> None:
    """What has come to rest without set-points is sent to no place that the plan has come to meanwhile."""
    rig.actuator.command(rig.upper - 0.2)
    rig.clock.sleep(0.8)
    rig.wire.cut = True
    rig.pause(1.0)
    here = rig.far_end.angle()
    rig.actuator.stop()
    rig.clock.sleep(0.4)
    rig.wire.cut = False
    rig.clock.sleep(2.0)
    assert abs(rig.far_end.angle() - here) <= rig.speed**2 / (2 * ACCELERATION) + (0.1 + rig.late) * rig.speed + SWING


@pytest.mark.parametrize("pause", [0.4, *in_soak(0.15, 0.3), 1.0, *in_soak(3.0)])
def test_a_stop_stays_one_when_the_payload_is_held_up_while_it_brakes(rig: Rig, pause: float) -> None:
    """What has come to rest without set-points does not turn on to where braking would have ended."""
    begin_a_move_and_pause(rig, 0.0)
    rig.actuator.stop()
    rig.clock.sleep(0.05)
    rig.pause(pause)
    rig.clock.sleep(max(1.5 - pause, 0.05))
    here = rig.far_end.angle()
    rig.clock.sleep(3.0)
    assert rig.far_end.angle() == pytest.approx(here, abs=SWING)
    assert rig.state.rate == 0.0


@pytest.mark.parametrize("pause", [0.0, 0.5, *in_soak(0.3, 1.0, 3.0)])
def test_closing_after_the_payload_was_held_up_brakes_from_where_it_stands(rig: Rig, pause: float) -> None:
    begin_a_move_and_pause(rig, pause)
    before = rig.far_end.angle()
    rig.held_up = True
    rig.clock.sleep(QUANTUM)
    here = rig.far_end.angle()
    speed = abs(here - before) / QUANTUM
    rig.actuator.__exit__(None, None, None)
    rig.clock.sleep(3.0)
    room = speed**2 / (2 * ACCELERATION) + (0.2 + rig.late) * (speed + ACCELERATION * 0.1) + math.radians(5)
    assert abs(rig.far_end.angle() - here) <= room


@pytest.mark.parametrize("period", [0.04, *in_soak(0.06)])
def test_a_move_takes_no_longer_when_polls_come_late(rig: Rig, kind: str, period: float) -> None:
    """A computer that is always a little late shall not make a move slower than the guard waits for."""
    if LONGEST_PAUSE.get(kind, 1.0) < period:
        return  # its edges run out, which is a fault: `test_tb6600`
    rig.actuator.command(1.5, 0.5)
    began = rig.clock.now()
    while not rig.state.settled:
        rig.pause(period - QUANTUM)
        rig.clock.sleep(QUANTUM)
        assert rig.clock.now() < began + 3.0 + 0.5 / ACCELERATION + rig.lag + 1.0, rig.state
    assert rig.far_end.angle() == pytest.approx(1.5, abs=rig.tolerance)


@pytest.mark.parametrize("period", [0.03, *in_soak(0.04, 0.06)])
def test_a_move_ends_at_its_goal_and_not_beyond_when_polls_come_late(rig: Rig, kind: str, period: float) -> None:
    if LONGEST_PAUSE.get(kind, 1.0) < period:
        return
    rig.actuator.command(1.0)
    farthest, end = 0.0, rig.clock.now() + 6.0
    while not rig.state.settled:
        rig.pause(period - QUANTUM)
        rig.clock.sleep(QUANTUM)
        farthest = max(farthest, rig.far_end.angle())
        assert rig.clock.now() < end, rig.state
    assert farthest <= 1.0 + rig.tolerance + SWING


def begin_a_move_and_pause(rig: Rig, pause: float) -> None:
    rig.actuator.command(rig.upper - 0.2)
    rig.clock.sleep(0.8)
    rig.pause(pause)


@pytest.mark.on_device
def test_stop_works_from_another_thread_twice_and_latches(rig: Rig) -> None:
    rig.actuator.command(1.0)
    rig.clock.sleep(0.3)
    for _ in range(2):
        thread = threading.Thread(target=rig.actuator.stop)
        thread.start()
        thread.join()
    with pytest.raises(ActuatorFault, match="re-arm"):
        rig.actuator.command(0.5)
    rig.clock.sleep(2.0)
    assert rig.far_end.angle() < 0.5
    assert rig.state.healthy
    rig.actuator.rearm()
    rig.actuator.command(0.8)
    rig.settle(within=3.0)
    assert rig.far_end.angle() == pytest.approx(0.8, abs=rig.tolerance)


@pytest.mark.on_device
def test_a_goal_outside_the_limits_is_refused_and_nothing_moves(rig: Rig) -> None:
    here = rig.far_end.angle()
    for goal in (math.nan, math.inf, -math.inf, UPPER + 0.01, LOWER - 0.01):
        with pytest.raises(LimitError, match=r"^goal: expected -?[\d.]+ to [\d.]+ deg, got "):
            rig.actuator.command(goal)
        rig.clock.sleep(0.5)
        assert rig.far_end.angle() == pytest.approx(here, abs=rig.tolerance / 2)
        assert rig.state.settled


@pytest.mark.on_device
def test_a_rate_that_is_not_one_is_refused(rig: Rig) -> None:
    for rate in (0.0, -1.0, math.nan, math.inf, 5e-324, 9e-7):
        with pytest.raises(LimitError, match="rate"):
            rig.actuator.command(1.0, rate)


def test_a_slower_rate_is_obeyed_and_a_faster_one_is_capped(rig: Rig) -> None:
    for rate, cap in ((0.3, 0.3), (99.0, rig.speed)):
        goal = rig.upper if rate > 1 else 0.5
        rig.actuator.command(goal, rate)
        fastest = 0.0
        while not rig.state.settled:
            rig.clock.sleep(QUANTUM)
            fastest = max(fastest, abs(rig.state.rate))
        assert fastest <= cap * (1 + 1e-6) + rig.ripple
        assert fastest > min(cap, math.sqrt(ACCELERATION * 0.3)) * 0.99


def test_it_reports_how_old_its_feedback_is(rig: Rig) -> None:
    rig.actuator.command(2.0)
    for _ in range(100):
        rig.clock.sleep(QUANTUM)
        assert LOWER <= rig.state.angle <= UPPER
        assert rig.clock.now() - rig.state.time <= 0.021
        assert rig.state.healthy


@pytest.mark.on_device
def test_it_is_never_settled_on_stale_feedback_and_the_guard_says_so(rig: Rig) -> None:
    rig.actuator.command(1.0)
    rig.clock.sleep(0.4)
    rig.wire.cut = True
    for _ in range(300):
        rig.clock.sleep(QUANTUM)
        assert not rig.state.settled
    assert not rig.state.healthy
    assert rig.state.fault
    with pytest.raises(ActuatorFault, match="re-arm"):
        rig.actuator.command(0.0)
    with pytest.raises(ActuatorFault, match="still at fault"):
        rig.actuator.rearm()


def test_after_the_wire_is_mended_homing_and_rearming_make_it_move_again(rig: Rig) -> None:
    rig.actuator.command(1.0)
    rig.clock.sleep(0.4)
    rig.wire.cut = True
    rig.clock.sleep(2.0)
    rig.wire.cut = False
    rig.home()
    rig.actuator.rearm()
    start, here = rig.state.angle, rig.far_end.angle()
    rig.actuator.command(start - 0.4)
    rig.settle(within=3.0)
    assert rig.far_end.angle() - here == pytest.approx(-0.4, abs=0.01)


def test_closing_in_the_middle_of_a_move_decelerates(rig: Rig) -> None:
    rig.actuator.command(rig.upper)
    rig.clock.sleep(1.0)
    speed, here = rig.state.rate, rig.far_end.angle()
    rig.actuator.__exit__(None, None, None)
    rig.actuator.__exit__(None, None, None)
    rig.clock.sleep(3.0)
    assert speed**2 / (2 * ACCELERATION) * 0.9 < rig.far_end.angle() - here < rig.upper - here - 0.5
    assert rig.far_end.complaints() == []


def test_closing_decelerates_also_when_a_periodic_call_of_somebody_else_has_failed(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    rig.actuator.command(rig.upper)
    rig.clock.sleep(1.0)
    speed, here, sleep = rig.state.rate, rig.far_end.angle(), rig.clock.sleep

    def sleep_and_raise(duration: float) -> None:
        sleep(duration)
        raise RuntimeError("a periodic call failed")

    monkeypatch.setattr(rig.clock, "sleep", sleep_and_raise)
    rig.actuator.__exit__(None, None, None)
    monkeypatch.undo()
    rig.clock.sleep(3.0)
    assert speed**2 / (2 * ACCELERATION) * 0.9 < rig.far_end.angle() - here < rig.upper - here - 0.5
    assert rig.far_end.complaints() == []


def test_closing_ends_also_when_time_stands_still(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    """As in a simulation in which a periodic call has failed: its clock does not move on."""
    rig.actuator.command(rig.upper)
    rig.clock.sleep(1.0)
    waited = []

    def raise_at_once(duration: float) -> None:
        waited.append(duration)
        assert len(waited) < 10, "it waits for ever"
        raise RuntimeError("a periodic call failed")

    monkeypatch.setattr(rig.clock, "sleep", raise_at_once)
    with suppress(RuntimeError):
        rig.actuator.__exit__(None, None, None)
    monkeypatch.undo()
    rig.actuator.__exit__(None, None, None)  # it is closed


@pytest.mark.on_device
def test_it_can_be_opened_again_and_still_knows_where_it_is(rig: Rig) -> None:
    rig.actuator.command(0.7)
    rig.settle(within=3.0)
    rig.actuator.__exit__(None, None, None)
    rig.clock.sleep(1.0)
    rig.open()
    assert rig.state.angle == pytest.approx(0.7, abs=rig.tolerance)
    rig.actuator.command(-0.2)
    rig.settle(within=3.0)
    assert rig.far_end.angle() == pytest.approx(-0.2, abs=rig.tolerance)


def test_a_move_that_takes_too_long_is_a_fault(kind: str) -> None:
    rig = rig_of(kind, max_move_s=4).open()  # enough to home
    rig.actuator.command(1.0, rate=0.1)
    rig.clock.sleep(5.0)
    assert "after 4 s" in rig.state.fault
    assert not rig.state.settled
    assert rig.far_end.angle() < 0.9


def test_limits_that_exclude_the_travel_cannot_be_opened() -> None:
    with pytest.raises(ConfigError, match="expected limits that meet"):
        open_far = {"kind": "ideal", "options": {"lower_deg": -10, "upper_deg": 10}}
        config = Config.model_validate({"actuator": open_far, "guard": {"lower_deg": 20, "park_deg": 30}})
        open_actuator(config, Services(SimClock(), lambda url: pytest.fail("opened")))


def test_the_guard_s_caps_reach_the_back_end(kind: str) -> None:
    rig = rig_of(kind, max_speed_deg_s=20, max_acceleration_deg_s2=40).open()
    assert math.degrees(rig.actuator.capabilities.max_acceleration) == pytest.approx(40)
    rig.actuator.command(math.radians(60))
    before = fastest = steepest = 0.0
    while not rig.state.settled:
        rig.clock.sleep(QUANTUM)
        fastest, steepest = max(fastest, rig.state.rate), max(steepest, abs(rig.state.rate - before))
        before = rig.state.rate
    assert math.degrees(fastest) == pytest.approx(20, abs=2e-5 + math.degrees(rig.ripple))
    assert math.degrees(steepest) <= 40 * QUANTUM * 1.001 + math.degrees(rig.ripple)
