"""TUNNEL: our messages pass an autopilot that drops what it does not know, and nothing else comes out of it."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega

from ross_protocols.mavlink.codec import Encoder
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.tunnel import SIZE, TYPE, Wrapper, unwrap
from ross_protocols.mavlink.values import CURVE_POINTS, Density, Heartbeat, Information, Named, Source, Status, Value

LARGEST: list[Value] = [
    Density(2**64 - 1, 65535, 255, 3.0, True, -1e-4, 1e-4, (1.0,) * CURVE_POINTS),
    Information(2**64 - 1, 0.05, 343.0, 0.1, -1.0, 1.0, 3.0, 3.0, 48000, 6, "1" * 24, "a" * 16),
    Status(2**64 - 1, 4e6, 3, earth=True, heading=0.5, joint=-7.0),
]


@pytest.mark.parametrize("value", LARGEST, ids=lambda value: type(value).__name__)
def test_every_message_passes_an_autopilot_that_does_not_know_it(value: Value) -> None:
    """It is routed by ArduPilot's own dialect, which knows TUNNEL and none of ours."""
    sent = Wrapper(1, 191).wrap(value).pack(common.MAVLink(None, srcSystem=1, srcComponent=191))
    (routed,) = ardupilotmega.MAVLink(None).parse_buffer(sent)
    packet = unwrap(routed)
    assert packet is not None
    assert (packet.system_id, packet.component_id) == (1, 191)
    assert type(packet.value) is type(value)
    assert packet.value.time_usec == value.time_usec


def test_the_frames_inside_count_their_own_sequence() -> None:
    wrapper = Wrapper(1, 191)
    inside = [unwrap(wrapper.wrap(LARGEST[2])) for _ in range(3)]
    assert [packet.sequence for packet in inside if packet] == [0, 1, 2]


def tunnel(kind: int, data: bytes, length: int | None = None):
    padded = list(data.ljust(SIZE, b"\0")[:SIZE])
    return common.MAVLink_tunnel_message(0, 0, kind, len(data) if length is None else length, padded)


def test_another_payload_type_is_none_of_our_business() -> None:
    assert unwrap(tunnel(TYPE + 1, Encoder(1, 191).encode(LARGEST[2]))) is None


@pytest.mark.parametrize("value", [Heartbeat(4, 3), Named(0.0, "x", 1.0)], ids=lambda value: type(value).__name__)
def test_only_messages_of_our_dialect_come_out(value: Value) -> None:
    assert unwrap(tunnel(TYPE, Encoder(1, 191).encode(value))) is None


def test_a_command_in_a_tunnel_is_not_let_out() -> None:
    command = common.MAVLink_command_long_message(1, 191, 54004, 0, 0, 0, 0, 0, 0, 0, 0)
    assert unwrap(tunnel(TYPE, Encoder(255, 190).encode(command))) is None


def test_half_a_frame_and_two_frames_are_nothing() -> None:
    frame = Encoder(1, 191).encode(Source(0, 1, 0, 1, 0.5, 0.1, 0.9, 1.0, earth=True, resolved=True))
    assert unwrap(tunnel(TYPE, frame, length=len(frame) - 1)) is None
    assert unwrap(tunnel(TYPE, frame[:10] + frame)) is not None, "noise before it is skipped"
    assert unwrap(tunnel(TYPE, frame + frame)) is None


@given(st.binary(max_size=SIZE), st.integers(0, 255))
def test_no_content_breaks_the_reader(data: bytes, length: int) -> None:
    unwrap(tunnel(TYPE, data, length))
