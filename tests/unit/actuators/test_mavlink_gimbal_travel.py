"""A gimbal that others turn: which of several turns it has made, and where its travel ends."""

import math

import pytest

from gimbal_rig import Bench, after_a_task
from ross_payload.errors import ActuatorFault


@pytest.fixture
def rig():
    return Bench("client")


@pytest.fixture
def released(rig):
    return after_a_task(rig)


def unseen_turn(rig, to):
    """A pilot turns the idle gimbal from 170 deg through 0 to another angle, and nobody hears of it."""
    rig.clock.sleep(3.0)
    rig.point(-170.0)
    rig.clock.sleep(5.0)
    rig.device.mute = True
    rig.clock.sleep(1.0)
    for yaw in (0.0, -to):
        rig.point(yaw)
        rig.clock.sleep(5.0)
    rig.device.mute = False
    rig.clock.sleep(2.0)


def test_a_turn_that_nobody_has_seen_is_told_by_where_the_gimbal_can_be(released):
    unseen_turn(released, to=-100.0)
    assert math.degrees(released.state.angle) == pytest.approx(-100, abs=1.0)
    released.actuator.command(0.0)
    released.settle()
    assert released.device.bumps == 0


def test_where_two_turns_are_possible_nothing_moves_before_somebody_says_which(released):
    unseen_turn(released, to=-170.0)
    assert "may have turned round" in released.state.fault
    with pytest.raises(ActuatorFault, match="may have turned round"):
        released.actuator.command(0.0)
    released.point(100.0)
    released.clock.sleep(5.0)
    assert released.state.healthy
    assert math.degrees(released.state.angle) == pytest.approx(-100, abs=1.0)


def test_who_homes_says_that_the_gimbal_has_not_turned_round(released):
    released.clock.sleep(3.0)
    released.point(-170.0)
    released.clock.sleep(5.0)
    released.device.mute = True
    released.clock.sleep(10.0)
    released.device.mute = False
    released.clock.sleep(1.0)
    assert "may have turned round" in released.state.fault
    released.actuator.home()
    released.clock.sleep(2.0)
    assert released.state.healthy
    assert math.degrees(released.state.angle) == pytest.approx(170, abs=1.0)


@pytest.mark.parametrize("yaw_deg", [-100.0, 150.0])
def test_a_gimbal_that_others_have_left_beyond_our_travel_is_held_there_and_fetched_at_our_speed(yaw_deg):
    rig = Bench("client", options={"lower_deg": -60.0, "upper_deg": 60.0})
    rig.point(yaw_deg)
    rig.clock.sleep(5.0)
    rig.actuator.take_control()
    rig.clock.sleep(1.0)
    assert rig.true_deg == pytest.approx(yaw_deg, abs=0.1)
    rig.actuator.command(0.2)
    fastest = 0.0
    while not rig.state.settled:
        before = rig.far_end.angle()
        rig.clock.sleep(0.01)
        fastest = max(fastest, abs(rig.far_end.angle() - before) / 0.01)
        assert rig.state.healthy, rig.state
    assert rig.far_end.angle() == pytest.approx(0.2, abs=math.radians(0.1))
    assert fastest < 1.05 * rig.actuator.capabilities.max_speed


def test_a_stop_of_a_turn_towards_the_end_of_the_travel_sends_nothing_beyond_it(rig):
    rig.actuator.release_control()
    rig.clock.sleep(3.0)
    rig.point(-120.0)
    rig.clock.sleep(5.0)
    rig.point(-200.0)
    while math.degrees(rig.state.angle) < 150.0:
        rig.clock.sleep(0.01)
    yaws, send = [], rig.far_end.port.send

    def noted(message):
        if "PITCHYAW" in message.get_type():
            yaws.append(-math.degrees(message.yaw))
        send(message)

    rig.far_end.port.send = noted
    rig.actuator.stop()
    rig.clock.sleep(3.0)
    assert yaws
    assert all(150 < yaw % 360 <= 200.01 for yaw in yaws)
