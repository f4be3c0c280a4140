"""The codec: values come through the wire as they were, and nothing on the wire brings it down."""

import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common

from ross_protocols.mavlink.codec import Decoder, Encoder, chunks
from ross_protocols.mavlink.dialect import ross
from ross_protocols.mavlink.stream_values import Codec, Selection, StreamReport
from ross_protocols.mavlink.values import (
    CURVE_POINTS,
    Alignment,
    Array,
    Audio,
    CandidateState,
    Density,
    Health,
    Heartbeat,
    Information,
    Isolation,
    LinkReport,
    Named,
    Phase,
    Recording,
    RecordingState,
    Rule,
    Separation,
    Severity,
    Source,
    Status,
    Text,
    Value,
)

DIRECTIONS = {"heading", "heading_goal", "azimuth", "mirror", "mount_yaw", "axis_offset"}

numbers = st.floats(-1e6, 1e6, width=32)
directions = st.floats(-math.pi, math.pi)
whole = {bits: st.integers(0, 2**bits - 1) for bits in (8, 16, 32, 64)}
index = st.integers(0, 254)
members = st.sets(st.integers(0, 31)).map(lambda found: tuple(sorted(found)))
flag = st.booleans()
seconds = st.floats(-1e-2, 1e-2)
curves = st.tuples(*[st.integers(0, 255).map(lambda level: level / 255)] * CURVE_POINTS)


def words(size: int) -> st.SearchStrategy[str]:
    return st.text(st.characters(min_codepoint=32, max_codepoint=126), max_size=size)


def maybe(strategy: st.SearchStrategy) -> st.SearchStrategy:
    return st.none() | strategy


VALUES = st.one_of(
    st.builds(Heartbeat, st.sampled_from(Health), whole[32]),
    st.builds(Text, st.sampled_from(Severity), words(50), whole[16], whole[8]),
    st.builds(
        Information, whole[64], numbers, numbers, directions, maybe(numbers), maybe(numbers), maybe(numbers), numbers,
        whole[32], whole[8], words(24), words(16), whole[16],
    ),
    st.builds(
        Status, whole[64], whole[32].map(lambda ms: ms / 1000), whole[8], flag, maybe(index), maybe(directions),
        maybe(directions), maybe(numbers), maybe(numbers), maybe(directions), maybe(numbers), maybe(numbers), whole[8],
        whole[8], maybe(index), maybe(index), *[flag] * 11,
    ),
    st.builds(
        Source, whole[64], whole[16], whole[8], whole[8], directions, numbers, numbers, numbers, flag, flag,
        maybe(directions), maybe(numbers), maybe(numbers), flag, flag, flag, maybe(numbers.filter(bool)),
        maybe(numbers.filter(bool)),
    ),
    st.builds(
        Alignment, whole[64], whole[16], whole[8], whole[8], whole[8], directions, numbers, st.floats(0, 1e-2), members,
        st.sampled_from(Rule), st.sampled_from(CandidateState), flag,
    ),
    st.builds(
        Separation, whole[64], whole[16], whole[8], whole[8], st.sampled_from(Phase), members, words(16), flag,
        maybe(directions), maybe(numbers), maybe(numbers), maybe(numbers), maybe(numbers), flag, flag,
    ),
    st.builds(
        Audio, whole[64], whole[16], st.tuples(numbers, numbers), st.tuples(numbers, numbers), whole[32], whole[16],
        numbers, maybe(numbers),
    ),
    st.builds(
        Recording, whole[64], st.sampled_from(RecordingState), numbers, maybe(numbers), words(40), words(48),
    ),
    st.builds(
        Density, whole[64], whole[16], whole[8], directions, flag, seconds, seconds, curves,
    ),
    st.builds(
        Isolation, whole[64], whole[16], whole[8], flag, numbers, numbers, seconds, curves,
    ),
    st.builds(
        LinkReport, whole[64], whole[8], whole[8], words(60), flag, flag, *[whole[32]] * 3,
        maybe(st.integers(0, 2**32 - 2)), *[whole[32]] * 2, whole[16],
    ),
    st.builds(
        StreamReport, whole[64], whole[8], whole[8], words(10), st.sampled_from(Selection), flag, whole[32], flag,
        maybe(index), maybe(directions), maybe(index), st.sampled_from(Codec), words(40), whole[16], maybe(index),
        numbers, maybe(st.integers(-128, 126).map(float)), maybe(st.integers(0, 65534).map(lambda ms: ms / 1e3)),
        whole[32], maybe(st.integers(0, 2**32 - 2)), words(24), *[flag] * 4,
    ),
    st.builds(Named, whole[32].map(lambda ms: ms / 1000), words(10), numbers),
    st.builds(Array, whole[64], words(10), whole[16], st.lists(numbers.filter(bool), max_size=58).map(tuple)),
)  # fmt: skip

STATUS = Status(1_000_000, 1.0, 3, earth=True, heading=0.5)


def encode(*given: Value) -> bytes:
    encoder = Encoder(1, 191)
    return b"".join(encoder.encode(value) for value in given)


def same(sent: Value, got: Value) -> None:
    assert type(sent) is type(got)
    for name in sent.__dataclass_fields__:
        before, after = getattr(sent, name), getattr(got, name)
        if name in DIRECTIONS and before is not None:
            assert math.remainder(before - after, 2 * math.pi) == pytest.approx(0, abs=1e-6), name
        elif isinstance(before, float):
            assert after == pytest.approx(before, rel=1e-6, abs=1e-12), name
        else:
            assert after == before, name


@given(VALUES)
def test_a_value_comes_through_the_wire_as_it_was(value: Value) -> None:
    (packet,) = Decoder().feed(encode(value))
    assert packet.value is not None
    same(value, packet.value)


@given(st.lists(VALUES, max_size=5), st.data())
def test_frames_may_come_in_any_portions(given_values: list[Value], data: st.DataObject) -> None:
    stream = encode(*given_values)
    cuts = sorted(data.draw(st.lists(st.integers(0, len(stream)), max_size=8)))
    decoder = Decoder()
    got = [
        packet
        for start, end in zip([0, *cuts], [*cuts, len(stream)], strict=True)
        for packet in decoder.feed(stream[start:end])
    ]
    assert [packet.sequence for packet in got] == list(range(len(given_values)))
    assert decoder.skipped == 0


@given(st.binary(max_size=100).filter(lambda noise: not {0xFE, 0xFD} & set(noise)))
def test_noise_before_a_frame_is_skipped_and_counted(noise: bytes) -> None:
    decoder = Decoder()
    assert len(decoder.feed(noise + encode(STATUS))) == 1
    assert decoder.skipped == len(noise)


@given(st.binary(max_size=300), st.binary(max_size=300))
def test_no_noise_breaks_the_decoder_or_hides_what_follows_for_long(noise: bytes, more: bytes) -> None:
    decoder = Decoder()
    decoder.feed(noise)
    decoder.feed(more)
    longest = 255 + 12 + 13  # a false start can wait for this many bytes and no more
    found = decoder.feed(encode(*[STATUS] * (2 + longest // 40)))
    assert [packet.value for packet in found][-1:] == [STATUS]


@given(st.integers(0, 10_000), st.integers(1, 255))
def test_a_frame_with_a_wrong_byte_is_not_believed(place: int, change: int) -> None:
    frame = bytearray(encode(STATUS))
    frame[place % len(frame)] ^= change
    follow = encode(Heartbeat(Health.ACTIVE, 6))
    got = Decoder().feed(bytes(frame) + follow * 20)
    assert got, "the good frames behind it are found"
    assert {packet.value for packet in got} == {Heartbeat(Health.ACTIVE, 6)}


def test_the_bytes_are_mavlinks() -> None:
    """Built by hand from MAVLink's serialisation rules: fields by size, X.25 checksum with the extra byte."""
    value = Alignment(7, 258, 1, 3, 2, 0.25, -1.5, 212e-6, (0, 2), Rule.BISECTOR, CandidateState.TURNING, earth=False)
    payload = struct.pack("<QIfffHBBBBBB", 7, 0b101, -0.25, 1.5, 212.0, 258, 1, 3, 2, 1, 1, 2)
    body = struct.pack("<BBBBBBHB", len(payload), 0, 0, 0, 1, 191, 54003 & 0xFFFF, 54003 >> 16) + payload
    expected = b"\xfd" + body + struct.pack("<H", x25(body + bytes([166])))
    frame = Encoder(1, 191).encode(value)
    assert frame == expected


def x25(data: bytes) -> int:
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = (crc >> 1) ^ (0x8408 if crc & 1 else 0)
    return crc


@pytest.mark.parametrize(
    ("internal", "compass"), [(0, 0), (math.pi / 2, -math.pi / 2), (-math.pi / 2, math.pi / 2), (math.pi, math.pi)]
)
def test_on_the_wire_angles_turn_clockwise(internal: float, compass: float) -> None:
    source = Source(0, 0, 0, 1, internal, 0.1, 1.0, 1.0, earth=True, resolved=True)
    (packet,) = Decoder().feed(encode(source))
    assert packet.message.azimuth == pytest.approx(compass)
    assert packet.message.frame == ross.ROSS_FRAME_EARTH


def test_a_joint_angle_turns_around_but_is_not_wrapped() -> None:
    (packet,) = Decoder().feed(encode(Status(0, 0.0, 1, earth=False, joint=7.5, heading=7.5)))
    assert packet.message.joint == -7.5
    assert packet.message.heading == pytest.approx(2 * math.pi - 7.5)


def test_the_travel_turns_around_with_its_ends() -> None:
    information = Information(0, 0.05, 343.0, 0.0, -1.0, 3.0, 4.0, 3.0, 16000, 6, "1.2.3", "tb6600")
    (packet,) = Decoder().feed(encode(information))
    assert (packet.message.joint_min, packet.message.joint_max) == (-3.0, 1.0)


def test_what_is_not_known_goes_out_as_invalid() -> None:
    (packet,) = Decoder().feed(encode(Status(0, 0.0, 1, earth=False)))
    message = packet.message
    assert (message.k, message.target, message.outcome) == (255, 255, 255)
    assert all(math.isnan(x) for x in (message.heading, message.heading_goal, message.score, message.mount_yaw))


def test_a_number_beyond_a_float_becomes_infinite_not_an_error() -> None:
    (packet,) = Decoder().feed(encode(Status(0, 0.0, 1, earth=False, score=-1e300)))
    assert packet.message.score == -math.inf


def test_each_component_counts_its_own_frames() -> None:
    one, two = Encoder(1, 191), Encoder(1, 154)
    stream = [encoder.encode(STATUS) for encoder in (one, one, two, one)]
    got = Decoder().feed(b"".join(stream))
    assert [(packet.component_id, packet.sequence) for packet in got] == [(191, 0), (191, 1), (154, 0), (191, 2)]


def test_the_sequence_number_wraps() -> None:
    encoder = Encoder(1, 191)
    assert [encoder.encode(STATUS)[4] for _ in range(258)][-3:] == [255, 0, 1]


def test_the_heartbeat_is_a_payloads() -> None:
    (packet,) = Decoder().feed(encode(Heartbeat(Health.ACTIVE, 5)))
    message = packet.message
    assert (packet.system_id, packet.component_id) == (1, common.MAV_COMP_ID_ONBOARD_COMPUTER)
    assert (message.type, message.autopilot) == (common.MAV_TYPE_ONBOARD_CONTROLLER, common.MAV_AUTOPILOT_INVALID)
    assert (message.custom_mode, message.system_status) == (5, common.MAV_STATE_ACTIVE)
    assert message.base_mode & common.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED


def test_mavlink_1_is_heard() -> None:
    sender = common.MAVLink(None, srcSystem=7, srcComponent=1)
    frame = common.MAVLink_heartbeat_message(2, 3, 81, 4, 4, 3).pack(sender, force_mavlink1=True)
    (packet,) = Decoder().feed(frame)
    assert (packet.system_id, packet.name, packet.message.custom_mode) == (7, "HEARTBEAT", 4)


def test_a_message_that_nobody_knows_is_counted_not_shown() -> None:
    body = struct.pack("<BBBBBBHB", 3, 0, 0, 0, 1, 1, 60000, 0) + b"abc"
    stranger = b"\xfd" + body + b"??"
    decoder = Decoder()
    got = decoder.feed(stranger + encode(STATUS))
    assert [packet.value for packet in got] == [STATUS]
    assert (decoder.unknown, decoder.skipped) == (1, 0)


def test_a_frame_whose_format_is_not_ours_is_skipped() -> None:
    frame = bytearray(encode(STATUS))
    frame[2] |= 0x02  # an incompatibility flag of the future
    assert [packet.value for packet in Decoder().feed(bytes(frame) + encode(STATUS))] == [STATUS]


@given(st.text(st.characters(min_codepoint=32, max_codepoint=126), max_size=180))
def test_the_chunks_of_a_text_make_up_the_text(text: str) -> None:
    parts = chunks(Severity.INFO, text, 9)
    assert "".join(part.text for part in parts) == text
    assert [part.chunk for part in parts] == list(range(len(parts)))
    assert len(parts) == 1 or len(parts[-1].text) < 50, "the last chunk of several is not full: it ends the text"


def test_what_is_not_ascii_does_not_stop_a_text() -> None:
    (packet,) = Decoder().feed(encode(Text(Severity.ERROR, "über 90°")))
    assert packet.value == Text(Severity.ERROR, "?ber 90?")


def test_a_false_start_hides_no_true_frame() -> None:
    """Ten bytes that look like the header of a long heartbeat swallow nothing of what follows."""
    false = struct.pack("<BBBBBBBHB", 0xFD, 64, 0, 0, 0, 1, 1, 0, 0)
    decoder = Decoder()
    got = decoder.feed(false + encode(*[STATUS] * 3))
    assert [packet.sequence for packet in got] == [0, 1, 2]
    assert decoder.skipped == len(false)


def test_a_signed_frame_is_heard_with_its_signature() -> None:
    sender = common.MAVLink(None, srcSystem=255, srcComponent=190)
    sender.signing.secret_key = b"k" * 32
    sender.signing.sign_outgoing = True
    signed = common.MAVLink_heartbeat_message(6, 8, 0, 7, 4, 3).pack(sender)
    decoder = Decoder()
    got = decoder.feed(signed + encode(STATUS))
    assert [packet.name for packet in got] == ["HEARTBEAT", "ROSS_STATUS"]
    assert decoder.skipped == 0
