"""DroneCAN messages: bytes by hand, damage, and the same bytes as the package `dronecan` writes and reads."""

import math
import random

import pytest

from ross_protocols.can import CanFrame
from ross_protocols.dronecan.gimbal_messages import COARSE, GimbalMode
from ross_protocols.dronecan.messages import (
    AngularCommand,
    ArrayCommand,
    Command,
    CommandKind,
    GimbalStatus,
    Health,
    LogMessage,
    Mode,
    NodeStatus,
    Received,
    Status,
    as_sent,
    spacing,
)
from ross_protocols.dronecan.node_messages import BROADCASTS, Decoder, Encoder

MESSAGES = [
    ArrayCommand((Command(1, CommandKind.POSITION, 0.5),)),
    ArrayCommand(tuple(Command(n, CommandKind.PWM, 1500.0) for n in range(15))),
    Status(7, 1.5, -0.25, 2.0, 100),
    NodeStatus(86400, Health.WARNING, Mode.MAINTENANCE, 513),
    LogMessage(2, "motor", "hot, 81 degrees"),
    LogMessage(0, "", ""),
    AngularCommand(3, 0.0),
    GimbalStatus(3, 0.0),
]


def received(frames, assembler=None):
    assembler = assembler or Decoder(0)
    return [message for frame in frames if (message := assembler.feed(frame)) is not None]


@pytest.mark.parametrize("message", MESSAGES, ids=lambda message: type(message).__name__)
def test_what_is_sent_is_received(message):
    assert received(Encoder(42).broadcast(message)) == [Received(42, message)]


def test_an_identifier_tells_priority_type_and_node():
    (frame,) = Encoder(42).broadcast(NodeStatus(1))
    assert frame.id == 20 << 24 | 341 << 8 | 42


def test_tail_bytes_tell_start_end_toggle_and_transfer():
    sender = Encoder(42)
    tails = [frame.data[-1] for _ in range(2) for frame in sender.broadcast(ArrayCommand((Command(0, 0, 0.0),) * 4))]
    assert tails == [0x80, 0x20, 0x40, 0x81, 0x21, 0x41]


def test_transfers_are_counted_per_type_modulo_32():
    sender = Encoder(42)
    sender.broadcast(LogMessage(0, "", ""))
    assert [sender.broadcast(NodeStatus(0))[0].data[-1] & 0x1F for _ in range(33)] == [*range(32), 0]


@pytest.mark.parametrize("lost", [0, 1, 2])
def test_a_transfer_that_lacks_a_frame_is_dropped_and_the_next_one_is_read(lost):
    sender, assembler = Encoder(42), Decoder(0)
    message = ArrayCommand(tuple(Command(n, 0, 0.5) for n in range(4)))
    frames = sender.broadcast(message)
    assert received(frames[:lost] + frames[lost + 1 :], assembler) == []
    assert received(sender.broadcast(message), assembler) == [Received(42, message)]


def test_every_flipped_bit_of_a_long_transfer_is_noticed():
    frames = Encoder(42).broadcast(Status(7, 1.5, -0.25, 2.0, 100))
    for n, frame in enumerate(frames):
        for bit in range(8 * len(frame.data)):
            number = int.from_bytes(frame.data, "big") ^ 1 << bit
            broken = CanFrame(frame.id, number.to_bytes(len(frame.data), "big"))
            assert received([*frames[:n], broken, *frames[n + 1 :]]) == []


def test_transfers_that_came_in_part_are_counted_by_node():
    sender, assembler = Encoder(42), Decoder(0)
    for lost in (0, 1, None):
        frames = sender.broadcast(Status(7, 1.5))
        received([frame for n, frame in enumerate(frames) if n != lost], assembler)
    assert assembler.broken[42] == 2
    assert assembler.broken[41] == 0


def test_a_message_tells_its_number_among_its_kind():
    sender = Encoder(42)
    assert [received(sender.broadcast(Status(7)))[0].transfer for _ in range(33)] == [*range(32), 0]


@pytest.mark.parametrize("kind", [AngularCommand, GimbalStatus])
def test_a_yaw_survives_as_a_quaternion_of_float16(kind):
    for degrees in range(-179, 180):
        ((_, there),) = [(0, each.message) for each in received(Encoder(42).broadcast(kind(1, math.radians(degrees))))]
        assert there.yaw == pytest.approx(math.radians(degrees), abs=COARSE)


def test_a_quaternion_of_zeros_is_no_attitude():
    assert math.isnan(GimbalStatus.unpack(bytes(10)).yaw)


def test_transfers_of_two_nodes_may_be_interleaved():
    one, other = (Encoder(node).broadcast(Status(node, 1.0)) for node in (5, 6))
    pairs = [frame for pair in zip(one, other, strict=True) for frame in pair]
    assert [each.node for each in received(pairs)] == [5, 6]


def test_random_frames_raise_nothing_and_keep_little():
    chance, assembler = random.Random(1), Decoder(0)  # noqa: S311
    for _ in range(20_000):
        number = chance.choice([*BROADCASTS, chance.randrange(2**16)])
        identifier = chance.randrange(32) << 24 | number << 8 | chance.randrange(128) | chance.choice([0, 0, 128])
        assembler.feed(CanFrame(identifier, chance.randbytes(chance.randrange(9))))
    endless = [
        CanFrame(20 << 24 | 341 << 8 | 9, bytes(7) + bytes([0x80 * (n == 0) | 0x20 * (n % 2)])) for n in range(999)
    ]
    assert received(endless, assembler) == []


def test_float16_is_as_coarse_as_its_spacing_says():
    for value in (0.3, 1.0, 1.4, math.pi, 1500.0):
        below = as_sent(value) - spacing(value)
        assert as_sent(below) == below
        assert as_sent(below + spacing(value) * 0.4) == below


@pytest.fixture(scope="module")
def dronecan():
    """An implementation that we did not write."""
    return pytest.importorskip("dronecan")


def test_the_package_has_the_same_types(dronecan):
    kind = dronecan.dsdl.CompoundType.KIND_MESSAGE
    for message in MESSAGES:
        assert dronecan.DATATYPES[message.NUMBER, kind].base_crc == message.SEED


@pytest.mark.parametrize("message", MESSAGES, ids=lambda message: type(message).__name__)
def test_the_package_reads_what_we_send_and_writes_the_same_bytes(dronecan, message):
    frames = Encoder(42).broadcast(message)
    theirs = dronecan.transport.Transfer()
    theirs.from_frames([dronecan.transport.Frame(frame.id, frame.data) for frame in frames])
    again = dronecan.transport.Transfer(source_node_id=42, payload=theirs.payload, transfer_priority=frames[0].id >> 24)
    assert [CanFrame(frame.message_id, bytes(frame.bytes)) for frame in again.to_frames()] == frames


@pytest.mark.parametrize("pitch_deg", [-40, 0, 40])
def test_the_package_s_quaternion_xyzw_of_a_clockwise_yaw_is_ours_with_the_other_sign(dronecan, pitch_deg):
    cy, sy = math.cos(math.radians(60) / 2), math.sin(math.radians(60) / 2)  # 60 deg clockwise: to the right
    cp, sp = math.cos(math.radians(pitch_deg) / 2), math.sin(math.radians(pitch_deg) / 2)
    status = dronecan.uavcan.equipment.camera_gimbal.Status(gimbal_id=5)
    status.mode.command_mode = status.mode.COMMAND_MODE_ORIENTATION_BODY_FRAME
    status.camera_orientation_in_body_frame_xyzw = [-sp * sy, sp * cy, cp * sy, cp * cy]
    status.camera_orientation_in_body_frame_covariance = [0.5, 0.25, 0.5]
    frames = dronecan.transport.Transfer(3, source_node_id=42, payload=status, transfer_priority=16).to_frames()
    (heard,) = received([CanFrame(frame.message_id, bytes(frame.bytes)) for frame in frames])
    assert (heard.message.gimbal_id, heard.message.mode, heard.transfer) == (5, GimbalMode.BODY_FRAME, 3)
    assert heard.message.yaw == pytest.approx(math.radians(-60), abs=2e-3)


def test_the_package_reads_our_angular_command_as_a_turn_to_the_left(dronecan):
    theirs = dronecan.transport.Transfer()
    frames = Encoder(42).broadcast(AngularCommand(5, math.radians(90)))
    theirs.from_frames([dronecan.transport.Frame(frame.id, frame.data) for frame in frames])
    command = theirs.payload
    assert (command.gimbal_id, command.mode.command_mode) == (5, command.mode.COMMAND_MODE_ORIENTATION_BODY_FRAME)
    half = math.sqrt(0.5)
    assert list(command.quaternion_xyzw) == pytest.approx([0, 0, -half, half], abs=5e-4)


def test_the_package_understands_every_field(dronecan):
    theirs = dronecan.transport.Transfer()
    frames = Encoder(42).broadcast(NodeStatus(86400, Health.WARNING, Mode.MAINTENANCE, 513))
    theirs.from_frames([dronecan.transport.Frame(frame.id, frame.data) for frame in frames])
    status = theirs.payload
    assert (status.uptime_sec, status.health, status.mode, status.vendor_specific_status_code) == (86400, 1, 2, 513)
