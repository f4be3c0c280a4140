"""How high the array is, as an autopilot tells it over the links; the wire is real, the far end simulated."""

import pytest

from mount_bench import Drone, report
from ross_payload.config import Config
from ross_payload.mavlink import Router
from ross_payload.mount import mount_of
from ross_payload.timebase import Timebase
from ross_protocols.mavlink import vehicle
from ross_protocols.mavlink.codec import Encoder
from ross_protocols.mavlink.dialect import common
from ross_sim.clock import SimClock

RISEN = Config.model_validate({"mount": {"source": "autopilot", "height_m": "autopilot"}})


def told(drone):
    """How high the array is above the mouths [m], as the mount says at this moment."""
    return drone.mount.attitude(drone.clock.now()).height


def test_the_height_above_home_is_read_in_metres_and_from_its_message_alone():
    fields = (0, 470000000, 80000000, 455000, 21600, 0, 0, 0, 9000)  # 455 m above the sea, 21.6 m above home
    assert vehicle.height_of(common.MAVLink_global_position_int_message(*fields)) == pytest.approx(21.6)
    assert vehicle.height_of(vehicle.attitude(report(0.0, 0.0))) is None


def test_the_height_is_asked_for_and_counts_from_the_mouths_of_those_who_stand():
    drone = Drone(config=RISEN, height=21.6)
    assert told(drone) is None
    drone.clock.sleep(4.0)
    assert told(drone) == pytest.approx(20.0)
    assert drone.mount.attitude(drone.clock.now()).known


def test_nobody_asks_for_a_height_that_is_not_wanted():
    drone = Drone(height=21.6)
    drone.clock.sleep(4.0)
    assert told(drone) is None
    autopilot = Encoder(1, 1)
    drone.other.send(autopilot.encode(common.MAVLink_global_position_int_message(0, 0, 0, 0, 21600, 0, 0, 0, 0)))
    drone.clock.sleep(0.5)
    assert told(drone) is None


def test_a_height_that_has_not_been_told_for_three_seconds_is_not_known():
    drone = Drone(config=RISEN, height=21.6, silent=((6.0, 12.0),))
    heights = {}
    for _ in range(1700):
        drone.clock.sleep(0.01)
        heights[round(drone.clock.now(), 2)] = told(drone)
    assert heights[8.0] == pytest.approx(20.0)
    assert heights[9.5] is None
    assert heights[16.0] == pytest.approx(20.0)


def test_a_height_from_another_vehicle_or_component_is_not_believed():
    drone = Drone(config=RISEN, silent=((0.0, 100.0),))
    for stranger in (Encoder(7, 1), Encoder(1, 154)):
        drone.other.send(stranger.encode(common.MAVLink_global_position_int_message(0, 0, 0, 0, 9000, 0, 0, 0, 0)))
        drone.clock.sleep(0.5)
    assert told(drone) is None


def test_a_configured_height_needs_no_message():
    drone = Drone(config=Config.model_validate({"mount": {"source": "autopilot", "height_m": 12}}))
    assert told(drone) == 12.0
    clock = SimClock()
    fixed = mount_of(Config.model_validate({"mount": {"height_m": 3}}), clock, Router.open((), clock), Timebase(clock))
    assert fixed.attitude(0.0).height == 3.0
