"""What makes no sense in a message never reaches the picture, and is named."""

import json
import math
from dataclasses import fields

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from examples import examples
from fleet_ear import Ground, source, status
from ross_payload.ground.model.view import view
from ross_protocols.mavlink import values as v
from ross_protocols.mavlink.codec import Encoder, message_of
from ross_protocols.mavlink.dialect import MESSAGES, common
from ross_protocols.mavlink.message_map import LAYOUTS
from ross_protocols.mavlink.stream_values import Codec, Selection, StreamReport

FULL = [
    v.Heartbeat(v.Health.ACTIVE, 2),
    v.Information(0, 0.05, 343.0, 0.0, -1.0, 1.0, 2.0, 3.0, 16000, 6, "1.0", "tb6600"),
    status(1.0, heading=0.1, heading_goal=0.2, joint=0.1, joint_rate=0.0, mount_yaw=0.0, score=1.0, criterion=0.0, k=1),
    source(0, 0.5, count=1, mirror=0.1, elevation=0.1, score=1.0),
    v.Alignment(1, 1, 0, 1, 0, 0.5, 0.5, 1e-4, (1,), v.Rule.GAIN, v.CandidateState.PLANNED, earth=True, gain=5.0),
    v.Separation(1, 1, 0, 1, v.Phase.CHECK, (0,), "auto", True, 0.1, 1.0, 0.0, 5.0, 3.0),
    v.Audio(1, rate=16000.0),
    v.Recording(1, v.RecordingState.ON, 3.0, 1e9, "x", ""),
    v.Density(1, 1, 0, 0.1, True, -1e-4, 1e-4, (0.5,) * v.CURVE_POINTS),
    v.Isolation(1, 1, 0, True, 0.0, 3.0, 1e-4, (0.5,) * v.CURVE_POINTS),
    v.LinkReport(1, 0, 1, "udp", True, False),
    StreamReport(
        1,
        0,
        1,
        "rtp",
        Selection.SOURCE,
        True,
        48000,
        on=True,
        source=0,
        azimuth=0.5,
        group=0,
        codec=Codec.OPUS,
        address="127.0.0.1",
        port=5004,
        listeners=1,
        gain=-3.0,
        level=-20.0,
        delay=0.1,
        packets_lost=2,
    ),
    v.Named(0.0, "ross_k", 1.0),
    v.Array(1, "ross_az", 1, (1.0, 20.0)),
    v.Text(v.Severity.INFO, "well"),
]


def strict(known):
    """The picture as JSON that every browser reads."""
    return json.dumps(view(known), allow_nan=False)


@pytest.mark.parametrize("wrong", [math.nan, math.inf, -math.inf, 3.4e38])
@pytest.mark.parametrize("value", FULL, ids=lambda value: type(value).__name__)
def test_a_nan_in_any_field_never_reaches_the_picture(value, wrong):
    ground = Ground()
    ground.say(*FULL)
    before = strict(ground.known)
    floats = [field for field in message_of(value).fieldnames if _is_float(message_of(value), field)]
    for field in floats:
        message = message_of(value)
        old = getattr(message, field)
        setattr(message, field, [wrong] * len(old) if isinstance(old, (list, tuple)) else wrong)
        ground.say(message)
        assert strict(ground.known)
    ground.say(*FULL)
    assert json.loads(strict(ground.known))["standing"]["who"] == json.loads(before)["standing"]["who"]


def _is_float(message, field):
    return message.fieldtypes[message.fieldnames.index(field)] == "float"


def test_an_azimuth_that_is_none_is_left_out_counted_and_named(ground):
    ground.say(source(0, 0.5), source(1, math.nan))
    assert [entry.source for entry in ground.known.sources] == [0]
    assert ground.known.counts.malformed == 1
    assert ground.known.flaws == ("ROSS_SOURCE with a number that is NaN or infinite",)


def test_a_payload_that_says_nothing_but_nonsense_is_there_all_the_same(ground):
    ground.say(status(1.0))
    ground.at = 7.0
    ground.say(source(1, math.nan))
    assert ground.known.last == 7.0


numbers = [layout.message.id for layout in LAYOUTS] + [common.MAVLINK_MSG_ID_ONBOARD_COMPUTER_STATUS, 385, 33, 77]


@settings(max_examples=examples(200))
@given(st.lists(st.tuples(st.sampled_from(numbers), st.binary(min_size=1, max_size=255)), min_size=1, max_size=20))
def test_whatever_bytes_a_payload_sends_the_picture_is_strict_json(frames):
    ground = Ground()
    ground.say(status(1.0))
    encoder = Encoder(1, 191)
    for number, content in frames:
        message = MESSAGES[number]
        size = message.unpacker.size
        told = message(*_arguments(message, content.ljust(size, b"\0")[:size]))
        ground.hear([encoder.encode(told)])
    assert strict(ground.known)


def _arguments(message, content):
    """Fill the fields of a message with what some bytes mean in its format."""
    raw = message.unpacker.unpack(content)
    told = {}
    for place, name in enumerate(message.ordered_fieldnames):
        start = sum(max(length, 1) if kind != "char" else 1 for length, kind in _shapes(message)[:place])
        length, kind = _shapes(message)[place]
        told[name] = raw[start] if kind == "char" or length == 0 else list(raw[start : start + length])
    return [told[name] for name in message.fieldnames]


def _shapes(message):
    kinds = dict(zip(message.fieldnames, message.fieldtypes, strict=True))
    lengths = message.array_lengths
    return [(length, kinds[name]) for name, length in zip(message.ordered_fieldnames, lengths, strict=True)]


def test_no_value_is_forgotten_by_the_list_of_them():
    """Every kind of value that can be said is among those that are tried above."""
    assert {type(value) for value in FULL} == {layout.value for layout in LAYOUTS}
    assert all(fields(value) for value in FULL)
