"""Recordings over MAVLink FTP: listed, checked and read to the byte, and nothing else; telemetry has its share."""

import logging
import os
import struct
import time
from itertools import count
from types import SimpleNamespace

import numpy as np
import pytest
from pymavlink import mavftp

from ross_payload.config import Config
from ross_payload.mavlink.component_info import files
from ross_payload.mavlink.ftp_server import AT_ONCE, FtpServer
from ross_payload.mavlink.recording_files import BLOCK, Recordings
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import ross
from ross_protocols.mavlink.ftp import Error, Opcode, Packet, checksum, message_of, packet_of

SESSION = "0001-20260101T120000Z"
AUDIO = np.random.default_rng(1).bytes(2 * BLOCK + 1234)
SPEED = 200_000.0  # [bytes/s]


class Payload:
    """A file server that offers a folder, and time in steps of 10 ms; the disk gets true time to answer."""

    def __init__(self, sky, folder, speed=SPEED, rate=float("inf"), claim=lambda link, size, wait: True):
        self.sky, self.clock, self.links, self.ground = sky, sky.clock, sky.links, sky.ground
        rates = dict.fromkeys(self.links.rates(), rate)
        self.server = FtpServer(
            self.links.component(191), files(), Recordings(folder, speed), lambda: rates, claim=claim
        )
        self.sequence = 0

    def wait(self, seconds):
        """Let time pass; return what the ground station hears."""
        return self.sky.wait(seconds, self.server)

    def ask(self, opcode, data=b"", **fields):
        """Ask, and let time pass until the first answer is there."""
        self.sequence += 1
        request = Packet(self.sequence, opcode, data=data, **({"size": len(data)} | fields))
        self.ground.send(message_of(request, ComponentId(1, 191)))
        end = time.monotonic() + 30
        while not (answers := [packet for each in self.wait(0.02) if (packet := packet_of(each)) is not None]):
            assert time.monotonic() < end, "no answer"
            time.sleep(0.001)  # the disk is another thread's
        return answers

    def go_on(self, seconds):
        """Let time pass, and ask for the next burst where one ends, as clients do; return the messages."""
        heard = []
        for _ in range(round(seconds * 20)):
            fresh = self.wait(0.05)
            heard += fresh
            for message, told in [(each, packet_of(each)) for each in fresh]:
                if told.burst_complete:
                    self.ground.mavlink.srcComponent = message.target_component
                    rest = Packet(told.sequence, Opcode.BURST_READ, size=239, offset=told.offset + len(told.data))
                    self.ground.send(message_of(rest, ComponentId(1, 191)))
        return heard

    def listed(self, name):
        """List a folder as a client does, from entry to entry."""
        entries = []
        while True:
            (answer,) = self.ask(Opcode.LIST, name, offset=len(entries))
            if answer.opcode == Opcode.NAK:
                assert answer.data == bytes([Error.END_OF_FILE])
                return entries
            entries += answer.data.rstrip(b"\0").split(b"\0")


@pytest.fixture
def folder(tmp_path):
    session = tmp_path / "recordings" / SESSION
    session.mkdir(parents=True)
    (session / "audio.wav").write_bytes(AUDIO)
    (session / "empty.jsonl").write_bytes(b"")
    (session / ".config.json.part").write_bytes(b"half")
    (session / "link.wav").symlink_to(tmp_path / "secret")
    os.mkfifo(session / "pipe.wav")
    (tmp_path / "secret").write_bytes(b"secret")
    (tmp_path / "recordings" / "0002").symlink_to(tmp_path)
    (tmp_path / "recordings" / "private").mkdir()
    (tmp_path / "recordings" / "private" / "diary.txt").write_bytes(b"secret")
    return tmp_path / "recordings"


@pytest.fixture
def payload(sky, folder):
    return Payload(sky(), folder)


PATH = f"recordings/{SESSION}/audio.wav".encode()


def test_a_folder_that_is_listed_without_end_keeps_telemetry_waiting_for_its_share_only(sky, folder):
    waits = []
    payload = Payload(sky(), folder, rate=350, claim=lambda link, size, wait: waits.append(wait) or True)
    for number in range(20):
        payload.ask(Opcode.LIST, b"recordings", session=number % 2)
    assert len(waits) == 20
    assert waits[0]
    assert 0 < sum(waits) < 10


def test_sessions_and_their_files_are_listed_and_nothing_else(payload):
    assert b"Drecordings" in payload.listed(b"/")
    assert payload.listed(b"/recordings") == [b"D" + SESSION.encode()]
    assert payload.listed(f"recordings/{SESSION}".encode()) == [b"Faudio.wav\t%d" % len(AUDIO), b"Fempty.jsonl\t0"]


def test_a_long_folder_is_listed_in_portions(payload, folder):
    for number in range(100):
        (folder / f"{number + 1000}-20260101T120000Z").mkdir()
    assert len(payload.listed(b"recordings")) == 101


def test_a_recording_is_checked_and_read_in_a_burst_to_the_byte(payload):
    (answer,) = payload.ask(Opcode.CRC32, PATH)
    assert struct.unpack("<I", answer.data) == (checksum(AUDIO),)
    (answer,) = payload.ask(Opcode.OPEN_RO, b"/" + PATH)
    assert struct.unpack("<I", answer.data) == (len(AUDIO),)
    answers, end = payload.ask(Opcode.BURST_READ, size=239), time.monotonic() + 60
    while not answers[-1].burst_complete:
        assert time.monotonic() < end
        time.sleep(0.0005)
        answers += [packet_of(message) for message in payload.wait(0.05)]
    assert b"".join(answer.data for answer in answers) == AUDIO


def test_a_recording_is_read_piece_by_piece(payload):
    payload.ask(Opcode.OPEN_RO, PATH)
    for offset in (0, BLOCK - 100, 2 * BLOCK, len(AUDIO) - 10):
        (answer,) = payload.ask(Opcode.READ, size=200, offset=offset)
        assert (answer.offset, answer.data) == (offset, AUDIO[offset : offset + 200])
    (answer,) = payload.ask(Opcode.READ, size=200, offset=len(AUDIO))
    assert (answer.opcode, answer.data) == (Opcode.NAK, bytes([Error.END_OF_FILE]))


@pytest.mark.parametrize(
    "name",
    [
        b"recordings/../secret",
        b"recordings/%s/../../secret" % SESSION.encode(),
        b"recordings/%s/.config.json.part" % SESSION.encode(),
        b"recordings/%s/link.wav" % SESSION.encode(),
        b"recordings/%s/pipe.wav" % SESSION.encode(),
        b"recordings/0002/secret",
        b"recordings/private/diary.txt",
        b"recordings//etc/passwd",
        b"recordings/%s" % SESSION.encode(),
        b"recordings/%s/\xff\xfe.wav" % SESSION.encode(),
        b"/etc/passwd",
        b"recordings",
    ],
)
@pytest.mark.parametrize("opcode", [Opcode.OPEN_RO, Opcode.CRC32])
def test_nothing_but_files_of_sessions_is_read(payload, opcode, name):
    (answer,) = payload.ask(opcode, name)
    assert (answer.opcode, answer.data) == (Opcode.NAK, bytes([Error.FILE_NOT_FOUND]))


@pytest.mark.parametrize(
    "name", [b"recordings/..", b"recordings/private", b"recordings/0002", b"..", b"recordings/x/y"]
)
def test_nothing_but_sessions_is_listed(payload, name):
    (answer,) = payload.ask(Opcode.LIST, name)
    assert (answer.opcode, answer.data) == (Opcode.NAK, bytes([Error.FILE_NOT_FOUND]))


def test_a_download_takes_half_of_what_its_link_may_carry(sky, folder):
    payload = Payload(sky(), folder, rate=2880.0)
    payload.ask(Opcode.OPEN_RO, PATH)
    size = sum(len(answer.data) + 24 for answer in payload.ask(Opcode.BURST_READ, size=239))
    while not size:
        size += sum(len(packet_of(message).data) + 24 for message in payload.wait(0.01))
    told = [packet_of(message) for message in payload.go_on(20.0)]
    assert 0.8 * 1440 < sum(len(answer.data) + 24 for answer in told) / 20.0 < 1.05 * 1440


def test_a_download_is_as_fast_as_it_may_be(sky, folder):
    payload = Payload(sky(), folder, speed=100_000.0)
    payload.ask(Opcode.OPEN_RO, PATH)
    payload.ask(Opcode.READ, size=10)  # the first block is here
    payload.ground.send(message_of(Packet(7, Opcode.BURST_READ, size=239), ComponentId(1, 191)))
    told = [packet_of(message) for message in payload.wait(0.5)]
    assert 0.95 * 50_000 < sum(len(answer.data) + 24 for answer in told) < 1.15 * 50_000


def test_a_burst_goes_on_while_its_gaps_are_read(payload):
    payload.ask(Opcode.OPEN_RO, PATH)
    payload.ask(Opcode.READ, size=10)  # the first block is here
    payload.ground.send(message_of(Packet(7, Opcode.BURST_READ, size=239), ComponentId(1, 191)))
    told = [packet_of(message) for message in payload.wait(0.1)]
    for number, offset in enumerate((239, 717)):
        payload.ground.send(message_of(Packet(900 + number, Opcode.READ, size=239, offset=offset), ComponentId(1, 191)))
    told += [packet_of(message) for message in payload.wait(0.1)]
    assert [(each.sequence, each.offset) for each in told if each.asked == Opcode.READ] == [(901, 239), (902, 717)]
    burst = [each.offset for each in told if each.asked == Opcode.BURST_READ]
    assert burst == list(range(0, len(burst) * 239, 239))
    assert len(burst) > 150


def test_a_burst_that_is_asked_to_go_on_goes_on_and_whoever_asks_twice_has_lost_what_is_there(sky, folder):
    payload = Payload(sky(), folder, speed=5000.0)
    payload.ask(Opcode.OPEN_RO, PATH)
    payload.ask(Opcode.READ, size=10)  # the first block is here
    payload.ground.send(message_of(Packet(7, Opcode.BURST_READ, size=239), ComponentId(1, 191)))
    told = [packet_of(message) for message in payload.wait(2.0)]
    offset = told[-3].offset  # two more are under way
    again = message_of(Packet(900, Opcode.BURST_READ, size=239, offset=offset), ComponentId(1, 191))
    payload.ground.send(again)
    more = [packet_of(message) for message in payload.wait(2.0)]
    assert [each.offset for each in told + more] == list(range(0, len(told + more) * 239, 239))
    assert more[0].sequence == 901
    payload.ground.send(again)
    assert packet_of(payload.wait(0.2)[0]).offset == offset


def test_a_burst_for_a_client_that_has_gone_ends(sky, folder):
    payload = Payload(sky(), folder, speed=5000.0)
    payload.ask(Opcode.OPEN_RO, PATH)
    payload.ask(Opcode.READ, size=10)  # the first block is here
    payload.ground.send(message_of(Packet(7, Opcode.BURST_READ, size=239), ComponentId(1, 191)))
    told = [packet_of(message) for message in payload.wait(3.0)]
    assert [answer.burst_complete for answer in told] == [False] * (len(told) - 1) + [True]
    assert all(len(answer.data) == 239 for answer in told), "a shorter portion would be the end of the file"
    assert payload.wait(10.0) == []


def test_many_readers_share_what_one_may_take(sky, folder):
    payload = Payload(sky(), folder, speed=10_000.0)
    voice = payload.ground.mavlink
    for number in range(4):
        voice.srcComponent = 190 + number
        payload.ask(Opcode.OPEN_RO, PATH)
        payload.ask(Opcode.READ, size=10)  # the first block is here
    for number in range(4):
        voice.srcComponent = 190 + number
        payload.ground.send(message_of(Packet(7, Opcode.BURST_READ, size=239), ComponentId(1, 191)))
    sizes = dict.fromkeys(range(190, 194), 0)
    for message in payload.go_on(10.0):
        sizes[message.target_component] += len(packet_of(message).data) + 24
    assert 9.5 * 10_000 < sum(sizes.values()) < 10.5 * 10_000
    assert min(sizes.values()) > 0.5 * max(sizes.values())


def test_many_readers_hold_the_pump_up_no_longer_than_one(sky, folder):
    payload = Payload(sky(), folder, speed=1_000_000.0)
    for session in range(4):
        payload.ask(Opcode.OPEN_RO, PATH, session=session)
        payload.ask(Opcode.READ, size=10, session=session)  # the first block is here
    for session in range(4):
        request = Packet(7, Opcode.BURST_READ, session=session, size=239)
        payload.ground.send(message_of(request, ComponentId(1, 191)))
    told = [packet_of(message) for message in payload.wait(0.1)]
    assert len(told) == 10 * AT_ONCE
    assert {answer.session for answer in told} == set(range(4))


def test_one_line_of_the_log_tells_of_a_download(payload, caplog):
    caplog.set_level(logging.INFO)
    payload.ask(Opcode.OPEN_RO, PATH)
    for _ in range(5):
        payload.ask(Opcode.READ, size=200)
    (line,) = [record.getMessage() for record in caplog.records if "FTP" in record.getMessage()]
    assert line.startswith(f"MAVLink FTP: 255/190 reads recordings/{SESSION}/audio.wav (0.1 MB) over ")


def test_who_may_not_order_lists_nothing(sky, folder):
    payload = Payload(sky(accept=(250,)), folder)
    payload.ground.send(message_of(Packet(1, Opcode.LIST, size=1, data=b"/"), ComponentId(1, 191)))
    assert payload.wait(1.0) == []


def test_nothing_is_offered_unless_it_is_asked_for():
    assert not Config().recording.offer_ftp


@pytest.mark.soak
def test_pymavlinks_own_client_lists_and_fetches_a_recording(payload, tmp_path, monkeypatch):
    late, calls = [], count()
    slow = SimpleNamespace(time=lambda: next(calls) * 1e-6, sleep=time.sleep)  # it gives up after seconds
    monkeypatch.setattr(mavftp, "time", slow)

    def send(network, system, component, content):
        payload.ground.send(ross.MAVLink_file_transfer_protocol_message(network, system, component, list(content)))

    def recv_match(**_):
        time.sleep(0.0005)
        late.extend(message for message in payload.wait(0.05) if message.get_type() == "FILE_TRANSFER_PROTOCOL")
        return late.pop(0) if late else None

    mav = SimpleNamespace(file_transfer_protocol_send=send)
    client = mavftp.MAVFTP(
        SimpleNamespace(mav=mav, recv_match=recv_match, source_system=255, source_component=190), 1, 191
    )
    assert client.cmd_get([PATH.decode(), str(tmp_path / "got.wav")]).error_code == 0
    client.process_ftp_reply("OpenFileRO", timeout=120)
    assert (tmp_path / "got.wav").read_bytes() == AUDIO
