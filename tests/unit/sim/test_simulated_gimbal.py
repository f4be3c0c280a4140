"""The simulated gimbal: which turn of a set-point it takes, as gimbals with stops do, and how it follows a stream."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gimbal_bench import set_attitude
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.gimbal_messages import VEHICLE_FRAME
from ross_sim.devices.gimbal_device import Device, Servo


def point(device, angle, now):
    """Give it a set-point [rad]."""
    (packet,) = Decoder().feed(Encoder(1, 1).encode(set_attitude(-angle, flags=VEHICLE_FRAME)))
    device.on_packet(packet, now)


def brought(travel_deg, *angles_deg):
    """Where a device with stops at both ends of its travel goes, one set-point after the other [deg]."""
    end = math.radians(travel_deg)
    device = Device(ComponentId(1, 154), Servo(-end, end, 4.0, 8.0), lambda now: 0.0, earth=False)
    now = 0.0
    for angle in angles_deg:
        point(device, math.radians(angle), now)
        now += 4.0
        device.move(now)
    return math.degrees(device.angle)


@pytest.mark.parametrize(
    ("travel", "angles", "there"),
    [
        (200, (170, -170), 190),  # the nearest turn
        (175, (150, -170), -170),  # beyond a stop it is not; on the other side it is
        (200, (100, 190, 210), -150),
        (90, (80, -170), -90),  # none is: the stop that is nearer on the circle
        (90, (80, 120), 90),
    ],
)
def test_it_takes_the_nearest_turn_that_it_can_reach(travel, angles, there):
    assert brought(travel, *angles) == pytest.approx(there, abs=0.1)


@pytest.mark.parametrize("again", [1, 2, 4])
def test_a_set_point_that_comes_again_while_a_move_turns_back_or_rests_changes_no_rhythm(again):
    """The stream still comes every 20 ms; approached any slower, the device would have to catch up."""
    device = Device(ComponentId(1, 154), Servo(-3.0, 3.0, 4.0, 8.0), lambda now: 0.0, earth=False)
    braking = 2.0 * 0.02 * np.arange(-50, 0)  # rad/s, at 2 rad/s^2
    angles, now = [], 0.0
    for goal in 0.02 * np.cumsum([*braking[::-1], *braking, *[0.0] * again, *-braking[::-1]]):
        point(device, goal, now)
        now += 0.02
        device.move(now)
        angles.append(device.angle)
    steepest = np.abs(np.diff(angles[70:], 2)).max() / 0.02**2  # about where it turns back
    assert steepest < 1.5 * 2.0
