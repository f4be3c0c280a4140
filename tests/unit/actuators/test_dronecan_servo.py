"""The driver of a DroneCAN servo on a simulated one: faults of the servo and of the bus, calibration, models."""

import math
import random
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from can_servo_bench import Rig
from ross_payload.actuators.dronecan_servo.options import Options
from ross_payload.errors import ConfigError, NotHomed
from ross_protocols.dronecan.messages import ArrayCommand, Mode, NodeStatus
from ross_sim.clock import QUANTUM
from ross_sim.devices.dronecan_far_end import ServoFarEnd, ServoNode, far_end


def test_nothing_is_commanded_before_the_first_goal():
    rig = Rig()
    rig.clock.sleep(2.0)
    assert rig.values() == []
    assert [type(message) for _, message in rig.heard] == [NodeStatus] * 3


def test_set_points_leave_at_50_hz_while_a_goal_is_held():
    rig = Rig()
    rig.go(30, 4.0)
    times = [time for time, message in rig.heard if isinstance(message, ArrayCommand)]
    assert {round(after - before, 6) for before, after in pairwise(times)} == {0.02}
    assert times[-1] > rig.clock.now() - 0.03


def test_set_points_follow_the_trapezoid():
    rig = Rig()
    rig.go(100, 3.0)
    joints = [math.degrees(rig.options.joint_of(value)) for value in rig.values()]
    speeds = [(after - before) / 0.02 for before, after in pairwise(joints)]
    coarse = 0.1 / 0.02  # of a float16 [deg/s]
    assert max(speeds) == pytest.approx(math.sqrt(112.5 * 100), abs=coarse)
    assert max(abs(b - a) for a, b in pairwise(speeds)) <= 112.5 * 0.02 + 2 * coarse


def test_set_points_lead_by_the_lag_of_the_servo():
    def joint(lag_ms):
        rig = Rig(lag_ms=lag_ms)
        rig.go(150, 1.0)
        return math.degrees(rig.options.joint_of(rig.values()[-1]))

    assert joint(40) - joint(0) == pytest.approx(112.5 * 0.040 * 1.03, abs=0.3)  # at 112.5 deg/s, and faster


@pytest.mark.parametrize("lag_ms", [0, 20, 100])
def test_whatever_the_lead_the_servo_reaches_its_goal_and_never_passes_it(lag_ms):
    rig = Rig(lag_ms=lag_ms)
    farthest = 0.0
    rig.go(60)
    for _ in range(250):
        rig.clock.sleep(QUANTUM)
        farthest = max(farthest, rig.true_deg)
    assert rig.state.settled
    assert farthest == pytest.approx(60, abs=0.1)  # a count of its encoder


@pytest.mark.parametrize(
    ("options", "lowest", "highest"),
    [
        ({"command": "unitless"}, -0.5, 0.5),
        ({"command": "unitless", "at_lower": 0.8, "at_upper": -0.8}, 0.4, -0.4),
        ({"command": "pwm"}, 1250, 1750),
        ({"command": "position"}, -math.pi / 4, math.pi / 4),
        ({"command": "position", "gear_ratio": -2.0, "zero_position_deg": 10}, math.radians(100), math.radians(-80)),
    ],
)
def test_two_points_or_the_gear_make_commands_of_joint_angles(options, lowest, highest):
    rig = Rig(lower_deg=-90, upper_deg=90, **options)
    for goal, value in ((-45, lowest), (45, highest)):
        rig.go(goal, 3.0)
        assert rig.values()[-1] == pytest.approx(value, rel=1e-3)
        assert rig.state.settled
        assert rig.true_deg == pytest.approx(goal, abs=math.degrees(rig.options.resolution))


def test_a_gear_turns_the_servo_more_than_the_array():
    rig = Rig(gear_ratio=3.0)
    rig.go(30, 3.0)
    assert math.degrees(rig.node.shaft.angle) == pytest.approx(90, abs=0.75)
    assert rig.true_deg == pytest.approx(30, abs=0.25)


def test_a_servo_without_position_says_what_to_configure():
    rig = Rig()
    rig.node._options = replace_feedback(rig.options)
    rig.clock.sleep(0.1)
    assert "feedback = 'model'" in rig.state.fault


def replace_feedback(options):
    return options.model_copy(update={"feedback": "model"})


class TestWithoutPosition:
    def rig(self):
        return Rig(feedback="model")

    def test_it_is_flagged_and_must_be_homed(self):
        rig = self.rig()
        assert rig.actuator.capabilities.feedback == "model"
        with pytest.raises(NotHomed):
            rig.go(10)

    def test_it_is_known_after_homing_and_reaches_its_goals(self):
        rig = self.rig()
        rig.node.shaft.angle = 0.7
        rig.actuator.home()
        rig.clock.sleep(3.0)
        assert rig.true_deg == pytest.approx(0, abs=0.25)
        rig.go(60, 3.0)
        assert rig.state.settled
        assert rig.true_deg == pytest.approx(60, abs=0.25)

    def test_homing_from_a_known_place_is_a_move_as_any_other(self):
        rig = self.rig()
        rig.actuator.home()
        rig.clock.sleep(3.0)
        rig.go(150, 4.0)
        rig.actuator.home()
        angles = []
        while not (rig.state.homed and rig.state.settled):
            rig.clock.sleep(0.1)
            angles.append(rig.true_deg)
        speeds = np.diff(angles) / 0.1
        assert np.abs(np.diff(speeds)).max() / 0.1 < 1.5 * 112.5
        assert rig.true_deg == pytest.approx(0, abs=0.25)

    def test_released_it_is_not_known_any_more(self):
        rig = self.rig()
        rig.actuator.home()
        rig.clock.sleep(3.0)
        rig.actuator.release()
        rig.clock.sleep(0.1)
        assert not rig.state.homed


def test_release_sends_no_more_set_points():
    rig = Rig()
    rig.go(20, 2.0)
    rig.actuator.release()
    rig.clock.sleep(0.1)
    before = len(rig.values())
    rig.clock.sleep(1.0)
    assert len(rig.values()) == before


def test_a_program_that_dies_leaves_a_servo_that_stops_within_its_lag():
    rig = Rig()
    rig.go(180, 0.8)
    last = math.degrees(rig.options.joint_of(rig.values()[-1]))
    rig.passes = lambda frame: False
    rig.clock.sleep(2.0)
    assert abs(rig.true_deg - last) < 2.5  # one set-point at 90 deg/s, and friction
    assert rig.node.shaft.rate == 0.0


def test_it_says_that_it_leaves():
    rig = Rig()
    rig.actuator.__exit__(None, None, None)
    rig.clock.sleep(QUANTUM)
    assert rig.heard[-1][1].mode is Mode.OFFLINE


def test_two_runs_are_the_same_to_the_last_bit():
    def run():
        rig = Rig()
        rig.go(77, 1.0)
        rig.go(-30, 3.0)
        return rig.heard, rig.far_end.angle()

    assert run() == run()


@pytest.mark.parametrize("seed", range(5))
def test_lost_frames_on_the_bus_delay_nothing_and_harm_nothing(seed):
    chance = random.Random(seed)  # noqa: S311
    rig = Rig()
    rig.passes = lambda frame: chance.random() > 0.2
    rig.go(90, 3.5)
    assert rig.state.settled
    assert rig.true_deg == pytest.approx(90, abs=0.25)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"node_id": 121}, "both 121"),
        ({"node_id": 128}, "less than or equal to 127"),
        ({"lower_deg": 10, "upper_deg": 10}, "expected lower_deg below upper_deg, got 10 and 10"),
        ({"gear_ratio": 0.0}, "too near to 0"),
        ({"gear_ratio": math.nan}, "gear_ratio"),
        ({"command": "position", "at_lower": 0.5}, "follow from gear_ratio"),
        ({"at_lower": -1.5}, "from -1 to 1"),
        ({"at_lower": 0.5, "at_upper": 0.5}, "two different values"),
        ({"command": "pwm", "at_upper": 1.0}, "from 500 to 2500"),
        ({"port": "serial:/dev/ttyS0"}, "port"),
        ({"baud": 3}, "baud"),
    ],
)
def test_a_wrong_option_is_one_clear_line(wrong, words):
    with pytest.raises(ConfigError, match=words) as error:
        Rig(**wrong)
    assert "\n" not in str(error.value)


def test_a_slow_servo_lags_but_is_waited_for():
    options = Options()
    slow = replace(far_end.make(options).node.shaft.drive, position_gain=8.0)
    rig = Rig(drive=slow)
    rig.go(60, 1.4)
    assert not rig.state.settled
    rig.clock.sleep(2.0)
    assert rig.state.settled
    assert isinstance(rig.far_end, ServoFarEnd)
    assert isinstance(rig.node, ServoNode)
