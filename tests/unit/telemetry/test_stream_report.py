"""Live listening in telemetry: whoever follows a payload sees who can hear it, wherever the messages go."""

import math
from dataclasses import replace

import pytest

from ross_payload.config import Link
from ross_payload.ground.client.ftp_client import FileReader
from ross_payload.health import RecordingState, RecordingStatus
from ross_payload.streams import Selection, StreamStatus, What
from ross_protocols.mavlink import values as v
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import ross
from ross_protocols.mavlink.stream_values import Codec, StreamReport
from ross_protocols.mavlink.stream_values import Selection as Selected
from ross_protocols.mavlink.tunnel import unwrap

GROUND = Link(url="udpout:127.0.0.1:14550")
AUTOPILOT = Link(url="udpout:127.0.0.1:14552", role="autopilot")
RTP = StreamStatus(
    0, "rtp", Selection(What.SOURCE, source=2), on=True, rate=48000, codec="opus", address="192.168.1.20", port=5004,
    separated=True, source=2, group=1, azimuth=0.5, gain_db=-6.0, level_db=-23.4, delay=0.1204, lost=960,
    packets_lost=3,
)  # fmt: skip
FILE = StreamStatus(
    1, "file", Selection(), on=True, rate=16000, codec="flac", address="target.flac", keeps=True,
    detail="no target yet",
)  # fmt: skip
OFF = replace(RTP, on=False, level_db=None, delay=None, separated=False, source=None, group=None, azimuth=None)


class Stage:
    """A listening stage whose streams the test sets."""

    def __init__(self, *streams):
        self.now = streams
        self.ordered = []

    def streams(self):
        return self.now

    def order(self, order):
        self.ordered.append(order)
        return ""


class Recorder:
    """A recorder that records."""

    def record(self, on):
        return ""

    def status(self):
        return RecordingStatus(RecordingState.ON, "x")


def latest(port):
    """The latest report of every stream, by number."""
    return {report.number: report for report in port.values(StreamReport)}


def test_every_stream_is_told_with_all_that_is_known_of_it(aloft):
    with aloft(GROUND, listening=Stage(RTP, FILE)) as sky:
        sky.telemetry.on_input(sky.hop())
        sky.live(1.0)
    rtp, kept = latest(sky.ports[0])[0], latest(sky.ports[0])[1]
    assert (rtp.sink, rtp.selection, rtp.source, rtp.group) == ("rtp", Selected.SOURCE, 2, 1)
    assert (rtp.address, rtp.port, rtp.codec, rtp.rate) == ("192.168.1.20", 5004, Codec.OPUS, 48000)
    assert (rtp.level, rtp.delay, rtp.lost, rtp.packets_lost) == (-23.0, 0.12, 960, 3)
    assert (rtp.azimuth, rtp.gain, rtp.listeners) == (pytest.approx(0.5), -6.0, None)
    assert (rtp.on, rtp.separated, rtp.records, rtp.muted, rtp.fault) == (True, True, False, False, False)
    assert (kept.sink, kept.codec, kept.address, kept.port) == ("file", Codec.FLAC, "target.flac", 0)
    assert (kept.on, kept.records, kept.separated, kept.detail) == (True, True, False, "no target yet")
    assert {rtp.count, kept.count} == {2}


def test_a_change_is_told_within_a_fifth_of_a_second_and_everything_every_five(aloft):
    stage = Stage(OFF)
    with aloft(GROUND, listening=stage) as sky:
        (port,) = sky.ports
        sky.live(11.0)
        assert len(port.values(StreamReport)) == 3
        before = len(port.values(StreamReport))
        stage.now = (RTP,)
        sky.live(0.2)
        (report,) = port.values(StreamReport)[before:]
        assert report.on


def test_levels_and_delays_are_no_change(aloft):
    stage = Stage(RTP)
    with aloft(GROUND, listening=stage) as sky:
        for step in range(20):
            stage.now = (replace(RTP, level_db=-20.0 - step, delay=0.1 + 0.01 * step, lost=step, azimuth=0.01 * step),)
            sky.live(0.1)
    assert len(sky.ports[0].values(StreamReport)) <= 2
    assert "".join(sky.ports[0].texts()).count("stream 0") == 1


@pytest.mark.parametrize(
    ("fault", "told"),
    [
        ("rtp to 192.168.100.200 port 50004: no receiver at this port", "no receiver at this port"),
        ("recordings/heard-2.flac: cannot be made: No space left on device", "No space left on device"),
        ("noise.wav/target.flac: cannot be made: Not a directory", "Not a directory"),
        ("tcp:127.0.0.1:5010: the listener is gone: it is more than 1 s behind", "the listener is gone"),
        ("the sound output 'default' cannot be opened: Invalid sample rate", "Invalid sample rate"),
        ("device: no sound output named 'x'; there are: none at all", "..no sound output named"),
        ("the sink raised ZeroDivisionError: division by zero", "division by zero"),
        ("x" * 300, ".." + "x" * 22),
        ("", ""),
    ],
)
def test_what_the_message_has_room_for_is_the_cause(aloft, fault, told):
    stage = Stage(replace(RTP, fault=fault))
    with aloft(GROUND, listening=stage) as sky:
        sky.live(1.0)
    assert latest(sky.ports[0])[0].detail == told
    assert not fault or f"stream 0 fault: {fault}"[:50] in "".join(sky.ports[0].texts())


def test_who_is_told_that_a_stream_ended_is_told_why(aloft):
    stage = Stage(RTP)
    with aloft(GROUND, listening=stage) as sky:
        sky.live(1.0)
        stage.now = (replace(OFF, listeners=0, detail="no listener for 25 s"),)
        sky.live(1.0)
    report = latest(sky.ports[0])[0]
    assert (report.on, report.listeners, report.detail) == (False, 0, "no listener for 25 s")
    assert "stream 0 off: no listener for 25 s" in "".join(sky.ports[0].texts())


def test_a_stream_that_has_ended_is_told_as_off(aloft):
    stage = Stage(RTP)
    with aloft(GROUND, listening=stage) as sky:
        sky.live(1.0)
        stage.now = (OFF,)
        sky.live(0.2)
        report = latest(sky.ports[0])[0]
        late = aloft.Port()
        sky.links.attach(Link(url="udpout:127.0.0.1:14559"), late)
        sky.live(0.2)
    assert not report.on
    assert not latest(late)[0].on
    assert report.source == 2, "what it was to carry"


def test_an_autopilot_hands_on_the_longest_report(aloft):
    longest = replace(
        RTP, number=254, sink="s" * 10, address="a" * 40, detail="d" * 24, port=65535, lost=2**32 - 1, rate=2**32 - 1,
        listeners=254, packets_lost=2**32 - 2, codec="opus",
    )  # fmt: skip
    with aloft(AUTOPILOT, listening=Stage(longest)) as sky:
        sky.live(1.0)
    inside = [unwrap(packet.message) for packet in sky.ports[0].packets if packet.name == "TUNNEL"]
    report = next(packet.value for packet in inside if packet.name == "ROSS_STREAM")
    assert (report.number, report.count, report.address, report.detail) == (254, 255, "a" * 40, "d" * 24)


def test_a_slow_link_still_tells_all_else_beside_many_streams(aloft):
    streams = tuple(replace(RTP, number=number, port=5004 + number) for number in range(6))
    with aloft(Link(url="udpout:127.0.0.1:14551", max_bytes_s=350), listening=Stage(*streams)) as sky:
        sky.live(20.0)
    (port,) = sky.ports
    assert set(latest(port)) == set(range(6))
    assert len(port.values(v.Heartbeat)) == pytest.approx(20, abs=1)
    assert len(port.values(v.Status)) >= 15
    assert len(port.values(v.Information)) >= 2
    assert port.values(v.LinkReport)


def test_numbers_beyond_their_fields_do_not_stop_telemetry(aloft):
    wild = replace(RTP, level_db=-400.0, delay=1e6, lost=2**40, packets_lost=2**40, listeners=10_000, gain_db=1e300)
    with aloft(GROUND, listening=Stage(wild)) as sky:
        sky.live(1.0)
    report = latest(sky.ports[0])[0]
    assert (report.level, report.delay, report.listeners) == (-128.0, 65.534, 254)


# ------------------------------------------------------------------------------------------- whether anybody hears


@pytest.mark.parametrize(
    ("streams", "streaming", "recording"),
    [
        ((), False, False),
        ((OFF,), False, False),
        ((RTP,), True, False),  # RTP: any number may listen
        ((replace(RTP, listeners=0),), False, False),  # TCP, waiting
        ((replace(RTP, listeners=1),), True, False),
        ((FILE,), False, True),
        ((replace(FILE, on=False),), False, False),
        ((RTP, FILE), True, True),
    ],
)
def test_the_status_says_whether_anybody_listens_or_records(aloft, streams, streaming, recording):
    with aloft(GROUND, listening=Stage(*streams)) as sky:
        sky.live(0.6)
    status = sky.ports[0].values(v.Status)[-1]
    assert (status.streaming, status.recording) == (streaming, recording)


def test_the_recorder_records_too(aloft):
    with aloft(GROUND, recorder=Recorder()) as sky:
        sky.live(1.6)
    assert sky.ports[0].values(v.Status)[-1].recording


def test_start_change_fault_and_end_are_said_in_words(aloft):
    stage = Stage()
    with aloft(GROUND, listening=stage) as sky:
        for streams in (
            (RTP,),
            (replace(RTP, selection=Selection(What.AZIMUTH, azimuth=-math.pi / 2)),),
            (replace(RTP, selection=Selection(What.AZIMUTH, azimuth=-math.pi / 2), fault="network unreachable"),),
            (replace(RTP, selection=Selection(What.AZIMUTH, azimuth=-math.pi / 2)),),
            (OFF,),
        ):
            stage.now = streams
            sky.live(2.1)
    assert sky.ports[0].texts() == [
        "RoSS: stream 0 on: source 2 to 192.168.1.20:5004 (", "rtp, opus)",
        "RoSS: stream 0 on: azimuth 90 deg to 192.168.1.20:", "5004 (rtp, opus)",
        "RoSS: stream 0 fault: network unreachable",
        "RoSS: stream 0 recovered",
        "RoSS: stream 0 off",
    ]  # fmt: skip


def test_a_stream_is_said_to_be_on_when_its_address_is_known(aloft):
    stage = Stage(replace(RTP, address="", port=0, codec=""))
    with aloft(GROUND, listening=stage) as sky:
        sky.live(0.5)
        assert sky.ports[0].texts() == []
        stage.now = (RTP,)
        sky.live(0.5)
    assert "".join(sky.ports[0].texts()) == "RoSS: stream 0 on: source 2 to 192.168.1.20:5004 (rtp, opus)"


def test_an_order_over_the_air_reaches_the_listening_stage(aloft):
    stage = Stage()
    with aloft(GROUND, listening=stage, give=lambda order: None) as sky:
        command = ross.MAVLink_command_long_message(
            1, 191, ross.MAV_CMD_ROSS_STREAM, 0, -1, 2, 0, math.nan, 127 * 256, 1, 5004 + 2 * 65536
        )
        sky.ports[0].call(command)
        sky.live(0.1)
    (order,) = stage.ordered
    assert (order.on, order.address, order.port, order.codec) == (True, "127.0.0.1", 5004, "opus")


def test_without_a_listening_stage_an_order_is_refused_in_words(aloft):
    with aloft(GROUND, give=lambda order: None) as sky:
        command = ross.MAVLink_command_long_message(
            1, 191, ross.MAV_CMD_ROSS_STREAM, 0, -1, 2, 0, math.nan, 127 * 256, 1, 5004
        )
        sky.ports[0].call(command)
        sky.live(0.3)
    (answer,) = sky.ports[0].messages("COMMAND_ACK")
    assert answer.result == 4
    assert "".join(sky.ports[0].texts()) == "RoSS: stream refused: this payload has no live listening"
    assert sky.ports[0].values(StreamReport) == []


# ------------------------------------------------------------------------------------------- session descriptions


def read(sky, port, name, seconds=3.0):
    """Read a file over MAVLink FTP; its content, or why it cannot be had."""
    reader, seen = FileReader(port.call, ComponentId(1, 191), ComponentId(255, 190), name), len(port.packets)
    for _ in range(round(seconds * 10)):
        reader.tick(sky.clock.now())
        sky.live(0.1)
        for packet in port.packets[seen:]:
            reader.on_packet(packet, sky.clock.now())
        seen = len(port.packets)
        if reader.over:
            break
    return reader.content or reader.trouble


def test_session_descriptions_are_offered_as_files_as_long_as_there_are_such_streams(aloft):
    texts = {0: "v=0\r\ns=one\r\n" * 50, 1: ""}
    with aloft(GROUND, listening=Stage(RTP), descriptions=lambda: texts, give=lambda order: None) as sky:
        (port,) = sky.ports
        assert read(sky, port, "/stream-0.sdp") == texts[0].encode()
        assert read(sky, port, "/stream-1.sdp") == "/stream-1.sdp: there is no such file"
        del texts[0]
        assert read(sky, port, "/stream-0.sdp") == "/stream-0.sdp: there is no such file"
        assert read(sky, port, "/general.json", seconds=30.0).startswith(b"{")
