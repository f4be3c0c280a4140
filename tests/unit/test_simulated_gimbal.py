"""The simulated gimbal: which turn of a set-point it takes, as gimbals with stops do."""

from __future__ import annotations

import math

import pytest

from gimbal_bench import set_attitude
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.gimbal_messages import VEHICLE_FRAME
from ross_sim.devices.gimbal_device import Device, Servo


def brought(travel_deg, *angles_deg):
    """Where a device with stops at both ends of its travel goes, one set-point after the other [deg]."""
    end = math.radians(travel_deg)
    device = Device(ComponentId(1, 154), Servo(-end, end, 4.0, 8.0), lambda now: 0.0, earth=False)
    now = 0.0
    for angle in angles_deg:
        (packet,) = Decoder().feed(Encoder(1, 1).encode(set_attitude(-math.radians(angle), flags=VEHICLE_FRAME)))
        device.on_packet(packet, now)
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
