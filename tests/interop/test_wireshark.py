"""What tshark makes of our frames with the dissector that is checked in."""

import json
import math
import shutil
import struct
import subprocess
from dataclasses import replace

import pytest

import alignments
from ross_protocols.mavlink import vehicle_control
from ross_protocols.mavlink.codec import Encoder
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.stream_values import Codec, Selection, StreamReport
from ross_protocols.mavlink.tunnel import Wrapper
from ross_protocols.mavlink.values import Audio, Health, Heartbeat, Status

pytestmark = pytest.mark.process

RAW_IP = 101  # the link type of a capture without Ethernet
LOOPBACK = bytes([127, 0, 0, 1])
ALIGNMENT = replace(alignments.ALIGNMENT, heading=-math.pi / 2)


def capture(path, datagrams, port):
    """Write UDP datagrams as a capture file, one a second."""
    data = struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, RAW_IP)
    for second, datagram in enumerate(datagrams):
        udp = struct.pack(">HHHH", 40000, port, 8 + len(datagram), 0) + datagram
        ip = struct.pack(">BBHHHBBH4s4s", 0x45, 0, 20 + len(udp), second, 0, 64, 17, 0, LOOPBACK, LOOPBACK) + udp
        data += struct.pack("<IIII", second, 0, len(ip), len(ip)) + ip
    path.write_bytes(data)


@pytest.fixture
def tshark(request, tmp_path):
    """Run tshark over datagrams, with more arguments; what it prints."""
    if shutil.which("tshark") is None:
        pytest.skip("needs the Debian package tshark")
    script = request.config.rootpath / "protocols" / "wireshark" / "ross.lua"

    def run(datagrams, *arguments, port=14550):
        path = tmp_path / "capture.pcap"
        capture(path, datagrams, port)
        command = ["tshark", "-X", f"lua_script:{script}", "-r", path, *arguments]
        done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
        assert "lua" not in done.stderr.lower(), done.stderr
        return done.stdout

    return run


@pytest.fixture
def fields(tshark):
    """The values of some fields, frame by frame."""

    def read(datagrams, *names, port=14550):
        wanted = [part for name in names for part in ("-e", f"mavlink_proto.{name}")]
        lines = tshark(datagrams, "-T", "fields", *wanted, port=port).splitlines()
        return [line.split("\t") for line in lines]

    return read


@pytest.fixture
def encoder():
    return Encoder(7, 191)


def test_numbers_are_those_that_were_sent(fields, encoder):
    names = ["heading", "joint", "isolation", "gain", "aliased", "plan", "time_usec"]
    read = fields([encoder.encode(ALIGNMENT)], "sysid", *(f"ROSS_ALIGNMENT_{name}" for name in names))
    system, *numbers = [float(text) if "x" not in text else int(text, 16) for text in read[0]]
    assert system == 7
    assert numbers == pytest.approx([math.pi / 2, -0.25, 125.0, 3.5, 0b110, 3, 5e6], rel=1e-5)


@pytest.mark.soak
def test_a_stream_of_live_listening_is_shown_with_its_address_also_inside_a_tunnel(tshark, encoder):
    stream = StreamReport(
        1, 3, 4, "rtp", Selection.SOURCE, True, 48000, on=True, source=2, codec=Codec.OPUS, address="192.168.1.20",
        port=5004, level=-23.0, separated=True,
    )  # fmt: skip
    shown = tshark([encoder.encode(stream), encoder.encode(Wrapper(7, 191).wrap(stream))], "-V")
    for words in (
        "address (char): 192.168.1.20", "port (uint16_t): 5004", "ROSS_CODEC_OPUS", "ROSS_SELECTION_SOURCE",
        "number (uint8_t): 3", "level (int8_t) [dB]: -23", "sink (char): rtp",
    ):  # fmt: skip
        assert shown.count(words) == 2, shown


def test_units_and_names_of_entries_are_shown(tshark, encoder):
    shown = tshark([encoder.encode(ALIGNMENT)], "-V")
    assert "heading (float) [rad]: 1.570" in shown
    assert "isolation (float) [us]: 125" in shown
    assert "rule (ROSS_ALIGNMENT_RULE): ROSS_ALIGNMENT_RULE_BISECTOR (1)" in shown
    assert "frame (ROSS_FRAME): ROSS_FRAME_EARTH (1)" in shown
    assert "Component id: MAV_COMP_ID_ONBOARD_COMPUTER (191)" in shown


@pytest.mark.soak
def test_bits_are_shown_one_by_one(tshark, encoder):
    tree = json.loads(tshark([encoder.encode(Audio(time_usec=1, trouble=0b101))], "-T", "json"))
    text = json.dumps(tree)
    assert '"mavlink_proto.ROSS_AUDIO_trouble.ROSS_AUDIO_TROUBLE_CLIPPING": "1"' in text
    assert '"mavlink_proto.ROSS_AUDIO_trouble.ROSS_AUDIO_TROUBLE_DEAD_1": "0"' in text
    assert '"mavlink_proto.ROSS_AUDIO_trouble.ROSS_AUDIO_TROUBLE_DEAD_2": "1"' in text


def test_a_tunnel_is_looked_into(fields, encoder):
    tunnel = encoder.encode(Wrapper(7, 191).wrap(ALIGNMENT))
    names = ("msgid", "TUNNEL_payload_type", "ROSS_ALIGNMENT_heading")
    [[numbers, kind, heading]] = fields([tunnel], *names)
    assert (numbers, kind) == ("385,54003", "54000")
    assert float(heading) == pytest.approx(math.pi / 2, rel=1e-5)


@pytest.mark.soak
def test_another_tunnel_is_only_shown(fields, encoder):
    other = common.MAVLink_tunnel_message(0, 0, 200, 2, [0xFD, 9] + [0] * 126)
    assert fields([encoder.encode(other)], "msgid", "TUNNEL_payload_1") == [["385", "9"]]


def test_broken_tunnels_do_not_break_the_dissector(tshark, encoder):
    lengths = [0, 1, 11, 128, 200]
    broken = [common.MAVLink_tunnel_message(0, 0, 54000, length, [0xFD] * 128) for length in lengths]
    shown = tshark([encoder.encode(each) for message in broken for each in (message, ALIGNMENT)], "-V")
    assert shown.count("heading (float) [rad]: 1.570") == len(lengths)


@pytest.mark.parametrize("isolation", [-125.0, -1e25, math.nan])
def test_a_delay_that_is_negative_or_not_known_does_not_break_the_dissector(fields, encoder, isolation):
    frame = encoder.encode(replace(ALIGNMENT, isolation=isolation))
    assert fields([frame], "ROSS_ALIGNMENT_gain", "ROSS_ALIGNMENT_plan") == [["3.5", "3"]]


def test_a_frame_of_which_the_rest_is_missing_is_no_error_and_has_no_numbers(tshark, encoder):
    frame, old = encoder.encode(ALIGNMENT), b"\xfe\x09\x00\x01\x01\x00"  # of MAVLink 1
    cut = [frame[:size] for size in (1, 2, 3, 11, 12, len(frame) - 1)] + [old, frame + frame[:30]]
    shown = tshark(cut, "-V")
    assert "Lua Error" not in shown
    assert shown.count("(Note/Undecoded): The rest of this frame is not here") == len(cut)
    assert shown.count("heading (float) [rad]: 1.570") == 1


@pytest.mark.soak
def test_what_a_payload_also_says_and_hears_is_read(tshark, encoder):
    turn = common.MAVLink_command_long_message(7, 191, 54003, 0, 30.0, 0, 0, 0, 0, 0, 0)
    shown = tshark([encoder.encode(Heartbeat(Health.ACTIVE, 6)), encoder.encode(turn)], "-V")
    assert "system_status (MAV_STATE): MAV_STATE_ACTIVE (4)" in shown
    assert "MAV_CMD_ROSS_TURN (54003)" in shown
    assert "param1: Heading (float) deg: 30" in shown


def test_what_turns_a_drone_is_read(tshark, encoder):
    told = [vehicle_control.position_target(ComponentId(7, 1), 5.0, (0.0, 0.0, -3.0), 0.5)]
    told += [common.MAVLink_extended_sys_state_message(0, 2), common.MAVLink_radio_status_message(1, 2, 3, 4, 5, 6, 7)]
    shown = tshark([encoder.encode(message) for message in told], "-V")
    assert "another dialect" not in shown
    assert "landed_state (MAV_LANDED_STATE): MAV_LANDED_STATE_IN_AIR (2)" in shown
    assert "yaw (float) [rad]: -0.5" in shown


def test_a_message_of_another_dialect_does_not_hide_the_next_one(fields, encoder):
    stranger = common.MAVLink_vfr_hud_message(1, 2, 3, 4, 5, 6)
    both = encoder.encode(stranger) + encoder.encode(ALIGNMENT)
    assert fields([both], "msgid", "ROSS_ALIGNMENT_plan") == [["74,54003", "3"]]


@pytest.mark.soak
def test_any_port_will_do(fields, encoder):
    status = Status(time_usec=1, mission_time=2.0, earth=False, state=6)
    assert fields([encoder.encode(status)], "ROSS_STATUS_state", port=15777) == [["6"]]


def test_other_traffic_is_left_alone(fields):
    assert fields([b"\xfd" + b"no MAVLink, surely" * 2], "msgid", port=15777) == [[""]]


@pytest.mark.soak
def test_a_signature_is_shown(fields):
    signed = Encoder(7, 191, key=bytes(32), link_id=5).encode(ALIGNMENT, timestamp=10**12)
    assert fields([signed], "msgid", "signature_link", port=15777) == [["54003", "5"]]
