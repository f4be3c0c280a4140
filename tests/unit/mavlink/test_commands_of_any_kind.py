"""Whatever bytes and floods come: nothing is obeyed that was not asked for, and a stop is heard."""

import struct
from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from command_bench import (
    ACCEPTED,
    CANCEL,
    EXPLORE,
    HOME,
    INFORM,
    LISTEN,
    NOISE,
    PARK,
    REARM,
    RECORD,
    STOP,
    TURN,
    Payload,
)
from examples import examples
from ross_payload.config import Config
from ross_payload.config.parameter_store import Parameters
from ross_payload.mavlink.ftp_server import FtpServer
from ross_payload.mavlink.param_server import ParamServer
from ross_payload.orders import (
    Cancel,
    Explore,
    Home,
    Informed,
    ListenAt,
    ListenTo,
    MeasureNoise,
    Park,
    Rearm,
    Seek,
    Stop,
    TurnTo,
)
from ross_protocols.mavlink.codec import Decoder
from ross_protocols.mavlink.dialect import MESSAGES, ross


@pytest.fixture
def payload(sky):
    return Payload(sky())


ORDERS = {
    EXPLORE: Explore, LISTEN: (Seek, ListenTo, ListenAt), INFORM: Informed, TURN: TurnTo, STOP: Stop, CANCEL: Cancel,
    PARK: Park, NOISE: MeasureNoise, REARM: Rearm, HOME: Home,
}  # fmt: skip

SERVED = [75, 76, 80, 20, 21, 23, 110]  # messages that somebody here answers


floats = st.floats(width=32, allow_nan=True, allow_infinity=True)

small = st.integers(-3, 3).map(float)

numbers = st.one_of(st.integers(EXPLORE - 2, HOME + 2), st.sampled_from([80, 246, 400, 510, 511, 512, 520]))

octets = st.integers(0, 255)

targets = st.tuples(st.sampled_from([0, 1]) | octets, st.sampled_from([0, 191]) | octets)

commands = st.tuples(targets, numbers | st.integers(0, 65535), octets, st.tuples(*[small | floats] * 7), st.booleans())


def only_what_was_asked_for(given, message):
    """Whether the orders that follow a message are those that it may lead to."""
    if not given:
        return True
    number, target = message.command, (message.target_system, message.target_component)
    may = Cancel if message.get_msgId() == 80 else ORDERS.get(number, ())
    return target[0] in (0, 1) and target[1] in (0, 191) and len(given) == 1 and isinstance(given[0], may)


@settings(max_examples=examples(60))
@given(st.lists(st.tuples(commands, octets, octets), min_size=1, max_size=30))
def test_of_random_commands_none_raises_and_none_is_obeyed_that_was_not_asked_for(sky, frames):
    payload = Payload(sky())
    for (target, number, confirmation, values, long), system, component in frames:
        if long:
            message = ross.MAVLink_command_long_message(*target, number, confirmation, *values)
        else:
            message = ross.MAVLink_command_int_message(*target, 0, number, 0, 0, *values[:4], 7, -7, values[6])
        before = len(payload.given)
        payload.ground.air.call(message.pack(ross.MAVLink(None, srcSystem=system, srcComponent=component)))
        payload.wait(0.01)
        assert only_what_was_asked_for(payload.given[before:], message)


def random_frame(rng):
    """A frame of any message with a good checksum and random content; half of them nearly make sense."""
    served = rng.random() < 0.5
    kind = MESSAGES[int(rng.choice(SERVED if served else list(MESSAGES)))]
    content = bytearray(rng.bytes(kind.unpacker.size))
    if served:
        for name, choices in (
            ("target_system", (0, 1)),
            ("target_component", (0, 191)),
            ("command", range(54000, 54011)),
        ):
            if name in kind.ordered_fieldnames:
                _put(content, kind, name, int(rng.choice(choices)))
        if kind.id == 76 and rng.random() < 0.5:
            content[:28] = struct.pack("<7f", *rng.integers(-2, 91, 7))
    head = struct.pack("<BBBBBBHB", len(content), 0, 0, *rng.integers(0, 256, 3), kind.id & 0xFFFF, kind.id >> 16)
    checksum = ross.x25crc(head + content + bytes([kind.crc_extra])).crc
    return b"\xfd" + head + content + struct.pack("<H", checksum)


def _put(content, kind, name, value):
    layout = kind.unpacker.format.lstrip("<")
    before = "<" + layout[: kind.ordered_fieldnames.index(name)]
    struct.pack_into("<" + layout[kind.ordered_fieldnames.index(name)], content, struct.calcsize(before), value)


def flood(sky, count, seed):
    """Send random frames; return how many of them became orders and how many changed a parameter."""
    rng, sky = np.random.default_rng(seed), sky()
    payload, parameters, orders = Payload(sky), Parameters(Config()), 0
    server = ParamServer(sky.links.component(191), parameters, lambda name, value: None, payload.say)
    readable = FtpServer(sky.links.component(191), {"general.json": b"{}"})
    decoder = Decoder()
    for index in range(count):
        frame = random_frame(rng)
        sky.air.up.append(frame)
        sky.links.poll()
        orders += len(payload.given)
        if payload.given:
            (packet,) = decoder.feed(frame)
            assert only_what_was_asked_for(payload.given, packet.message)
        payload.given.clear()
        payload.texts.clear()
        if index % 20 == 0:
            server.tick(sky.clock.now())
            readable.tick(sky.clock.now())
            payload.wait(0.01)
    assert parameters.config == Config()  # no random name is a parameter's
    parameters.close()
    return orders


def test_three_thousand_random_frames_do_nothing_that_was_not_asked_for(sky):
    assert flood(sky, 3_000, seed=1) > 30  # else nothing was tested


@pytest.mark.soak
def test_a_million_random_frames_do_nothing_that_was_not_asked_for(sky):
    assert flood(sky, 1_000_000, seed=2) > 10_000


def test_what_is_remembered_of_senders_is_bounded(payload):
    for system in range(1, 256):
        for component in (1, 2, 3):
            other = type(payload.ground)(payload.ground.air, system, component)
            other.long(RECORD, 1)
        payload.wait(0.01)
    sizes = [len(v) for v in vars(payload.server).values() if hasattr(v, "__len__")]
    assert max(sizes) <= 256


def test_five_thousand_commands_a_second_are_not_all_answered(payload):
    """The answers to a flood stay a trickle, and another sender still gets its own."""
    other = type(payload.ground)(payload.ground.air, system_id=254)
    acks = Counter()
    for _ in range(100):
        for _ in range(50):
            other.long(EXPLORE, 1)
        acks += Counter(m.target_system for m in payload.wait(0.01) if m.get_type() == "COMMAND_ACK")
    assert acks[254] <= 80
    assert payload.command(STOP, seconds=0.05)[-1] == ACCEPTED


def test_of_a_flood_of_stops_the_mission_hears_a_few_and_the_last_one_counts(payload):
    for _ in range(100):
        for _ in range(50):
            payload.ground.long(STOP)
        payload.wait(0.01)
    assert 1 <= len(payload.given) <= 12
    payload.wait(3.0)
    assert payload.command(REARM, seconds=0.1) == [ACCEPTED]
    payload.ground.long(STOP)
    payload.wait(0.01)
    assert payload.stopped


def test_a_stop_right_after_a_re_arming_is_not_taken_for_the_one_before(payload):
    payload.ground.long(STOP)
    payload.ground.long(REARM)
    payload.ground.long(STOP)
    payload.wait(0.1)
    assert [type(order) for order in payload.given] == [Stop, Rearm, Stop]
    assert payload.stopped
