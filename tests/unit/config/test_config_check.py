"""`ross config check` refuses whatever `ross run` refuses before it opens a device, in the same words."""

import os
import re
from functools import partial

import numpy as np
import pytest
import soundfile

from command_line import called

LINK = "[[links]]\nurl = {!r}\n"
VEHICLE = "[actuator]\nkind = 'vehicle_yaw'\n"
AUTOPILOT = "[[links]]\nurl = 'udpin:127.0.0.1:14550'\nrole = 'autopilot'\n"
BAD = {
    "a URL of something else": LINK.format("file:///etc/passwd"),
    "a port that is none": LINK.format("udpin:127.0.0.1:99999"),
    "port 0": LINK.format("tcpin:127.0.0.1:0"),
    "no host": LINK.format("udpout::14550"),
    "a baud rate that is none": LINK.format("serial:/dev/ttyAMA0:fast"),
    "one URL twice": LINK.format("udpin:127.0.0.1:14550") * 2,
    "a key that is missing": LINK.format("udpin:127.0.0.1:14550") + "key_file = 'no-key'\n",
    "a key that is a named pipe": LINK.format("udpin:127.0.0.1:14550") + "key_file = 'pipe'\n",
    "a key for everybody": LINK.format("udpin:127.0.0.1:14550") + "key_file = 'open-key'\n",
    "a key that is too short": LINK.format("udpin:127.0.0.1:14550") + "key_file = 'short-key'\n",
    "a target that is a path": "[service]\ntarget = '../../../etc/shadow'\n",
    "a target that nobody knows": "[service]\ntarget = 'nobody'\n",
    "nobody to seek": "[service]\nautostart = 'seek'\n",
    "a state folder in a file": "[service]\nstate_dir = 'a.wav/state'\n",
    "a state folder of no user": "[service]\nstate_dir = '~nobody-here/state'\n",
    "a state folder that no file can have": '[service]\nstate_dir = "a\\u0000b"\n',
    "a state folder whose name is too long": f"[service]\nstate_dir = '{'x' * 300}'\n",
    "recordings of no user": "[recording]\nfolder = '~nobody-here/kept'\n",
    "a key of no user": LINK.format("udpin:127.0.0.1:14550") + "key_file = '~nobody-here/key'\n",
    "one channel twice": "[audio]\nchannels = [0, 0]\n",
    "a channel that is not opened": "[audio]\nchannels = [0, 5]\ndevice_channels = 2\n",
    "a recording that is missing": "[audio]\nsource = 'file:missing.wav'\n",
    "a recording that is text": "[audio]\nsource = 'file:text.wav'\n",
    "a recording of another rate": "[audio]\nsource = 'file:a.wav'\nrate_hz = 48000\n",
    "audio from no port": "[audio]\nsource = 'tcp:127.0.0.1:99999'\n",
    "audio from a port of many digits": f"[audio]\nsource = 'tcp:127.0.0.1:{'9' * 5000}'\n",
    "audio from nothing": "[audio]\nsource = 'tape:1'\n",
    "no autopilot for the mount": "[mount]\nsource = 'autopilot'\n",
    "no autopilot for the gimbal": "[gimbal]\nmode = 'device'\n",
    "no autopilot for the system id": LINK.format("udpin:127.0.0.1:14550") + "[telemetry]\nsystem_id = 0\n",
    "no way to the gimbal": "[actuator]\nkind = 'mavlink_gimbal'\n",
    "two gimbals": LINK.format("udpin:127.0.0.1:14550")
    + "[actuator]\nkind = 'mavlink_gimbal'\n[gimbal]\nmode='device'",
    "no way to the autopilot": VEHICLE + "options = { turn_vehicle = true }\n",
    "a vehicle that nobody has said may be turned": VEHICLE + AUTOPILOT,
    "a vehicle whose yaw is counted twice": VEHICLE
    + "options = { turn_vehicle = true }\n[mount]\nsource = 'autopilot'\n"
    + AUTOPILOT,
    "a vehicle that is turned by its mount": VEHICLE
    + "options = { turn_vehicle = true }\n[mount]\nyaw_deg = 30\n"
    + AUTOPILOT,
    "a vehicle shown as a gimbal": VEHICLE
    + "options = { turn_vehicle = true }\n[gimbal]\nmode = 'device'\n"
    + AUTOPILOT,
    "no such actuator": "[actuator]\nkind = 'crane'\n",
    "an option that is none": "[actuator.options]\nmicrostep = 16\n",
    "a pin twice": "[actuator.options]\nport = 'pulses:lgpio:0:17,17,22'\n",
    "pulses from nowhere": "[actuator.options]\nport = 'pulses:usb'\n",
    "a wire that is none": "[actuator.options]\nport = 'string:7'\n",
    "a simulated wire to nowhere": "[actuator]\nkind = 'ideal'\n",
    "a CAN interface that is none": "[dronecan]\nport = 'can:none:can0'\n",
    "a CAN hub without a port": "[dronecan]\nport = 'can:socketcand:127.0.0.1'\n",
    "a serial wire without a rate": "[actuator]\nkind = 'grbl'\n[actuator.options]\nport = 'serial:/dev/ttyUSB0'\n",
    "one CAN id for two": "[dronecan]\nport = 'can:virtual:a'\nnode_id = 42\n[actuator]\nkind = 'dronecan_servo'\n"
    "[actuator.options]\nport = 'can:virtual:a'\nnode_id = 42\n",
    "limits that leave no travel": "[guard]\nlower_deg = 400.0\nupper_deg = 401.0\npark_deg = 400.5\n"
    "[actuator]\nkind = 'dronecan_servo'\n",
    "a window that no register of a drive holds": "[actuator]\nkind = 'canopen_drive'\n"
    "options = { max_lag_deg = 1e9 }\n",
    "a drive whose home lies outside its travel": "[actuator]\nkind = 'canopen_drive'\n"
    "options = { homing = 'here', zero_deg = 720.0 }\n",
    "a travel that no drive counts": "[actuator]\nkind = 'canopen_drive'\noptions = { upper_deg = 1e308 }\n",
    "a zero that no drive counts": "[actuator]\nkind = 'canopen_drive'\noptions = { zero_deg = -1e308 }\n",
    "a speed that no drive counts": "[actuator]\nkind = 'canopen_drive'\noptions = { max_speed_deg_s = 1e308 }\n",
    "a gear that no motor has": "[actuator.options]\ngear_ratio = 1e308\n",
    "a watchdog in milliseconds": "[guard]\nwatchdog_s = 500\n",
    "an attitude in milliseconds": "[mount]\nfresh_s = 500\n",
    "a move without an end": "[guard]\nmax_move_s = 30000\n",
    "a heading of a thousand turns": "[mount]\nyaw_deg = 360000\n",
    "a switch for one of some numbers": "[actuator]\noptions = { microsteps = true }\n",
    "too little travel to turn without a pause": "[explore]\ncontinuous = true\n[actuator]\nkind = 'canopen_drive'\n"
    "options = { lower_deg = -20.0, upper_deg = 20.0 }\n",
    "no such explorer": "[explore]\nmethod = 'guess'\n",
    "no such separator": "[exploit]\nseparator = 'magic'\n",
    "no such sink": "[[listening.streams]]\nsink = 'loudspeaker'\n",
    "a sink without its path": "[[listening.streams]]\nsink = 'file'\n",
    "a track of another format": "[[listening.streams]]\nsink = 'file'\noptions = { path = 'a.mp3' }\n",
    "a codec that is none": "[[listening.streams]]\nsink = 'tcp'\noptions = { port = 5, codec = 'mp3' }\n",
    "one port for two streams": "[[listening.streams]]\nsink = 'tcp'\noptions = { port = 5 }\n" * 2,
    "one port for a stream and the descriptions": "[listening]\nsdp_port = 5\n"
    "[[listening.streams]]\nsink = 'tcp'\noptions = { port = 5 }\n",
    "nobody to listen to": "[[listening.streams]]\nsink = 'device'\nwhat = 'everybody'\n",
    "a stream to a crowd": "[[listening.streams]]\nsink = 'rtp'\noptions = { address = '239.0.0.1' }\n",
    "a latency that is too short": "[listening]\nlatency_ms = 10\n",
    "a separator that is not live": "[listening]\nseparator = 'paper'\n",
    "a key that is none": "[audoi]\nrate_hz = 16000\n",
    "a value out of bounds": "[audio]\nrate_hz = 5\n",
    "a scenario": "title = 'x'\ntalkers = []\n",
    "no TOML": "= = =",
    "brackets": "a = " + "[" * 100_000,
    "5,000 digits": "seed = " + "9" * 5000,
    "an escape in a key": '"\\u001b[2J" = 1\n',
    "an escape in a value": '[service]\ntarget = "\\u001b[2J\\u0007"\n',
    "a line break in a value": '[[links]]\nurl = "a\\nross: good"\n',
}


@pytest.fixture
def run(monkeypatch, capsys, tmp_path):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    monkeypatch.chdir(tmp_path)
    soundfile.write("a.wav", np.zeros((1600, 2)), 16000)
    for name, size, mode in (("text.wav", 99, 0o600), ("open-key", 32, 0o644), ("short-key", 7, 0o600)):
        (tmp_path / name).write_bytes(b"x" * size)
        (tmp_path / name).chmod(mode)
    os.mkfifo("pipe", 0o600)
    return partial(called, monkeypatch, capsys)


@pytest.mark.parametrize("what", BAD)
def test_what_cannot_be_run_is_refused_by_both_in_the_same_words(run, tmp_path, what):
    (tmp_path / "bad.toml").write_text(BAD[what])
    checked = run("config", "check", "bad.toml")
    assert checked == run("run", "bad.toml")
    code, out, err = checked
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert err.rstrip("\n").isprintable()
    assert len(err) < 1600
    assert re.match(r"ross: (bad\.toml: |\S+\.wav: )", err), err
    assert not (tmp_path / "state").exists()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("sink = 'speaker'", "listening.streams.0.sink: sink 'speaker' is unknown; there are: device, file, rtp, tcp"),
        ("snik = 'tcp'", "unknown key 'listening.streams.0.snik'; did you mean 'sink'?; and 1 more"),
        (
            "sink = 'tcp'\noptions = { prot = 5010 }",
            "listening.streams.0.options of 'tcp': unknown key 'prot'; did you mean 'port'?; and 1 more",
        ),
    ],
)
def test_a_mistake_in_a_stream_is_told_with_its_place_and_a_misspelt_key_first(run, tmp_path, text, said):
    (tmp_path / "bad.toml").write_text(f"[[listening.streams]]\n{text}\n")
    assert run("config", "check", "bad.toml") == (2, "", f"ross: bad.toml: {said}\n")


def test_checking_makes_no_folder_and_opens_no_device(run, tmp_path):
    text = "[service]\nstate_dir = 'new/state'\n[actuator]\nkind = 'grbl'\n" + LINK.format("serial:/dev/nothing:57600")
    (tmp_path / "good.toml").write_text(text)
    assert run("config", "check", "good.toml") == (0, "good.toml: good\n", "")
    assert not (tmp_path / "new").exists()


def test_without_a_link_no_autopilot_has_to_tell_the_system_id(run, tmp_path):
    (tmp_path / "good.toml").write_text("[telemetry]\nsystem_id = 0\n")
    assert run("config", "check", "good.toml") == (0, "good.toml: good\n", "")


def test_a_recording_folder_that_cannot_be_made_is_noted_and_refuses_nothing(run, tmp_path):
    (tmp_path / "good.toml").write_text("[recording]\nfolder = 'good.toml/all'\n")
    note = "note: recording.folder: good.toml/all cannot be made: Not a directory; you could record nothing there\n"
    assert run("config", "check", "good.toml") == (0, f"good.toml: good\n{note}", "")
