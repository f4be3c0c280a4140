"""DroneCAN services, allocation and our own messages: the bytes of the package `dronecan`, and what damage does."""

import math
import random
import struct
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as some

from dronecan_types import load_ours
from ross_protocols.can import CanFrame
from ross_protocols.dronecan.messages import Allocation, DroneCanError, Health, Mode, NodeStatus
from ross_protocols.dronecan.params import GetSetRequest, GetSetResponse, Opcode, OpcodeRequest, OpcodeResponse
from ross_protocols.dronecan.ross_types import RossSource, RossSources, RossStatus
from ross_protocols.dronecan.services import (
    NodeInfo,
    NodeInfoRequest,
    RestartRequest,
    RestartResponse,
    TransportStats,
    TransportStatsRequest,
)
from ross_protocols.dronecan.transfer import MOST_PARTIAL, ROOM, Header, Reassembler, split

UNIQUE = bytes(range(100, 116))
STATUS = NodeStatus(86400, Health.WARNING, Mode.MAINTENANCE, 513)
REQUESTS = [
    NodeInfoRequest(),
    TransportStatsRequest(),
    RestartRequest(),
    GetSetRequest("EXP_UNIT"),
    GetSetRequest("EXP_UNIT", value=2.5),
    GetSetRequest(index=8191, value=-7),
    GetSetRequest(index=300, value=True),
    GetSetRequest("NAME", value="a voice"),
    OpcodeRequest(Opcode.ERASE, -5),
]
RESPONSES = [
    NodeInfo(STATUS, "org.ross.payload", UNIQUE, (1, 2), (3, 4), 0x12345678),
    NodeInfo(STATUS, "", UNIQUE),
    TransportStats(1, 2, 3, 4, 5, 2**40),
    RestartResponse(True),
    RestartResponse(False),
    GetSetResponse("EXP_UNIT", 3.0, 2.5, 60.0, 0.5),
    GetSetResponse("EXP_MIN_ROT", 4, 4, 24, 1),
    GetSetResponse("EXP_PIPELINED", False, True),
    GetSetResponse("NAME", "a voice", ""),
    GetSetResponse(),
    OpcodeResponse(True, 5),
    OpcodeResponse(False, -1),
]
SOURCES = (
    RossSource(0.5, 0.0625, 0.75, score=-2.5, resolved=True, target=True),
    RossSource(-3.0, 0.125, 1.0, mirror=1.5, elevation=0.25),
)
BROADCASTS = [
    Allocation(125, UNIQUE[:6], first=True),
    Allocation(0, UNIQUE[12:]),
    Allocation(42, UNIQUE),
    RossStatus(2),
    RossStatus(
        6, 0, 2, 1, 12, 0.5, -1.25, 3.0, -4.5, 2.5, 11.5, earth=True, settled=True, fault=True, certain=True
    ),
    RossSources(7, SOURCES, earth=True, final=True),
    RossSources(0),
]  # fmt: skip


def name(value):
    return type(value).__name__


@pytest.mark.parametrize("value", REQUESTS + RESPONSES + BROADCASTS, ids=name)
def test_what_is_packed_is_unpacked(value):
    again = type(value).unpack(value.pack())
    assert again.pack() == value.pack()
    if not isinstance(value, (RossStatus, RossSources)):  # which have numbers as float32
        assert again == value


def test_directions_turn_around_on_the_wire():
    wire = RossSources(0, (RossSource(0.5, 0.1, 1.0),)).pack()
    assert struct.unpack_from("<f", wire, 2)[0] == -0.5
    assert RossSources.unpack(wire).sources[0].azimuth == 0.5
    assert RossStatus.unpack(RossStatus(0, joint=7.5, heading=2.0).pack()) == RossStatus(0, joint=7.5, heading=2.0)


def test_values_beyond_their_fields_are_held_back():
    again = RossStatus.unpack(RossStatus(6, k=300, rotation=400, score=1e9, gain_db=-math.inf).pack())
    assert (again.k, again.rotation, again.score, again.gain_db) == (254, 255, 65504.0, -65504.0)


@pytest.mark.parametrize("header", [Header(341, 9), Header(11, 127, 1, True, 31), Header(255, 1, 127, False, 0)])
def test_an_identifier_tells_what_it_was_made_of(header):
    assert Header.of(header.identifier) == header


def test_the_tail_tells_the_transfer_and_an_old_one_never_completes_a_new_one():
    one, two = (split(7, bytes(20), 1, n) for n in (3, 4))
    reassembler = Reassembler()
    assert [reassembler.feed(frame, 1) for frame in [*one[:-1], *two]][-1].transfer == 4


@pytest.mark.parametrize("size", [3, 20])
def test_frames_that_can_delivers_twice_are_one_transfer(size):
    """As when the sender alone sees an error in the last bit of a frame."""
    reassembler = Reassembler()
    frames = [frame for n in range(3) for frame in split(0x107, bytes(size), 1, n) for _ in range(2)]
    transfers = [transfer for frame in frames if (transfer := reassembler.feed(frame, 1)) is not None]
    assert [transfer.transfer for transfer in transfers] == [0, 1, 2]
    assert not reassembler.broken.total()


def test_every_flipped_bit_of_a_long_transfer_is_noticed():
    frames = split(7, bytes(range(30)), 0x1234, 3)
    for n, frame in enumerate(frames):
        for bit in range(8 * len(frame.data)):
            number = int.from_bytes(frame.data, "big") ^ 1 << bit
            broken = CanFrame(7, number.to_bytes(len(frame.data), "big"))
            reassembler = Reassembler()
            wholes = [reassembler.feed(each, 0x1234) for each in [*frames[:n], broken, *frames[n + 1 :]]]
            assert not any(whole is not None and len(whole.payload) > ROOM for whole in wholes)


def test_transfers_that_never_end_do_not_pile_up():
    reassembler = Reassembler()
    for identifier in range(3 * MOST_PARTIAL):
        reassembler.feed(CanFrame(identifier, bytes(7) + b"\x80"), 0)
    assert len(reassembler._partial) <= MOST_PARTIAL
    endless = [CanFrame(1, bytes(7) + bytes([0x80 * (n == 0) | 0x20 * (n % 2)])) for n in range(9999)]
    assert not any(reassembler.feed(frame, 0) for frame in endless)


@given(some.sampled_from([*REQUESTS, *RESPONSES, *BROADCASTS]), some.binary(max_size=300))
def test_random_bytes_are_read_or_refused_in_one_way(value, payload):
    with suppress(DroneCanError, struct.error):
        type(value).unpack(payload).pack()


@pytest.fixture(scope="module")
def dronecan():
    """An implementation that we did not write, with our own messages."""
    package = pytest.importorskip("dronecan")
    load_ours(package)
    return package


def same_frames(dronecan, header, value, transfer=5):
    """Let the package read our frames and write them again."""
    frames = split(header.identifier, value.pack(), value.SEED, transfer)
    theirs = dronecan.transport.Transfer()
    theirs.from_frames([dronecan.transport.Frame(frame.id, frame.data) for frame in frames])
    again = dronecan.transport.Transfer(
        transfer_id=transfer,
        source_node_id=header.source,
        dest_node_id=header.destination,
        payload=theirs.payload,
        transfer_priority=header.priority,
        request_not_response=header.request,
        service_not_message=header.destination is not None,
    )
    assert [CanFrame(frame.message_id, bytes(frame.bytes)) for frame in again.to_frames()] == frames
    return theirs.payload


@pytest.mark.parametrize("value", REQUESTS, ids=name)
def test_the_package_reads_our_requests_and_writes_the_same_bytes(dronecan, value):
    same_frames(dronecan, Header(value.NUMBER, 42, 7, True), value)


@pytest.mark.parametrize("value", RESPONSES, ids=name)
def test_the_package_reads_our_responses_and_writes_the_same_bytes(dronecan, value):
    same_frames(dronecan, Header(value.NUMBER, 42, 7), value)


@pytest.mark.parametrize("value", BROADCASTS, ids=name)
def test_the_package_reads_our_broadcasts_and_writes_the_same_bytes(dronecan, value):
    same_frames(dronecan, Header(value.NUMBER, 42), value)


def test_the_package_has_the_same_signatures(dronecan):
    kind = dronecan.dsdl.CompoundType
    for value in BROADCASTS:
        assert dronecan.DATATYPES[value.NUMBER, kind.KIND_MESSAGE].base_crc == value.SEED
    for value in REQUESTS + RESPONSES:
        assert dronecan.DATATYPES[value.NUMBER, kind.KIND_SERVICE].base_crc == value.SEED


def test_the_package_understands_our_own_messages(dronecan):
    sources = same_frames(dronecan, Header(20855, 9), BROADCASTS[-2])
    assert (sources.estimate, sources.flags) == (7, sources.FLAG_EARTH | sources.FLAG_FINAL)
    first, second = sources.sources
    assert (first.azimuth, first.sigma, first.confidence, first.score) == (-0.5, 0.0625, 75, -2.5)
    assert first.flags == first.FLAG_RESOLVED | first.FLAG_TARGET
    assert math.isnan(first.mirror)
    assert (second.azimuth, second.mirror, second.elevation) == (3.0, -1.5, 0.25)
    status = same_frames(dronecan, Header(20854, 9), BROADCASTS[4])
    assert (status.state, status.outcome, status.k, status.target) == (status.STATE_RUN, 0, 2, 1)
    assert (status.heading, status.heading_goal, status.alignment, status.joint) == (-0.5, 1.25, -3.0, 4.5)
    assert (status.score, status.gain) == (2.5, 11.5)
    wanted = status.FLAG_EARTH | status.FLAG_SETTLED | status.FLAG_FAULT | status.FLAG_CERTAIN
    assert status.flags == wanted


def test_the_package_understands_an_anonymous_request(dronecan):
    frame = Allocation(0, UNIQUE[:6], first=True).asked(0x1234, 3)
    theirs = dronecan.transport.Transfer()
    theirs.from_frames([dronecan.transport.Frame(frame.id, frame.data)])
    assert (theirs.source_node_id, theirs.discriminator) == (0, 0x1234)
    assert theirs.payload.first_part_of_unique_id == 1
    assert bytes(theirs.payload.unique_id.to_bytes()) == UNIQUE[:6]


def test_random_frames_raise_nothing():
    chance, reassembler = random.Random(1), Reassembler()  # noqa: S311
    for _ in range(20_000):
        frame = CanFrame(chance.randrange(2**29), chance.randbytes(chance.randrange(9)))
        Header.of(frame.id)
        reassembler.feed(frame, 0)
