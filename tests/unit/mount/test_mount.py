"""Where the base points, as an autopilot tells it over the links; the wire is real, the far end simulated."""

import math

import numpy as np
import pytest

from mount_bench import SWINGING, Drone, report
from ross_payload.config import Config
from ross_payload.errors import ConfigError
from ross_payload.mavlink import Router
from ross_payload.mount import MOST, AttitudeHistory, FixedMount, mount_of
from ross_payload.timebase import Timebase
from ross_protocols.mavlink import vehicle
from ross_protocols.mavlink.codec import Encoder
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.vehicle import VehicleAttitude
from ross_sim.clock import SimClock

# ------------------------------------------------------------------------------------------------ the wire


def test_yaw_is_clockwise_on_the_wire_and_counter_clockwise_inside():
    message = common.MAVLink_attitude_message(1500, 0.1, 0.2, math.radians(90), 0.0, 0.0, 0.5)
    said = vehicle.read(message)
    assert (said.boot, said.roll, said.pitch) == (1.5, 0.1, 0.2)
    assert said.yaw == pytest.approx(-math.pi / 2)
    level = vehicle.read(common.MAVLink_attitude_message(0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5))
    assert level.yaw_rate == -0.5


def test_the_quaternion_of_a_vehicle_that_points_east_is_read_as_minus_ninety_degrees():
    half = math.sqrt(0.5)
    fields = (0, 0, 2_000_000, (half, 0.0, 0.0, half), 0, 0.0, 0.0, 0.0, 0, math.nan, 0, 0)
    said = vehicle.read(common.MAVLink_autopilot_state_for_gimbal_device_message(*fields, angular_velocity_z=0.25))
    assert said.yaw == pytest.approx(-math.pi / 2)
    assert (said.boot, said.yaw_rate) == (2.0, -0.25)


def test_the_wanted_rate_serves_where_the_measured_one_is_missing():
    fields = (0, 0, 0, (1.0, 0.0, 0.0, 0.0), 0, 0.0, 0.0, 0.0, 0, 0.3, 0, 0)
    assert vehicle.read(common.MAVLink_autopilot_state_for_gimbal_device_message(*fields)).yaw_rate == -0.3


@pytest.mark.parametrize("yaw", [math.nan, math.inf])
def test_numbers_that_cannot_be_meant_are_not_read(yaw):
    assert vehicle.read(common.MAVLink_attitude_message(0, 0.0, 0.0, yaw, 0.0, 0.0, 0.0)) is None


def test_a_quaternion_of_zeros_is_not_read():
    fields = (0, 0, 0, (0.0,) * 4, 0, 0.0, 0.0, 0.0, 0, 0.0, 0, 0)
    assert vehicle.read(common.MAVLink_autopilot_state_for_gimbal_device_message(*fields)) is None


def test_a_vehicle_on_its_tail_has_no_yaw():
    assert vehicle.read(common.MAVLink_attitude_message(0, 0.0, math.radians(89), 1.0, 0.0, 0.0, 0.0)) is None


def test_what_is_written_is_read_again():
    level = VehicleAttitude(3.0, 0.7, 0.0, 0.0, -0.2)
    for message in (vehicle.attitude(level), vehicle.gimbal_state(level)):
        said = vehicle.read(message)
        np.testing.assert_allclose([said.yaw, said.yaw_rate, said.boot], [0.7, -0.2, 3.0], atol=1e-9)


# ------------------------------------------------------------------------------------------------ history


def test_between_two_reports_the_yaw_is_interpolated_over_the_south():
    history = AttitudeHistory(fresh=0.5)
    history.note(1.0, report(0.0, math.pi - 0.1))
    history.note(1.2, report(0.0, -math.pi + 0.1))
    assert abs(history.at(1.1).yaw) == pytest.approx(math.pi)
    assert history.at(1.05).yaw == pytest.approx(math.pi - 0.05)


def test_ahead_of_the_newest_report_its_rate_is_trusted_for_a_moment_only():
    history = AttitudeHistory(fresh=0.5)
    history.note(1.0, report(0.0, 0.0, rate=1.0))
    ahead = [history.at(time) for time in (1.05, 1.1, 1.4)]
    np.testing.assert_allclose([one.yaw for one in ahead], [0.05, 0.1, 0.1])
    assert [one.known for one in ahead] == [True] * 3
    assert ahead[0].sigma < ahead[1].sigma < ahead[2].sigma


def test_what_is_not_fresh_is_not_known_and_in_the_frame_of_the_mount():
    history = AttitudeHistory(fresh=0.5)
    assert not history.at(0.0).known
    history.note(1.0, report(0.0, 2.0))
    stale = history.at(1.6)
    assert (stale.known, stale.yaw) == (False, 0.0)
    assert stale.age == pytest.approx(0.6)
    assert not history.at(0.9).known  # nobody knows where it pointed before the first report


def test_a_gap_is_not_bridged_afterwards():
    history = AttitudeHistory(fresh=0.5)
    history.note(1.0, report(0.0, 0.0))
    history.note(3.0, report(0.0, 1.0))
    assert history.at(1.3).yaw == 0.0
    assert not history.at(2.0).known


def test_a_report_from_the_past_changes_nothing():
    history = AttitudeHistory(fresh=0.5)
    history.note(1.0, report(0.0, 0.5))
    history.note(0.8, report(0.0, 3.0))
    assert history.at(1.0).yaw == 0.5


def test_the_history_is_bounded_and_a_minute_long():
    history = AttitudeHistory(fresh=0.5)
    for index in range(3 * MOST):
        history.note(index * 0.02, report(0.0, 0.001 * (index % 100)))
    end = 3 * MOST * 0.02
    assert history.at(end - 60.0).known
    assert not history.at(1.0).known


# ------------------------------------------------------------------------------------------------ over the links


def test_audio_that_is_read_late_gets_the_yaw_of_its_capture():
    """At 10 deg/s an arrival 60 ms late would be 0.6 degrees."""
    drone = Drone()
    drone.clock.sleep(3.0)
    errors = []
    for _ in range(600):
        drone.clock.sleep(0.01)
        errors.append(drone.error(late=0.15))
    assert np.rad2deg(max(errors)) < 0.3
    assert np.rad2deg(np.sqrt(np.mean(np.square(errors)))) < 0.1


def test_audio_that_is_read_at_once_gets_a_yaw_that_is_extrapolated():
    drone = Drone()
    drone.clock.sleep(3.0)
    errors = []
    for _ in range(600):
        drone.clock.sleep(0.01)
        errors.append(drone.error(late=0.0))
    assert np.rad2deg(max(errors)) < 2.5  # where the vehicle reverses: nobody can know that before it is told
    assert np.rad2deg(np.sqrt(np.mean(np.square(errors)))) < 0.5


def test_an_autopilot_that_says_it_seldom_is_asked_for_more():
    drone = Drone(attitude=1.0)
    drone.clock.sleep(4.0)
    ages = []
    for _ in range(100):
        drone.clock.sleep(0.01)
        ages.append(drone.mount.attitude(drone.clock.now()).age)
    assert max(ages) < 0.04 + 0.06 + 0.02  # one period, the wire, a poll


def test_an_autopilot_that_says_it_often_enough_is_left_alone():
    drone = Drone(attitude=0.02)
    heard = []
    drone.links.component(191).tap(heard.append)
    drone.clock.sleep(5.0)
    asked = [frame for frame in heard if frame[7:10] == (76).to_bytes(3, "little")]
    assert len(asked) <= 1  # before anything has come


def test_silence_is_noticed_and_the_return_too():
    drone = Drone(silent=((4.0, 6.0),))
    known = {}
    for _ in range(800):
        drone.clock.sleep(0.01)
        known[round(drone.clock.now(), 2)] = drone.mount.attitude(drone.clock.now()).known
    assert known[3.9]
    assert known[4.4]
    assert not known[4.7]
    assert not known[5.9]
    assert known[6.2]


def test_an_attitude_from_the_ground_or_another_vehicle_is_not_believed():
    for changes in ({"role": "ground"}, {"system_id": 7}):
        if changes.get("role") == "ground":
            with pytest.raises(ConfigError, match=r'expected a .*role = "autopilot", got none'):
                Drone(**changes)
            continue
        drone = Drone(**changes)
        drone.clock.sleep(3.0)
        assert not drone.mount.attitude(drone.clock.now()).known


def test_the_first_autopilot_counts_where_no_system_id_is_configured():
    config = Config.model_validate({"mount": {"source": "autopilot"}, "telemetry": {"system_id": 0}})
    drone = Drone(system_id=7, config=config)
    drone.clock.sleep(3.0)
    assert drone.mount.attitude(drone.clock.now()).known
    assert drone.links.system_id == 7


def test_another_component_of_the_vehicle_is_not_the_autopilot():
    drone = Drone(silent=((0.0, 100.0),))
    gimbal = Encoder(1, 154)
    for _ in range(50):
        drone.other.send(gimbal.encode(vehicle.attitude(report(drone.clock.now(), 1.0))))
        drone.clock.sleep(0.02)
    assert not drone.mount.attitude(drone.clock.now()).known


def test_the_gimbals_feed_serves_as_well():
    drone = Drone(silent=((0.0, 100.0),))
    autopilot = Encoder(1, 1)
    for _ in range(50):
        now = drone.clock.now()
        said = VehicleAttitude(100.0 + now, SWINGING.at(now), 0.0, 0.0, SWINGING.rate(now))
        drone.other.send(autopilot.encode(vehicle.gimbal_state(said)))
        drone.clock.sleep(0.02)
    assert drone.error(late=0.1) < math.radians(1)


def test_a_fixed_mount_needs_no_link():
    clock = SimClock()
    links = Router.open((), clock)
    assert mount_of(Config(), clock, links, Timebase(clock)) == FixedMount(None)
    east = mount_of(Config.model_validate({"mount": {"yaw_deg": 90}}), clock, links, Timebase(clock))
    assert east.attitude(5.0).yaw == pytest.approx(-math.pi / 2)
