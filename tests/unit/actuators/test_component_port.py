"""The wire ``mavlink:`` of an actuator: whose word reaches the driver."""

from types import SimpleNamespace

import pytest

from ross_payload.actuators.mavlink_gimbal.component_port import ComponentPort
from ross_payload.mavlink import Received
from ross_protocols.mavlink import gimbal_messages
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common

AUTOPILOT, GIMBAL, STRANGER = ComponentId(1, 1), ComponentId(1, 154), ComponentId(7, 1)


def port(*roles):
    """A port on links of these roles, and what a link calls for each packet."""
    heard = []
    component = SimpleNamespace(id=ComponentId(1, 191), send=None, subscribe=heard.append)
    links = SimpleNamespace(
        system_id=1, status=lambda: tuple(SimpleNamespace(role=role) for role in roles), component=lambda _: component
    )
    return ComponentPort(links, 191), heard[0]


def from_link(role, sender):
    beat = common.MAVLink_heartbeat_message(2, 3, 0, 0, 4, 3)
    (packet,) = Decoder().feed(Encoder(*sender).encode(beat))
    return Received(f"udpin:{role}", role, packet, may_order=True)


@pytest.mark.parametrize(
    ("roles", "role", "sender", "believed"),
    [
        (("autopilot", "ground"), "autopilot", AUTOPILOT, True),
        (("autopilot", "ground"), "ground", AUTOPILOT, False),
        (("autopilot", "ground"), "ground", GIMBAL, True),
        (("autopilot", "ground"), "local", GIMBAL, True),
        (("ground",), "ground", AUTOPILOT, True),
        (("autopilot",), "autopilot", STRANGER, False),
    ],
)
def test_an_autopilot_is_believed_on_its_own_links_alone_where_there_are_any(roles, role, sender, believed):
    wire, on_packet = port(*roles)
    on_packet(from_link(role, sender))
    assert len(wire.receive()) == believed


@pytest.mark.parametrize(("whom", "heard"), [(GIMBAL, True), (ComponentId(0, 0), True), (ComponentId(7, 154), False)])
def test_a_ground_station_that_points_our_gimbal_is_heard_and_one_that_points_another_vehicle_s_is_not(whom, heard):
    wire, on_packet = port("ground")
    (packet,) = Decoder().feed(Encoder(255, 190).encode(gimbal_messages.point_device(whom, 0.5)))
    on_packet(Received("udpin:ground", "ground", packet, may_order=True))
    assert len(wire.receive()) == heard
