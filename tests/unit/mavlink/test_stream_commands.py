"""Live listening and enrolment by command: what is ordered, what is refused, and that it happens once."""

import math
import struct
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from command_bench import (
    ACCEPTED,
    DENIED,
    EXPLORE,
    FAILED,
    IN_PROGRESS,
    STOP,
    TEMPORARILY_REJECTED,
    Payload,
)
from ross_payload.interfaces import Groups
from ross_payload.mission import enrol_talker
from ross_payload.orders import Enrol
from ross_payload.streams import Selection, StreamOrder, What
from ross_protocols.mavlink import stream_command
from ross_protocols.mavlink.dialect import ross
from ross_protocols.mavlink.stream_command import StreamCommand
from ross_protocols.mavlink.stream_values import Selection as Selected

STREAM, ENROL = ross.MAV_CMD_ROSS_STREAM, ross.MAV_CMD_ROSS_ENROL
NAN = math.nan
HOME = 127 * 256, 1  # the halves of 127.0.0.1
L16, OPUS = 65536, 2 * 65536


@pytest.fixture
def payload(sky):
    return Payload(sky())


# ------------------------------------------------------------------------------------------- the seven numbers


addresses = st.integers(1 << 24, (224 << 24) - 1).map(  # 1.0.0.0 to 223.255.255.255: of one computer
    lambda number: ".".join(str(number >> shift & 255) for shift in (24, 16, 8, 0))
)
commands = st.builds(
    StreamCommand,
    number=st.none() | st.integers(0, 254),
    selection=st.none() | st.sampled_from([Selected.NONE, Selected.MIXTURE, Selected.TARGET]),
    gain=st.none() | st.integers(-100, 40).map(float),
    address=addresses,
    port=st.integers(1, 65535),
    codec=st.sampled_from(["", "L16", "opus"]),
)


@given(commands)
def test_every_address_and_port_comes_through_floats_of_32_bits_as_it_was(command):
    numbers = stream_command.numbers_of(command)
    on_the_wire = struct.unpack("<7f", struct.pack("<7f", *numbers))
    assert stream_command.command_of(on_the_wire) == command


@pytest.mark.parametrize("address", ["239.1.2.3", "224.0.0.1", "255.255.255.255", "0.1.2.3", "240.0.0.1"])
def test_an_address_of_many_is_refused_at_both_ends(address):
    with pytest.raises(ValueError, match="address: expected that of one computer"):
        stream_command.numbers_of(StreamCommand(address=address, port=5004))
    high, low = divmod(int.from_bytes(map(int, address.split("."))), 65536)
    with pytest.raises(ValueError, match="expected"):
        stream_command.command_of((-1, NAN, 0, NAN, high, low, 5004))


@pytest.mark.parametrize(
    ("address", "words"),
    [
        ("payload.local", "expected IPv4, as in 192.168.1.20, got 'payload.local'"),
        ("::1", "expected IPv4"),
        ("127.1", "expected IPv4"),
        ("10.0.0.256", "expected IPv4"),
    ],
)
def test_what_is_no_ipv4_address_is_refused(address, words):
    with pytest.raises(ValueError, match=words.replace(".", r"\.")):
        stream_command.unicast(address)


# ------------------------------------------------------------------------------------------- what is asked for


@pytest.mark.parametrize(
    ("numbers", "order"),
    [
        (
            (-1, 2, 0, NAN, *HOME, 5004),
            StreamOrder(on=True, selection=Selection(), address="127.0.0.1", port=5004),
        ),
        (
            (-1, 3, 2, -6, *HOME, OPUS + 65535),
            StreamOrder(
                on=True, selection=Selection(What.SOURCE, source=2), gain_db=-6.0, muted=False,
                address="127.0.0.1", port=65535, codec="opus",
            ),
        ),
        (
            (0, 4, 90, NAN, 0, 0, 0),
            StreamOrder(on=True, number=0, selection=Selection(What.AZIMUTH, azimuth=-math.pi / 2)),
        ),
        ((1, NAN, 0, -100, 0, 0, 0), StreamOrder(on=True, number=1, muted=True)),
        ((1, NAN, 0, 0, 0, 0, L16), StreamOrder(on=True, number=1, gain_db=0.0, muted=False, codec="L16")),
        ((2, 1, NAN, NAN, 0, 0, 0), StreamOrder(on=True, number=2, selection=Selection(What.MIXTURE))),
        ((3, 0, 0, 0, 0, 0, 0), StreamOrder(on=False, number=3)),
        ((-1, 0, 0, 0, 0, 0, 0), StreamOrder(on=False)),
    ],
)  # fmt: skip
def test_a_command_becomes_its_order_for_the_listening_stage(payload, numbers, order):
    assert payload.command(STREAM, *numbers, seconds=0.05) == [ACCEPTED]
    (given,) = payload.streamed
    assert given == order
    assert payload.given == [], "the mission has nothing to do with it"


@pytest.mark.parametrize(
    ("numbers", "words"),
    [
        ((-1, 2, 0, NAN, 0, 0, 0), "address: expected one for a new stream"),
        ((-1, 2, 0, NAN, *HOME, 0), "port: expected 1 to 65535, got 0"),
        ((1, 2, 0, NAN, 0, 0, 5004), "port: expected 0 without an address, got 5004"),
        ((-1, 2, 0, NAN, 239 * 256, 1, 5004), "address: expected that of one computer, got 239.0.0.1"),
        ((-1, 2, 0, NAN, 65535, 65535, 5004), "address: expected that of one computer, got 255.255.255.255"),
        ((-1, 2, 0, NAN, 127.5, 1, 5004), "address 1: expected a whole number"),
        ((-1, 2, 0, NAN, 65536, 1, 5004), "address 1: expected 0 to 65535"),
        ((-1, 2, 0, NAN, *HOME, 3 * 65536 + 5004), "port and codec: expected 0 to 196607"),
        ((-1, 5, 0, NAN, *HOME, 5004), "selection: expected 0 to 4, got 5"),
        ((-1, 3, NAN, NAN, *HOME, 5004), "source: expected 0 to 255, got nan"),
        ((-1, 4, 361, NAN, *HOME, 5004), "azimuth: expected -360 to 360, got 361"),
        ((-1, 2, 0, 41, *HOME, 5004), "gain: expected -100 to 40, got 41"),
        ((-1, 2, 0, math.inf, *HOME, 5004), "gain: expected -100 to 40, got inf"),
        ((NAN, 2, 0, NAN, *HOME, 5004), "stream: expected -1 to 254, got nan"),
        ((255, 2, 0, NAN, *HOME, 5004), "stream: expected -1 to 254, got 255"),
    ],
)
def test_numbers_that_cannot_be_meant_are_denied_in_words(payload, numbers, words):
    assert payload.command(STREAM, *numbers, seconds=0.05) == [DENIED]
    assert payload.streamed == []
    (text,) = payload.texts
    assert text.startswith(f"stream refused: {words}")


def test_both_messages_of_the_command_protocol_carry_an_address(payload):
    payload.ground.int(STREAM, -1, 2, 0, NAN, *HOME, OPUS + 5004)
    assert payload.results(STREAM, seconds=0.05) == [ACCEPTED]
    assert (payload.streamed[0].address, payload.streamed[0].port) == ("127.0.0.1", 5004)


def test_what_the_listening_stage_refuses_fails_with_its_reason(payload):
    payload.why_not = "rtp: the extra 'stream' is not installed"
    assert payload.command(STREAM, -1, 2, 0, NAN, *HOME, 5004, seconds=0.05) == [FAILED]
    assert payload.texts == ["stream refused: rtp: the extra 'stream' is not installed"]


def test_a_stream_is_ordered_in_any_state_and_while_the_mission_computes(payload):
    payload.command(STOP, seconds=0.05)
    assert payload.command(STREAM, -1, 1, 0, NAN, *HOME, 5004, seconds=0.05) == [ACCEPTED]
    payload.computing = True
    assert payload.command(STREAM, 0, 0, seconds=0.05) == [ACCEPTED]


def test_a_stream_that_is_ordered_again_because_its_answer_was_lost_starts_once(payload):
    numbers = -1, 2, 0, NAN, *HOME, 5004
    payload.command(STREAM, *numbers, seconds=0.05)
    assert payload.command(STREAM, *numbers, seconds=0.05, confirmation=1) == [ACCEPTED]
    assert len(payload.streamed) == 1


def test_other_streams_than_the_one_before_are_obeyed_at_once(payload):
    for number in range(3):
        assert payload.command(STREAM, number, NAN, 0, -6, seconds=0.05) == [ACCEPTED]
    assert [order.number for order in payload.streamed] == [0, 1, 2]


# ------------------------------------------------------------------------------------------- enrolment


def test_enrolment_needs_consent(payload):
    for consent in (0, 0.5, NAN):
        assert payload.command(ENROL, 2, 0, 30, 10, consent, 3, seconds=0.05) == [DENIED]
    assert payload.given == []
    assert payload.texts[0] == "enrol refused: consent: expected 1, since the talker must have agreed"


@pytest.mark.parametrize(
    ("numbers", "words"),
    [
        ((0, 0, 0, 10, 1, 3), "mode: expected 1 to 2, got 0"),
        ((1, 0.5, 0, 10, 1, 3), "source: expected a whole number"),
        ((2, 0, NAN, 10, 1, 3), "azimuth: expected -360 to 360, got nan"),
        ((2, 0, 0, 301, 1, 3), "time: expected 0 to 300, got 301"),
        ((2, 0, 0, 10, 1, 10000), "name: expected 0 to 9999, got 10000"),
    ],
)
def test_an_enrolment_that_cannot_be_meant_is_denied_in_words(payload, numbers, words):
    assert payload.command(ENROL, *numbers, seconds=0.05) == [DENIED]
    assert payload.texts[0].startswith(f"enrol refused: {words}")


def test_an_enrolment_says_where_how_long_and_under_which_name(payload):
    payload.computing = True
    payload.command(ENROL, 2, 0, 90, 12, 1, 7, seconds=0.05)
    (order,) = payload.given
    assert isinstance(order, Enrol)
    assert (order.source, order.azimuth, order.seconds) == (None, pytest.approx(-math.pi / 2), 12.0)
    assert (order.name, order.consent) == ("talker-7", True)


def test_without_a_number_the_name_is_left_to_the_payload(payload):
    payload.computing = True
    payload.command(ENROL, 2, 0, 90, 0, 1, 0, seconds=0.05)
    assert payload.given[0].name == ""


def test_a_source_can_only_be_enrolled_when_it_is_known(payload):
    assert payload.command(ENROL, 1, 0, 0, 10, 1, seconds=0.05) == [TEMPORARILY_REJECTED]
    payload.ground.long(EXPLORE)
    assert payload.results(EXPLORE, seconds=8.0) == [IN_PROGRESS, ACCEPTED]
    assert payload.command(ENROL, 1, 2, 0, 10, 1, seconds=0.05) == [DENIED]
    assert payload.texts[-1] == "enrol refused: source: expected 0 to 1, got 2"


@pytest.fixture
def somebody(monkeypatch):
    """One talker, who is alone and says nothing."""

    def separate(context, estimate, heard):
        voice = heard.samples[:1]
        return Groups(voice[:, None], ((estimate.k - 1,),), "alone"), voice

    monkeypatch.setattr(enrol_talker, "separate", separate)


def test_a_talker_is_enrolled_by_command(payload, somebody, monkeypatch):
    monkeypatch.setattr(enrol_talker, "enrol", lambda voice, rate, model, **how: SimpleNamespace(seconds=4.2))
    assert payload.command(ENROL, 2, 0, 30, 0.5, 1, 3, seconds=8.0) == [IN_PROGRESS, ACCEPTED]


def test_who_does_not_speak_is_not_enrolled(payload, somebody):
    assert payload.command(ENROL, 2, 0, 30, 0.5, 1, 3, seconds=8.0) == [IN_PROGRESS, FAILED]
