"""Component metadata and the files it comes in: from the payload's own servers, from odd and hostile ones."""

import json
import struct
from collections import deque
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from client_bench import US, WHO, Served, Station
from ross_payload.config.parameter_table import TABLE
from ross_payload.ground.client.component_metadata import Metadata, described_in, parameter_place, place_of
from ross_payload.ground.client.ftp_client import MOST_BYTES, FileReader
from ross_payload.mavlink.component_info import PARAMETERS, files
from ross_payload.mavlink.ftp_server import SPEED
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.commands import Result, acknowledgement
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import ross
from ross_protocols.mavlink.ftp import MOST, Opcode, Packet, message_of, packet_of

LONG = bytes(range(256)) * 40


def rig_of(sky, content=None, **odds):
    payload = Served(sky(**odds), {"long.bin": LONG, "empty.bin": b""} | (content or {}))
    station = Station(payload)
    return SimpleNamespace(payload=payload, station=station)


def reading_of(rig, path):
    reading = FileReader(lambda message: rig.station.send(message, WHO), WHO, US, path)
    rig.station.clients = [reading]
    return reading


def metadata_of(rig):
    metadata = Metadata(lambda message: rig.station.send(message, WHO), WHO, *US)
    rig.station.clients = [metadata]
    return metadata


# ------------------------------------------------------------------------------------------- files


def test_a_file_is_read_whole(sky):
    rig = rig_of(sky)
    reading = reading_of(rig, "/long.bin")
    assert rig.station.wait(10, lambda: reading.over)
    assert reading.content == LONG
    assert len(rig.station.sent) == 6, "open, a burst of 4 s, asked three times to go on, terminate"


def test_a_burst_does_not_wait_for_the_way_there_and_back(sky):
    rig = rig_of(sky)
    air, clock, up, down, portions = rig.payload.ground.air, rig.payload.clock, deque(), deque(), []

    def far(way, under_way):
        fresh, way[:] = [(clock.now() + 0.4, frame) for frame in way], []
        under_way.extend(fresh)
        while under_way and under_way[0][0] <= clock.now():
            way.append(under_way.popleft()[1])

    receive, listen = air.receive, air.listen
    air.receive = lambda: (far(air.up, up), receive())[1]
    air.listen = lambda: (far(air.down, down), portions.extend(air.down), listen())[2]
    reading = reading_of(rig, "/long.bin")
    assert rig.station.wait(20, lambda: reading.over)
    assert reading.content == LONG
    assert clock.now() < 2 * 0.8 + len(LONG) / SPEED * 263 / 239 + 0.3
    assert len(portions) == 1 + -(-len(LONG) // 239), "each of them comes once"


def test_an_empty_file_is_whole_at_once(sky):
    rig = rig_of(sky)
    reading = reading_of(rig, "/empty.bin")
    rig.station.wait(2, lambda: reading.over)
    assert (reading.content, reading.trouble) == (b"", "")


def test_a_file_that_is_not_there_is_named(sky):
    rig = rig_of(sky)
    reading = reading_of(rig, "/none.json")
    rig.station.wait(2, lambda: reading.over)
    assert reading.trouble == "/none.json: there is no such file"


@pytest.mark.parametrize("seed", range(4))
def test_on_a_bad_link_a_file_is_whole_and_right(sky, seed):
    rig = rig_of(sky, loss=0.2, doubled=0.2, delayed=0.2, damaged=0.05, seed=seed)
    reading = reading_of(rig, "/long.bin")
    assert rig.station.wait(90, lambda: reading.over)
    assert reading.content == LONG


def test_a_server_that_forgets_in_mid_burst_is_asked_from_the_beginning(sky):
    """It keeps a file open for eight clients; here come eight more."""
    rig = rig_of(sky)
    reading = reading_of(rig, "/long.bin")
    rig.station.wait(1.0)
    for number in range(8):
        Station(rig.payload, (100 + number, 190)).send(
            message_of(Packet(1, Opcode.OPEN_RO, size=12, data=b"general.json"), ComponentId(1, 191)), WHO
        )
    assert rig.station.wait(20, lambda: reading.over)
    assert reading.content == LONG
    assert [packet_of(message).opcode for _, message in rig.station.sent].count(Opcode.OPEN_RO) == 2


def test_a_server_that_falls_silent_is_given_up(sky):
    rig = rig_of(sky)
    reading = reading_of(rig, "/long.bin")
    rig.station.wait(1.0)
    rig.payload.ground.air.odds.loss = 1.0
    assert rig.station.wait(20, lambda: reading.over)
    assert reading.trouble == "/long.bin: no answer"


class Script:
    """A file server that does what it is told to."""

    def __init__(self, path="/file", sequence=0):
        self.asked, self.now = [], 0.0
        self.reading = FileReader(lambda message: self.asked.append(packet_of(message)), WHO, US, path, sequence)
        self.encoder, self.decoder = Encoder(1, 191), Decoder()
        self.reading.tick(0.0)

    def say(self, packet, to=US, encoder=None):
        for heard in self.decoder.feed((encoder or self.encoder).encode(message_of(packet, ComponentId(*to)))):
            self.reading.on_packet(heard, self.now)

    def open(self, size, session=3, **how):
        answer = Packet(
            self.asked[-1].sequence + 1, Opcode.ACK, session, 4, Opcode.OPEN_RO, data=struct.pack("<I", size)
        )
        self.say(answer, **how)

    def give(self, offset, data, session=3, asked=Opcode.BURST_READ, complete=False):
        self.say(Packet(9, Opcode.ACK, session, len(data), asked, complete, offset, data))


def test_pieces_in_any_order_doubled_and_overlapping_make_the_file():
    script = Script()
    script.open(600)
    content = bytes(range(200)) * 3
    for start in (400, 0, 300, 0, 350, 100):
        assert script.reading.content is None
        script.give(start, content[start : start + MOST])
    assert script.reading.content == content


def test_a_piece_of_another_session_is_not_taken():
    script = Script()
    script.open(10)
    script.give(0, b"wrong file", session=4)
    assert script.reading.content is None
    script.give(0, b"right file")
    assert script.reading.content == b"right file"


def test_what_is_meant_for_somebody_else_or_said_by_him_is_not_taken():
    script = Script()
    script.open(10, to=(254, 190))
    script.open(10, encoder=Encoder(2, 191))
    assert len(script.asked) == 1
    script.open(10)
    assert script.asked[-1].opcode == Opcode.READ


def test_an_answer_to_an_earlier_reading_opens_nothing():
    script = Script(sequence=50)
    script.say(Packet(2, Opcode.ACK, 0, 4, Opcode.OPEN_RO, data=struct.pack("<I", 3)))
    assert [packet.opcode for packet in script.asked] == [Opcode.OPEN_RO]


def test_a_gap_in_a_burst_is_asked_for_alone():
    script = Script()
    script.open(3000)
    for start in [0, 478, *range(717, 3000, 239)]:
        script.give(start, bytes(min(239, 3000 - start)), complete=start > 2700)
    gap = script.asked[-1]
    assert (gap.opcode, gap.offset, gap.size) == (Opcode.READ, 239, 239)


def test_a_huge_file_is_not_fetched():
    script = Script()
    script.open(MOST_BYTES + 1)
    assert f"expected at most {MOST_BYTES} bytes" in script.reading.trouble
    assert len(script.asked) == 1


def test_more_than_was_announced_is_cut_off():
    script = Script()
    script.open(5)
    script.give(0, b"01234567")
    script.give(4_000_000_000, b"far beyond")
    assert script.reading.content == b"01234"


@given(st.lists(st.tuples(st.sampled_from([0, 4, 5, 15, 128, 129, 77]), st.binary(max_size=251)), max_size=20))
def test_whatever_a_server_says_nothing_breaks(answers):
    script = Script()
    for _opcode, payload in answers:
        message = message_of(Packet(0, 0), ComponentId(*US))
        message.payload = list(payload.ljust(251, b"\0"))
        for heard in script.decoder.feed(script.encoder.encode(message)):
            script.reading.on_packet(heard, 0.0)
        script.reading.tick(script.now)
    assert script.reading.content is None or len(script.reading.content) <= MOST_BYTES


# ------------------------------------------------------------------------------------------- metadata


def test_the_payload_tells_what_each_of_its_parameters_means(sky):
    rig = rig_of(sky)
    metadata = metadata_of(rig)
    assert rig.station.wait(30, lambda: metadata.over)
    assert metadata.note == ""
    assert set(metadata.described) == set(TABLE)
    assert all(row.min <= row.default <= row.max and row.description for row in metadata.described.values())


@pytest.mark.parametrize("seed", range(3))
def test_it_does_so_on_a_bad_link(sky, seed):
    rig = rig_of(sky, loss=0.2, doubled=0.2, delayed=0.2, seed=seed)
    metadata = metadata_of(rig)
    assert rig.station.wait(120, lambda: metadata.over)
    assert set(metadata.described) == set(TABLE), metadata.note


def test_a_file_whose_checksum_is_wrong_is_read_again_and_then_left_out(sky):
    rig = rig_of(sky, {PARAMETERS: files()[PARAMETERS].replace(b"EXP", b"XPE")})
    metadata = metadata_of(rig)
    assert rig.station.wait(60, lambda: metadata.over)
    assert metadata.note == "/parameter.json: its checksum is wrong"
    assert metadata.described == {}
    opened = [packet_of(m).data for _, m in rig.station.sent if m.get_type() == "FILE_TRANSFER_PROTOCOL"]
    assert opened.count(b"/parameter.json") == 3


class Teller:
    """A payload that answers the request for component metadata as it is told to."""

    def __init__(self):
        self.asked = []
        self.metadata = Metadata(self.asked.append, WHO, *US)
        self.encoder, self.decoder = Encoder(1, 191), Decoder()
        self.metadata.tick(0.0)

    def say(self, message):
        for packet in self.decoder.feed(self.encoder.encode(message)):
            self.metadata.on_packet(packet, 0.1)
        self.metadata.tick(60.0)


@pytest.mark.parametrize("result", [Result.DENIED, Result.UNSUPPORTED])
def test_a_payload_that_denies_the_request_is_not_asked_again(result):
    teller = Teller()
    teller.say(acknowledgement(512, result, ComponentId(*US)))
    assert (teller.metadata.over, len(teller.asked)) == (True, 1)
    assert teller.metadata.note == "the payload provides no parameter metadata"


@pytest.mark.parametrize(
    "answer", [(512, Result.ACCEPTED, *US), (512, Result.DENIED, 254, 190), (511, Result.DENIED, *US)]
)
def test_any_other_answer_leaves_it_asking(answer):
    teller = Teller()
    number, result, *to = answer
    teller.say(acknowledgement(number, result, ComponentId(*to)))
    assert (teller.metadata.over, len(teller.asked)) == (False, 2)


def test_a_place_that_is_not_ours_to_fetch_from_ends_with_a_note():
    teller = Teller()
    teller.say(ross.MAVLink_component_metadata_message(0, 7, b"https://example.org/general.json.xz"))
    assert teller.metadata.note == "https://example.org/general.json.xz: only mftp:// is fetched"
    assert len(teller.asked) == 1


def test_the_place_of_a_file_may_name_its_component():
    assert place_of("mftp://[;comp=191]/a.json", 1).path == "/a.json"


@pytest.mark.parametrize("uri", ["https://example.org/x", "file:///etc/passwd", "", None, 7, ["mftp:///x"]])
def test_no_other_place_is_looked_at(uri):
    assert isinstance(place_of(uri, 1), str)


HOSTILE = [
    b"",
    b"\xff\xfe\x00",
    b"[" * 500_000,
    b'{"a":' * 100_000,
    b"null",
    b"[]",
    b'{"parameters": 3}',
    b'{"parameters": {"name": "X"}}',
    b'{"parameters": [1, null, [], {"name": 3}, {"name": ["X"]}]}',
    b'{"metadataTypes": [{"type": 1}], "parameters": NaN}',
    b'{"metadataTypes": {"type": 1}}',
    b"1" * 10_000,
]


@pytest.mark.parametrize("content", HOSTILE, ids=range(len(HOSTILE)))
def test_a_hostile_file_describes_nothing_and_a_note_says_so(content):
    described, note = described_in(content)
    assert described == {}
    assert note
    assert isinstance(parameter_place(content), str)


def test_what_is_odd_in_a_description_is_left_out_and_the_rest_kept():
    row = {
        "name": "X", "default": "one", "min": float("nan"), "max": 10**400, "units": 7, "longDesc": ["x"],
        "shortDesc": "a\x1b[31m\n<b>b</b>", "group": None, "decimalPlaces": 0,
    }  # fmt: skip
    described, note = described_in(json.dumps({"parameters": [row, 3]}).encode())
    (told,) = described.values()
    assert (told.default, told.min, told.max, told.unit, told.group) == (None, None, None, "", "")
    assert told.description == "a [31m <b>b</b>", "plain text, whatever it looks like"
    assert note == "1 descriptions left out"


def test_no_text_is_endless_and_no_list():
    rows = [{"name": f"P{index}", "shortDesc": "x" * 1000} for index in range(1500)]
    described, note = described_in(json.dumps({"parameters": rows}).encode())
    assert len(described) == 1000
    assert max(len(told.description) for told in described.values()) == 500
    assert note == "500 descriptions left out"
