"""Files over the air: component metadata, read by hand and by pymavlink's own client."""

import json
import struct
from types import SimpleNamespace

import numpy as np
import pytest
from pymavlink import mavftp

from ross_payload.config.parameter_table import TABLE
from ross_payload.mavlink.component_info import GENERAL, PARAMETERS, files, metadata_message
from ross_payload.mavlink.ftp_server import SESSIONS, FtpServer
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import ross
from ross_protocols.mavlink.ftp import Error, Opcode, Packet, checksum, message_of, packet_of
from ross_protocols.mavlink.params import NAME_SIZE


class Payload:
    """A file server, and time in steps of 10 ms."""

    def __init__(self, sky, content):
        self.sky, self.clock, self.ground = sky, sky.clock, sky.ground
        self.server = FtpServer(sky.links.component(191), content)

    def wait(self, seconds):
        """Let time pass; return the messages that the ground station hears."""
        return self.sky.wait(seconds, self.server)

    def ask(self, opcode, data=b"", seconds=0.05, target=(1, 191), **fields):
        request = Packet(7, opcode, data=data, **({"size": len(data)} | fields))
        self.ground.send(message_of(request, ComponentId(*target)))
        return [packet_of(message) for message in self.wait(seconds)]


@pytest.fixture
def payload(sky):
    return Payload(sky(), files() | {"long.bin": bytes(range(256)) * 20})


def opened(payload, name):
    (answer,) = payload.ask(Opcode.OPEN_RO, name.encode())
    assert answer.opcode == Opcode.ACK
    return struct.unpack("<I", answer.data)[0]


def test_an_open_file_tells_its_size_and_the_answer_what_it_answers(payload):
    (answer,) = payload.ask(Opcode.OPEN_RO, b"/general.json")
    assert (answer.sequence, answer.asked) == (8, Opcode.OPEN_RO)
    assert struct.unpack("<I", answer.data) == (len(files()[GENERAL]),)


def test_who_may_not_order_may_not_read_either(sky):
    payload = Payload(sky(accept=(250,)), files())
    assert payload.ask(Opcode.OPEN_RO, b"/general.json") == []


def test_a_file_is_read_piece_by_piece_to_its_end(payload):
    size, content = opened(payload, "long.bin"), b""
    while len(content) < size:
        (answer,) = payload.ask(Opcode.READ, size=200, offset=len(content))
        assert answer.offset == len(content)
        content += answer.data
    assert content == bytes(range(256)) * 20
    (end,) = payload.ask(Opcode.READ, size=200, offset=size)
    assert (end.opcode, end.data) == (Opcode.NAK, bytes([Error.END_OF_FILE]))


def test_a_burst_sends_the_rest_and_says_which_is_the_last(payload):
    opened(payload, "long.bin")
    answers = payload.ask(Opcode.BURST_READ, size=239, offset=20, seconds=4.0)
    assert b"".join(answer.data for answer in answers) == (bytes(range(256)) * 20)[20:]
    assert [answer.burst_complete for answer in answers] == [False] * (len(answers) - 1) + [True]
    assert [answer.sequence for answer in answers] == list(range(8, 8 + len(answers)))


def test_the_sessions_of_one_client_do_not_mix(payload):
    """MAVProxy fetches five files at once, each in a session whose number it chooses."""
    for session, name in ((17, b"long.bin"), (18, b"general.json")):
        (answer,) = payload.ask(Opcode.OPEN_RO, name, session=session)
        assert (answer.opcode, answer.session) == (Opcode.ACK, session)
    (first,) = payload.ask(Opcode.READ, session=17, size=50)
    (second,) = payload.ask(Opcode.READ, session=18, size=50)
    assert (first.data, second.data) == (bytes(range(50)), files()[GENERAL][:50])
    payload.ask(Opcode.TERMINATE, session=18)
    (first,) = payload.ask(Opcode.READ, session=17, size=50, offset=50)
    assert first.data == bytes(range(50, 100))
    payload.ask(Opcode.RESET, session=3)
    (gone,) = payload.ask(Opcode.READ, session=17, size=50)
    assert (gone.opcode, gone.data) == (Opcode.NAK, bytes([Error.INVALID_SESSION]))


def test_a_file_that_is_read_stays_open_while_others_open_files_and_vanish(payload):
    """Every run of a script on a port of its own is a client of its own."""
    opened(payload, "long.bin")
    for session in range(1, 2 * SESSIONS):
        payload.ask(Opcode.OPEN_RO, b"general.json", session=session)
        (answer,) = payload.ask(Opcode.READ, size=50, offset=session)
        assert (answer.opcode, len(answer.data)) == (Opcode.ACK, 50)


def test_a_burst_leaves_a_slow_link_half_of_its_line(payload):
    opened(payload, "long.bin")
    assert sum(len(answer.data) + 24 for answer in payload.ask(Opcode.BURST_READ, size=239, seconds=1.0)) < 3000


@pytest.mark.parametrize(
    ("opcode", "fields", "error"),
    [
        (Opcode.OPEN_RO, {"data": b"../../etc/passwd"}, Error.FILE_NOT_FOUND),
        (Opcode.OPEN_RO, {"data": b""}, Error.FILE_NOT_FOUND),
        (Opcode.READ, {"size": 10}, Error.INVALID_SESSION),
        (Opcode.BURST_READ, {"size": 10}, Error.INVALID_SESSION),
        (6, {"data": b"new.txt"}, Error.UNKNOWN_COMMAND),
        (3, {"data": b"/"}, Error.UNKNOWN_COMMAND),
    ],
)
def test_what_is_not_served_is_refused_with_its_error(payload, opcode, fields, error):
    (answer,) = payload.ask(opcode, **fields)
    assert (answer.opcode, answer.asked, answer.data) == (Opcode.NAK, opcode, bytes([error]))


@pytest.mark.parametrize("opcode", [Opcode.TERMINATE, Opcode.RESET])
def test_a_closed_file_is_closed(payload, opcode):
    opened(payload, GENERAL)
    assert payload.ask(opcode)[0].opcode == Opcode.ACK
    assert payload.ask(Opcode.READ, size=10)[0].opcode == Opcode.NAK


@pytest.mark.parametrize("target", [(0, 0), (1, 0), (1, 1), (2, 191)])
def test_requests_to_all_or_to_others_pass_by(payload, target):
    assert payload.ask(Opcode.OPEN_RO, GENERAL.encode(), target=target) == []


def test_anything_in_the_251_bytes_raises_nothing(payload):
    rng = np.random.default_rng(1)
    opened(payload, "long.bin")
    for _ in range(500):
        message = message_of(Packet(0, 0), ComponentId(1, 191))
        message.payload = [int(byte) for byte in rng.integers(0, 256, 251)]
        message.payload[3] = int(rng.choice([1, 2, 4, 5, 15, 128, 129, 77]))
        payload.ground.send(message)
        payload.wait(0.05)


# ------------------------------------------------------------------------------------------- metadata


def test_general_names_the_parameter_file_and_its_checksum():
    content = files()
    (entry,) = json.loads(content[GENERAL])["metadataTypes"]
    assert entry == {"type": 1, "uri": "mftp:///parameter.json", "fileCrc": checksum(content[PARAMETERS])}


def test_every_parameter_is_described_within_its_bounds():
    described = json.loads(files()[PARAMETERS])["parameters"]
    assert [row["name"] for row in described] == list(TABLE)
    assert all(row["min"] <= row["default"] <= row["max"] and len(row["name"]) <= NAME_SIZE for row in described)


def test_the_message_points_to_general():
    message = metadata_message(files(), now=2.5)
    assert message.time_boot_ms == 2500
    assert message.uri == "mftp:///general.json"
    assert message.file_crc == checksum(files()[GENERAL])


@pytest.mark.parametrize("odds", [{}, {"loss": 0.1}], ids=["good", "bad"])
def test_pymavlinks_own_client_reads_the_files(sky, tmp_path, monkeypatch, odds):
    content = files() | {"portions.bin": bytes(range(160))}  # it asks for 80 at once
    payload, late = Payload(sky(**odds), content), []
    monkeypatch.setattr(mavftp, "time", SimpleNamespace(time=payload.clock.now, sleep=payload.wait))

    def send(network, system, component, data):
        payload.ground.send(ross.MAVLink_file_transfer_protocol_message(network, system, component, list(data)))

    def recv_match(**_):
        late.extend(message for message in payload.wait(0.05) if message.get_type() == "FILE_TRANSFER_PROTOCOL")
        return late.pop(0) if late else None

    master = SimpleNamespace(
        mav=SimpleNamespace(file_transfer_protocol_send=send),
        recv_match=recv_match,
        source_system=255,
        source_component=190,
    )
    client = mavftp.MAVFTP(master, 1, 191)
    for name, data in content.items():
        assert client.cmd_get([name, str(tmp_path / name)]).error_code == 0
        client.process_ftp_reply("OpenFileRO", timeout=20)
        assert (tmp_path / name).read_bytes() == data
