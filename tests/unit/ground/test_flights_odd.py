"""Messages with any numbers, rightly framed: a flight of them is told, drawn, played and exported all the same."""

import io
import itertools
import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rich.console import Console

from examples import examples
from flight_logs import UNIX, raw_frame, record
from ross_payload.ground.flights.playback import Playback
from ross_payload.ground.flights.reading import open_flight
from ross_payload.ground.flights.summary import FlightContent, summary
from ross_payload.ground.flights.table import show
from ross_protocols.mavlink.codec import Encoder
from ross_protocols.mavlink.dialect import MESSAGES, common
from ross_protocols.mavlink.tunnel import OURS
from ross_protocols.mavlink.values import Source, Status

pytestmark = pytest.mark.lockstep

SAID = [number for number, message in MESSAGES.items() if message.msgname.startswith(OURS)]
OTHERS = [
    common.MAVLINK_MSG_ID_HEARTBEAT,
    common.MAVLINK_MSG_ID_STATUSTEXT,
    common.MAVLINK_MSG_ID_COMMAND_LONG,
    common.MAVLINK_MSG_ID_COMMAND_ACK,
    common.MAVLINK_MSG_ID_NAMED_VALUE_FLOAT,
    common.MAVLINK_MSG_ID_GLOBAL_POSITION_INT,
]
ODD = [b"\xff" * 4, b"\x00\x00\x80\x7f", b"\x00\x00\x80\xff", b"\x00\x00\x80\xbf", b"\xff\xff\x7f\x7f", b"\x00" * 4]
PAYLOADS = st.one_of(st.binary(max_size=120), st.lists(st.sampled_from(ODD), max_size=30).map(b"".join))


@st.composite
def messages(draw):
    number = draw(st.sampled_from(SAID * 3 + OTHERS))
    size = MESSAGES[number].unpacker.size
    component = draw(st.sampled_from([191, 191, 191, 1]))
    return raw_frame(number, draw(PAYLOADS)[:size] or b"\0", draw(st.integers(0, 255)), component=component)


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    return tmp_path_factory.mktemp("odd")


@settings(max_examples=examples(60))
@given(frames=st.lists(messages(), min_size=2, max_size=25))
def test_no_message_is_too_odd(place, frames):
    (place / "odd.tlog").write_bytes(b"".join(record(UNIX + 1000 * count, frame) for count, frame in enumerate(frames)))
    flight = open_flight(place / "odd.tlog")
    assert len(flight.index) == len(frames)
    told = FlightContent(flight, flight.payloads)
    json.dumps(summary(told), allow_nan=False)
    show(summary(told), Console(file=io.StringIO(), width=80))
    Playback(flight).seek(flight.duration)
    export = pytest.importorskip("ross_payload.ground.flights.mcap", reason="needs the extra 'mcap'").export
    export(flight, flight.payloads, place / "odd.mcap")


@pytest.mark.soak
@settings(max_examples=examples(6))
@given(frames=st.lists(messages(), min_size=10, max_size=25))
def test_no_message_is_too_odd_to_be_drawn(place, frames):
    picture = pytest.importorskip("ross_payload.ground.flights.plot", reason="needs the extra 'sim'")
    (place / "drawn.tlog").write_bytes(b"".join(record(UNIX, frame) for frame in frames))
    flight = open_flight(place / "drawn.tlog")
    if flight.payloads:
        picture.draw(FlightContent(flight, flight.payloads), place / "a.png")


NASTY = [-3e38, -1.0, 0.0, 1e-38, 4.0, 3e38]


@pytest.mark.soak
def test_sources_and_scores_beyond_all_measure_are_drawn(place):
    picture = pytest.importorskip("ross_payload.ground.flights.plot", reason="needs the extra 'sim'")
    export = pytest.importorskip("ross_payload.ground.flights.mcap", reason="needs the extra 'mcap'").export
    encoder, said = Encoder(1, 191), []
    for index, (sigma, confidence) in enumerate(itertools.product(NASTY, NASTY)):
        said.append(Source(0, 1, index % 32, 32, sigma, sigma, confidence, 0.1, True, True, mirror=confidence))
        said.append(Status(0, 0.0, index, True, score=sigma, criterion=confidence, heading=sigma, mount_yaw=confidence))
    (place / "nasty.tlog").write_bytes(b"".join(record(UNIX, encoder.encode(each)) for each in said))
    flight = open_flight(place / "nasty.tlog")
    picture.draw(FlightContent(flight, flight.payloads), place / "nasty.png")
    export(flight, flight.payloads, place / "nasty.mcap")
