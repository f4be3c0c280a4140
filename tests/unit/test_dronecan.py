"""DroneCAN messages: bytes by hand, damage, and the same bytes as the package `dronecan` writes and reads."""

import math
import random

import pytest

from ross_protocols.can import CanFrame
from ross_protocols.dronecan import (
    SEEDS,
    TYPES,
    ArrayCommand,
    Assembler,
    Command,
    CommandKind,
    Health,
    LogMessage,
    Mode,
    NodeStatus,
    Received,
    Sender,
    Status,
    as_sent,
    spacing,
)

MESSAGES = [
    ArrayCommand((Command(1, CommandKind.POSITION, 0.5),)),
    ArrayCommand(tuple(Command(n, CommandKind.PWM, 1500.0) for n in range(15))),
    Status(7, 1.5, -0.25, 2.0, 100),
    NodeStatus(86400, Health.WARNING, Mode.MAINTENANCE, 513),
    LogMessage(2, "motor", "hot, 81 degrees"),
    LogMessage(0, "", ""),
]


def received(frames, assembler=None):
    assembler = assembler or Assembler()
    return [message for frame in frames if (message := assembler.feed(frame)) is not None]


@pytest.mark.parametrize("message", MESSAGES, ids=lambda message: type(message).__name__)
def test_what_is_sent_is_received(message):
    assert received(Sender(42).frames(message)) == [Received(42, message)]


def test_an_identifier_tells_priority_type_and_node():
    (frame,) = Sender(42).frames(NodeStatus(1))
    assert frame.id == 20 << 24 | 341 << 8 | 42


def test_tail_bytes_tell_start_end_toggle_and_transfer():
    sender = Sender(42)
    tails = [frame.data[-1] for _ in range(2) for frame in sender.frames(ArrayCommand((Command(0, 0, 0.0),) * 4))]
    assert tails == [0x80, 0x20, 0x40, 0x81, 0x21, 0x41]


def test_transfers_are_counted_per_type_modulo_32():
    sender = Sender(42)
    sender.frames(LogMessage(0, "", ""))
    assert [sender.frames(NodeStatus(0))[0].data[-1] & 0x1F for _ in range(33)] == [*range(32), 0]


@pytest.mark.parametrize("lost", [0, 1, 2])
def test_a_transfer_that_lacks_a_frame_is_dropped_and_the_next_one_is_read(lost):
    sender, assembler = Sender(42), Assembler()
    message = ArrayCommand(tuple(Command(n, 0, 0.5) for n in range(4)))
    frames = sender.frames(message)
    assert received(frames[:lost] + frames[lost + 1 :], assembler) == []
    assert received(sender.frames(message), assembler) == [Received(42, message)]


def test_every_flipped_bit_of_a_long_transfer_is_noticed():
    frames = Sender(42).frames(Status(7, 1.5, -0.25, 2.0, 100))
    for n, frame in enumerate(frames):
        for bit in range(8 * len(frame.data)):
            number = int.from_bytes(frame.data, "big") ^ 1 << bit
            broken = CanFrame(frame.id, number.to_bytes(len(frame.data), "big"))
            assert received([*frames[:n], broken, *frames[n + 1 :]]) == []


def test_transfers_of_two_nodes_may_be_interleaved():
    one, other = (Sender(node).frames(Status(node, 1.0)) for node in (5, 6))
    pairs = [frame for pair in zip(one, other, strict=True) for frame in pair]
    assert [each.node for each in received(pairs)] == [5, 6]


def test_random_frames_raise_nothing_and_keep_little():
    chance, assembler = random.Random(1), Assembler()  # noqa: S311
    for _ in range(20_000):
        number = chance.choice([*TYPES, chance.randrange(2**16)])
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
    for number, seed in SEEDS.items():
        assert dronecan.DATATYPES[number, kind].base_crc == seed


@pytest.mark.parametrize("message", MESSAGES, ids=lambda message: type(message).__name__)
def test_the_package_reads_what_we_send_and_writes_the_same_bytes(dronecan, message):
    frames = Sender(42).frames(message)
    theirs = dronecan.transport.Transfer()
    theirs.from_frames([dronecan.transport.Frame(frame.id, frame.data) for frame in frames])
    again = dronecan.transport.Transfer(source_node_id=42, payload=theirs.payload, transfer_priority=frames[0].id >> 24)
    assert [CanFrame(frame.message_id, bytes(frame.bytes)) for frame in again.to_frames()] == frames


def test_the_package_understands_every_field(dronecan):
    theirs = dronecan.transport.Transfer()
    frames = Sender(42).frames(NodeStatus(86400, Health.WARNING, Mode.MAINTENANCE, 513))
    theirs.from_frames([dronecan.transport.Frame(frame.id, frame.data) for frame in frames])
    status = theirs.payload
    assert (status.uptime_sec, status.health, status.mode, status.vendor_specific_status_code) == (86400, 1, 2, 513)
