"""What a gimbal's reports prove: order, restarts, two devices under one name, delays, jumps."""

import copy
import math

import numpy as np
import pytest

from rigs import rig_of
from ross_payload.actuators.mavlink_gimbal.diagnostics import contradiction, silence
from ross_payload.actuators.mavlink_gimbal.feedback import GimbalFeedback
from ross_payload.actuators.mavlink_gimbal.sender_clock import SenderClock, Verdict
from ross_payload.errors import ActuatorFault
from ross_protocols.mavlink.gimbal_messages import GimbalAttitude
from ross_sim.devices.far_end import Fault

PERIOD = 0.02  # between two reports [s]


def verdicts(reports):
    """What a clock makes of (boot, arrival) pairs."""
    clock = SenderClock()
    return [clock.judge(boot, now) for boot, now in reports]


def stream(begin, now, seconds, period=PERIOD):
    """Reports of one device: (boot, arrival)."""
    return [(begin + n * period, now + n * period) for n in range(round(seconds / period))]


def on_report(feedback, boot, yaw, now, *, own=True):
    feedback.on_report(GimbalAttitude(boot, yaw, 0.0, False, 0, 0), now, own=own)


@pytest.fixture
def feedback():
    return GimbalFeedback(-3.0, 3.0, max_speed=1.5)


def test_the_same_report_by_two_ways_is_news_once():
    found = verdicts([(boot, now + late) for boot, now in stream(10.0, 0.0, 1.0) for late in (0.0, 0.001)])
    assert found == [Verdict.NEWS, Verdict.OLD] * 50


def test_a_restart_is_believed_with_its_second_report():
    found = verdicts([*stream(50.0, 0.0, 1.0), *stream(0.0, 1.5, 0.1)])
    assert found[50:] == [Verdict.OLD, Verdict.RESTARTED, Verdict.NEWS, Verdict.NEWS, Verdict.NEWS]


@pytest.mark.parametrize("other", [10.0, 300.0])
@pytest.mark.parametrize("period", [0.02, 0.1])
def test_two_devices_with_one_name_are_told_within_half_a_second_and_never_a_restart(other, period):
    alone = stream(100.0, 0.0, 1.0)
    both = sorted([*stream(101.0, 1.0, 1.0), *stream(other, 1.005, 1.0, period)], key=lambda one: one[1])
    found = verdicts([*alone, *both])
    arrivals = [now for _, now in [*alone, *both]]
    assert arrivals[found.index(Verdict.TWO)] < 1.5
    assert Verdict.RESTARTED not in found
    believed = [boot for (boot, _), verdict in zip([*alone, *both], found, strict=True) if verdict is Verdict.NEWS]
    assert all(100.0 <= boot < 103.0 for boot in believed)


def test_one_report_of_another_time_is_no_device():
    found = verdicts([*stream(100.0, 0.0, 1.0), (5.0, 1.0), *stream(101.0, 1.01, 1.0)])
    assert set(found) == {Verdict.NEWS, Verdict.OLD}


def test_late_reports_count_from_when_they_were_made(feedback):
    for n in range(50):
        on_report(feedback, 10.0 + n * PERIOD, 0.0, n * PERIOD)
    on_report(feedback, 11.0, 0.1, 1.7)
    assert feedback.time == pytest.approx(1.0, abs=0.005)
    assert silence(feedback, 1.7) == "the gimbal's reports come 0.7 s late: the link is overloaded"
    assert silence(feedback, 2.5) == "no attitude received from the gimbal for more than 0.45 s"


SILENT = {"gimbal": "no attitude received from the gimbal", "autopilot": "no data from the autopilot"}


@pytest.mark.parametrize(
    ("manager", "who"), [(None, "gimbal"), (2.3, "gimbal"), (1.99, "autopilot"), (0.9, "autopilot")]
)
def test_silence_is_judged_by_arrival_and_lateness_by_the_stamp(feedback, manager, who):
    """A report is stamped a few milliseconds before it arrives, so silence seems longer than it is."""
    for n in range(100):
        on_report(feedback, 10.0 + n * PERIOD - (0.003, 0.001)[n % 2], 0.0, n * PERIOD)
    assert silence(feedback, 2.428, manager) == ""
    for now in (2.431, 2.433, 2.6, 4.0):
        assert silence(feedback, now, manager).startswith(SILENT[who])


def test_clocks_that_drift_apart_make_no_report_late(feedback):
    for n in range(20_000):
        on_report(feedback, 10.0 + n * PERIOD * (1 - 100e-6), 0.0, n * PERIOD)
    assert feedback.time == pytest.approx(20_000 * PERIOD, abs=0.05)


@pytest.mark.parametrize("kind", ["mavlink_gimbal", "mavlink_gimbal:manager", "vehicle_yaw"])
def test_a_clock_that_has_stood_still_is_believed_again_after_homing(kind):
    """As that of ArduPilot's simulator, which never makes up for a time in which its computer stood still."""
    rig = rig_of(kind).open()
    rig.clock.PORTION = 0
    rig.actuator.command(0.5)
    rig.clock.stand_still(0.8)
    rig.clock.sleep(3.0)
    with pytest.raises(ActuatorFault, match=r"0\.8 s late: the link is overloaded"):
        rig.actuator.rearm()
    rig.home()
    rig.actuator.rearm()
    rig.actuator.command(0.9)
    rig.settle(within=4.0)
    assert rig.far_end.angle() == pytest.approx(0.9, abs=rig.tolerance)


def test_a_trembling_sensor_is_told_and_a_single_jump_is_not(feedback):
    on_report(feedback, 1.0, 0.0, 0.0)
    on_report(feedback, 1.02, 0.5, 0.02)  # pushed
    for n in range(2, 100):
        on_report(feedback, 1.0 + n * PERIOD, 0.5, n * PERIOD)
        assert contradiction(feedback) == ""
    chance, n = np.random.default_rng(0), 100
    while not contradiction(feedback):
        on_report(feedback, 1.0 + n * PERIOD, 0.5 + chance.normal(0.0, math.radians(3)), n * PERIOD)
        n += 1
    assert n < 150
    assert "jumps" in contradiction(feedback)
    feedback.clear_doubts()
    assert contradiction(feedback) == ""


def test_two_gimbals_switched_on_together_are_told_by_their_angles(feedback):
    for n in range(50):
        on_report(feedback, 1.0 + n * PERIOD, 0.0, n * PERIOD)
        on_report(feedback, 1.0 + n * PERIOD + 0.01, 1.0, n * PERIOD + 0.01)
    assert "two gimbals with the same id" in contradiction(feedback)


def test_a_fast_gimbal_whose_reports_are_lost_now_and_then_does_not_jump(feedback):
    for n in range(0, 200, 5):
        on_report(feedback, 1.0 + n * PERIOD, 1.5 * math.sin(n * PERIOD), n * PERIOD)
        assert contradiction(feedback) == ""


def test_what_a_manager_repeats_is_believed_when_the_device_has_been_silent_for_two_seconds(feedback):
    on_report(feedback, 1.0, 0.3, 0.0)
    on_report(feedback, 70.0, 0.9, 1.9, own=False)
    assert feedback.angle == pytest.approx(0.3)
    on_report(feedback, 70.2, 0.9, 2.1, own=False)
    assert feedback.angle == pytest.approx(0.9)


@pytest.mark.parametrize(
    ("rests", "seen", "unseen"),
    [
        (3.49, 3.49, True),
        (3.4907 + 0.001, 3.4907 + 0.001, True),
        (3.55, 3.55, True),
        (1.0, 1.0, False),
        (2.7, 2.7, False),
    ],
)
def test_after_a_silence_a_gimbal_at_an_end_of_its_travel_is_in_doubt_and_not_elsewhere(rests, seen, unseen):
    """The travel is +-200 deg, 3.4907 rad: what seems to be a little beyond it is a whole turn from nothing."""
    feedback = GimbalFeedback(-3.4907, 3.4907, max_speed=1.5)
    for index in range(40):
        yaw = min(index * 0.1, rests)
        on_report(feedback, 10.0 + index * 0.1, math.remainder(yaw, math.tau), index * 0.1)
    on_report(feedback, 20.0, math.remainder(rests, math.tau), 10.0)
    assert feedback.angle == pytest.approx(seen)
    assert feedback.unseen is unseen


def test_a_gimbal_that_turns_farther_than_is_asked_for_is_believed_there():
    feedback = GimbalFeedback(-3.4907, 3.4907, max_speed=1.5)
    feedback.reach(-4.0, 4.0)
    for index in range(50):
        on_report(feedback, 10.0 + index * 0.1, math.remainder(min(index * 0.1, 3.9), math.tau), index * 0.1)
    assert feedback.angle == pytest.approx(3.9)
    assert not feedback.unseen


@pytest.mark.parametrize(
    ("kind", "pause"), [("mavlink_gimbal", 0.25), ("mavlink_gimbal", 1.0), ("mavlink_gimbal:manager", 0.4)]
)
def test_a_gimbal_that_restarts_in_a_move_while_the_payload_is_held_up_is_a_fault(kind, pause):
    rig = rig_of(kind).open()
    rig.actuator.command(2.0)
    rig.clock.sleep(0.8)
    rig.held_up = True
    rig.far_end.afflict(Fault.REBOOT)
    rig.clock.sleep(pause)
    rig.held_up = False
    rig.clock.sleep(0.5)
    assert "the gimbal has restarted in the middle of a move" in rig.state.fault
    here = rig.far_end.angle()
    rig.clock.sleep(3.0)
    assert rig.far_end.angle() == pytest.approx(here, abs=math.radians(1))


@pytest.mark.parametrize(
    ("told", "believed"), [(0.5, 0.5), (1.2, 1.2), (28.6, 0.5), (-28.6, 0.5), (1e30, 0.5), (None, 0.5), (0.0, 0.0)]
)
def test_a_rate_is_believed_that_is_not_much_faster_than_the_angles_change(told: float | None, believed: float) -> None:
    seen = GimbalFeedback(-2.0, 2.0, max_speed=math.radians(90))
    for n in range(10):
        seen.on_report(GimbalAttitude(n / 50, 0.5 * n / 50, told, False, 0, 0), n / 50, own=True)
    assert seen.rate == pytest.approx(believed)


def test_a_rate_that_nothing_confirms_is_at_most_what_a_gimbal_turns_with() -> None:
    seen = GimbalFeedback(-2.0, 2.0, max_speed=1.0)
    seen.on_report(GimbalAttitude(0.0, 0.0, 1e30, False, 0, 0), 0.0, own=True)
    assert seen.rate == 1.5


@pytest.mark.parametrize("told", [-1.0, -90.0])
def test_a_rate_against_the_way_of_the_angles_is_not_believed(told: float) -> None:
    seen = GimbalFeedback(-2.0, 2.0, max_speed=math.radians(90))
    for n in range(10):
        seen.on_report(GimbalAttitude(n / 50, 1.0 * n / 50, told, False, 0, 0), n / 50, own=True)
    assert seen.rate == pytest.approx(1.0)


@pytest.mark.parametrize(("period", "later"), [(0.02, 0.001), (0.02, 0.003), (0.1, 0.001)])
def test_a_rate_is_believed_also_where_two_reports_are_of_the_same_angle(period: float, later: float) -> None:
    """What samples its sensor less often than it reports has not stood still in between."""
    seen = GimbalFeedback(-2.0, 2.0, max_speed=math.radians(90))
    for n in range(20):
        for time in (n * period, n * period + later):
            seen.on_report(GimbalAttitude(time, 1.0 * n * period, 1.0, False, 0, 0), time, own=True)
            assert seen.rate == 1.0


def test_a_stop_is_no_fault_where_two_reports_are_of_the_same_angle() -> None:
    rig = rig_of("mavlink_gimbal").open()
    receive, count = rig.far_end.port.receive, 0

    def twice():
        nonlocal count
        for each in receive():
            yield each
            if each.packet.name == "GIMBAL_DEVICE_ATTITUDE_STATUS":
                count += 1
                if count % 20 == 0:
                    again = copy.deepcopy(each)
                    again.packet.message.time_boot_ms += 1
                    yield again

    rig.far_end.port.receive = lambda: list(twice())
    rig.actuator.command(rig.upper)
    rig.clock.sleep(1.2)
    rig.actuator.stop()
    rig.clock.sleep(3.0)
    assert rig.state.settled, rig.state.fault
    rig.actuator.__exit__(None, None, None)
