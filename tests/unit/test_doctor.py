"""The computer is a folder and a table of what its programs print; ports, files and permissions are real."""

import json
import socket
import sys

import numpy as np
import pytest
import soundfile

from ross_payload import cli
from ross_payload.clock import SystemClock
from ross_payload.config import Config, validated
from ross_payload.doctor import computer, folders, microphones, speed, turning, wires
from ross_payload.doctor.examine import examine
from ross_payload.doctor.finding import Verdict, ok, warn, worst
from ross_payload.doctor.machine import Machine, output_of
from ross_payload.health import AudioTrouble
from ross_sim.clock import SimClock

DEVICE = "serial:/dev/ttyUSB0:115200"


def config(**tables):
    return validated(Config, tables, "test")


def machine(root, programs=None, **other):
    """A computer with nothing but a root folder; programs that are not named are not installed."""
    answers = {} if programs is None else programs
    return Machine(root=root, environment={"HOME": str(root)}, run=lambda words: answers.get(words[0]), **other)


def put(root, where, text=""):
    path = root / where.lstrip("/")
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


def said(findings):
    """The worst verdict and everything that was found, in one text."""
    findings = list(findings)
    return worst(findings), "\n".join(f"{each.found} -> {each.todo}" for each in findings)


def test_whatever_is_not_well_says_what_to_do():
    assert worst([]) is Verdict.OK
    assert worst([ok("a", ""), warn("b", "", "do")]) is Verdict.WARN


# -------------------------------------------------------------------------------------------- computer


@pytest.mark.parametrize(("bits", "verdict"), [(64, Verdict.OK), (32, Verdict.WARN)])
def test_a_32_bit_system_is_warned_of(tmp_path, bits, verdict):
    assert said(computer.python(config(), machine(tmp_path, bits=bits)))[0] is verdict


@pytest.mark.parametrize(
    ("programs", "verdict"),
    [({"timedatectl": "yes"}, Verdict.OK), ({"timedatectl": "no"}, Verdict.WARN), ({}, Verdict.WARN)],
)
def test_a_clock_that_nobody_sets_is_warned_of(tmp_path, programs, verdict):
    assert said(computer.clock(config(), machine(tmp_path, programs)))[0] is verdict


@pytest.mark.parametrize(("reading", "verdict"), [("41000", Verdict.OK), ("82000", Verdict.WARN), (None, Verdict.OK)])
def test_a_hot_processor_is_warned_of(tmp_path, reading, verdict):
    if reading:
        put(tmp_path, "/sys/class/thermal/thermal_zone0/temp", reading + "\n")
    assert said(computer.heat(config(), machine(tmp_path)))[0] is verdict


@pytest.mark.parametrize(
    ("answer", "verdict", "words"),
    [
        ("throttled=0x0", Verdict.OK, "never"),
        ("throttled=0x50005", Verdict.WARN, "under-voltage, throttled now"),
        ("throttled=0x50000", Verdict.WARN, "under-voltage, throttled since boot"),
        (None, Verdict.WARN, "does not tell"),
    ],
)
def test_a_pi_tells_about_its_supply(tmp_path, answer, verdict, words):
    put(tmp_path, "/proc/device-tree/model", "Raspberry Pi 5 Model B Rev 1.0\0")
    found = said(computer.power(config(), machine(tmp_path, {"vcgencmd": answer})))
    assert found[0] is verdict
    assert words in found[1]


def test_another_computer_is_not_asked_for_its_supply(tmp_path):
    assert not list(computer.power(config(), machine(tmp_path, {"vcgencmd": "throttled=0x5"})))


# -------------------------------------------------------------------------------------------- wires


def test_a_serial_port_that_is_not_there_lists_those_that_are(tmp_path):
    put(tmp_path, "/dev/ttyACM0")
    verdict, text = said(wires.serial(config(links=[{"url": DEVICE}]), machine(tmp_path)))
    assert verdict is Verdict.FAIL
    assert "there are: /dev/ttyACM0" in text


def test_a_serial_port_of_others_names_the_group(tmp_path):
    put(tmp_path, "/dev/ttyUSB0")
    strange = machine(tmp_path, may_use=lambda path: path.name != "ttyUSB0")
    verdict, text = said(wires.serial(config(links=[{"url": DEVICE}]), strange))
    assert verdict is Verdict.FAIL
    assert "usermod -aG" in text


def test_a_serial_port_in_the_options_of_the_actuator_is_checked_too(tmp_path):
    turns = config(actuator={"kind": "x", "options": {"wire": {"port": "serial:/dev/ross-grbl:115200"}}})
    assert "/dev/ross-grbl does not exist" in said(wires.serial(turns, machine(tmp_path)))[1]


def test_a_console_on_the_port_is_found_through_its_other_name(tmp_path):
    put(tmp_path, "/dev/ttyAMA0")
    (tmp_path / "dev" / "serial0").symlink_to("ttyAMA0")
    put(tmp_path, "/proc/cmdline", "console=tty1 console=serial0,115200 root=/dev/mmcblk0p2\n")
    verdict, text = said(wires.serial(config(links=[{"url": "serial:/dev/ttyAMA0:auto"}]), machine(tmp_path)))
    assert verdict is Verdict.FAIL
    assert "console" in text


def test_a_login_on_the_port_is_found(tmp_path):
    put(tmp_path, "/dev/ttyUSB0")
    busy = machine(tmp_path, {"systemctl": "active"})
    assert said(wires.serial(config(links=[{"url": DEVICE}]), busy))[0] is Verdict.FAIL
    assert said(wires.serial(config(links=[{"url": DEVICE}]), machine(tmp_path)))[0] is Verdict.OK


@pytest.mark.parametrize(
    ("flags", "verdict", "words"),
    [("0x40081\n", Verdict.OK, "up"), ("0x40080\n", Verdict.FAIL, "down"), (None, Verdict.FAIL, "there are: none")],
)
def test_a_can_interface_must_be_up(tmp_path, flags, verdict, words):
    if flags:
        put(tmp_path, "/sys/class/net/can0/flags", flags)
    servo = config(actuator={"kind": "servo", "options": {"port": "socketcan:can0"}})
    found = said(wires.can(servo, machine(tmp_path)))
    assert found[0] is verdict
    assert words in found[1]


def test_words_that_hold_can_are_no_interface():
    turns = config(actuator={"kind": "x", "options": {"name": "canopen", "port": "scan0", "bus": "vcan1"}})
    assert wires.can_interfaces(turns) == ["vcan1"]


def test_the_bus_of_our_own_node_is_looked_at():
    assert wires.can_interfaces(config(dronecan={"port": "can:socketcan:can3"})) == ["can3"]


@pytest.mark.parametrize(
    ("kind", "port", "devices", "interfaces"),
    [
        ("grbl", "serial:tcp:127.0.0.1:3333", [], []),
        ("dronecan_servo", "can:socketcand:127.0.0.1:29536:can0", [], []),
        ("dronecan_servo", "can:slcan:/dev/ttyACM0:1000000", ["/dev/ttyACM0"], []),
        ("canopen_drive", "can:socketcan:can1", [], ["can1"]),
    ],
)
def test_only_what_is_on_this_computer_is_looked_for(kind, port, devices, interfaces):
    turns = config(actuator={"kind": kind, "options": {"port": port}})
    assert wires.serial_devices(turns) == devices
    assert wires.can_interfaces(turns) == interfaces


def test_a_port_that_is_left_out_is_looked_at_as_well():
    assert wires.can_interfaces(config(actuator={"kind": "dronecan_servo"})) == ["can0"]
    assert wires.serial_devices(config(actuator={"kind": "grbl"})) == ["/dev/ttyUSB0"]


def test_a_port_that_another_program_has_is_found(tmp_path):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        link = {"url": f"udpin:127.0.0.1:{other.getsockname()[1]}"}
        verdict, text = said(wires.links(config(links=[link]), machine(tmp_path)))
    assert verdict is Verdict.FAIL
    assert "in use" in text
    assert said(wires.links(config(links=[link]), machine(tmp_path)))[0] is Verdict.OK


def test_a_tcp_port_that_is_served_already_is_found(tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as other:
        link = {"url": f"tcpin:127.0.0.1:{other.getsockname()[1]}"}
        assert said(wires.links(config(links=[link]), machine(tmp_path)))[0] is Verdict.FAIL


def test_a_listener_for_everybody_without_a_key_is_warned_of(tmp_path):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("", 0))
        link = {"url": f"udpin:0.0.0.0:{free.getsockname()[1]}"}
    verdict, text = said(wires.links(config(links=[link]), machine(tmp_path)))
    assert verdict is Verdict.WARN
    assert "may give orders" in text


def test_no_link_and_no_address_are_found(tmp_path):
    assert said(wires.links(config(), machine(tmp_path)))[0] is Verdict.WARN
    assert said(wires.links(config(links=[{"url": "carrier:pigeon"}]), machine(tmp_path)))[0] is Verdict.FAIL


@pytest.mark.parametrize(
    ("content", "mode", "verdict"),
    [(b"k" * 32, 0o600, Verdict.OK), (b"k" * 32, 0o644, Verdict.FAIL), (b"k", 0o600, Verdict.FAIL)],
)
def test_a_key_is_whole_and_ours_alone(tmp_path, content, mode, verdict):
    path = put(tmp_path, "/etc/ross/key")
    path.write_bytes(content)
    path.chmod(mode)
    link = {"url": "udpout:127.0.0.1:14550", "key_file": "/etc/ross/key"}
    assert said(wires.links(config(links=[link]), machine(tmp_path)))[0] is verdict


def test_a_key_that_is_missing_is_found(tmp_path):
    link = {"url": "udpout:127.0.0.1:14550", "key_file": "/etc/ross/key"}
    assert "No such file" in said(wires.links(config(links=[link]), machine(tmp_path)))[1]


@pytest.mark.parametrize(
    ("tables", "verdict"),
    [
        ({}, Verdict.OK),
        ({"telemetry": {"system_id": 0}}, Verdict.FAIL),
        ({"telemetry": {"system_id": 0}, "links": [{"url": DEVICE, "role": "autopilot"}]}, Verdict.OK),
        ({"mount": {"source": "autopilot"}}, Verdict.FAIL),
        ({"telemetry": {"system_id": 255}}, Verdict.WARN),
    ],
)
def test_ids_and_roles_must_fit(tmp_path, tables, verdict):
    assert said(wires.identity(config(**tables), machine(tmp_path)))[0] is verdict


def test_an_extra_that_is_not_asked_for_is_not_looked_for(tmp_path):
    assert not list(wires.extras(config(audio={"source": "tcp:127.0.0.1:1"}), machine(tmp_path)))


def test_pins_ask_for_the_library_that_drives_them(tmp_path):
    pins = {"kind": "tb6600", "options": {"port": "pulses:lgpio:0:23,24,25"}}
    finding = said(wires.extras(config(audio={"source": "tcp:127.0.0.1:1"}, actuator=pins), machine(tmp_path)))
    assert finding[1].startswith("lgpio is ")


# -------------------------------------------------------------------------------------------- microphones


def recording(tmp_path, first, second):
    """What the doctor finds of two microphones that were recorded."""
    path = tmp_path / "heard.wav"
    soundfile.write(path, np.stack([first, second], axis=1), 16000, subtype="PCM_24")
    return said(microphones.microphones(config(audio={"source": f"file:{path}"}), SimClock()))


def noise(seed):
    return 0.1 * np.random.default_rng(seed).standard_normal(16000 * 5)


def test_two_microphones_that_hear_are_well(tmp_path):
    verdict, text = recording(tmp_path, noise(1), noise(2))
    assert verdict is Verdict.OK
    assert "levels -20 and -20 dB" in text


def test_a_dead_microphone_is_named(tmp_path):
    verdict, text = recording(tmp_path, noise(1), np.zeros(16000 * 5))
    assert verdict is Verdict.FAIL
    assert "microphone 2 is dead" in text


def test_one_microphone_on_both_channels_is_found(tmp_path):
    assert "both channels are one" in recording(tmp_path, noise(1), noise(1))[1]


def test_clipping_is_a_warning(tmp_path):
    verdict, text = recording(tmp_path, np.clip(20 * noise(1), -1, 1), noise(2))
    assert verdict is Verdict.WARN
    assert "full scale" in text


def test_microphones_that_are_not_there_are_a_failure(tmp_path):
    lost = config(audio={"source": f"file:{tmp_path / 'no.wav'}"})
    assert said(microphones.microphones(lost, SimClock()))[0] is Verdict.FAIL


def test_every_trouble_that_ears_have_has_words():
    assert set(microphones.SAYS) == set(AudioTrouble)


# -------------------------------------------------------------------------------------------- folders


def test_the_state_folder_of_the_service_is_the_one_checked(tmp_path):
    (tmp_path / "var/lib/ross").mkdir(parents=True)
    service = Machine(root=tmp_path, environment={"STATE_DIRECTORY": "/var/lib/ross"}, run=lambda words: None)
    assert said(folders.state(config(), service)) == (Verdict.OK, "/var/lib/ross can be written -> ")


def test_a_state_folder_of_others_is_a_failure_a_recording_folder_only_where_it_is_needed(tmp_path):
    foreign = machine(tmp_path, may_use=lambda path: False)
    assert said(folders.state(config(), foreign))[0] is Verdict.FAIL
    assert said(folders.recordings(config(), foreign))[0] is Verdict.WARN
    assert said(folders.recordings(config(recording={"always": True}), foreign))[0] is Verdict.FAIL


@pytest.mark.parametrize(("mode", "verdict"), [(0o700, Verdict.OK), (0o755, Verdict.WARN)])
def test_recordings_that_others_may_read_are_warned_of(tmp_path, mode, verdict):
    (tmp_path / "srv").mkdir()
    (tmp_path / "srv").chmod(mode)
    wanted = config(recording={"folder": "/srv", "min_free_gb": 0, "max_gb": 0.001})
    assert said(folders.recordings(wanted, machine(tmp_path)))[0] is verdict


def test_a_disk_without_room_is_warned_of(tmp_path):
    wanted = config(recording={"folder": "/srv", "min_free_gb": 10_000})
    assert said(folders.recordings(wanted, machine(tmp_path)))[0] is Verdict.WARN


def test_a_voice_that_is_sought_must_be_enrolled(tmp_path):
    here = Machine(environment={"XDG_DATA_HOME": str(tmp_path)})
    verdict, text = said(folders.voice(config(service={"target": "anna"}), here))
    assert verdict is Verdict.FAIL
    assert "ross enroll anna" in text
    assert said(folders.voice(config(service={"autostart": "seek"}), here))[0] is Verdict.FAIL
    assert said(folders.voice(config(), here))[0] is Verdict.OK


# -------------------------------------------------------------------------------------------- turning


WIRED = {"kind": "tb6600", "options": {"port": "pulses:tcp:127.0.0.1:5000"}}


def test_an_array_that_turns_half_a_circle_reaches_every_axis(tmp_path):
    enough = config(guard={"lower_deg": -90, "upper_deg": 90}, actuator=WIRED)
    assert said(turning.actuator(enough, machine(tmp_path), SimClock()))[0] is Verdict.OK
    short = config(guard={"lower_deg": -80, "upper_deg": 80})
    verdict, text = said(turning.actuator(short, machine(tmp_path), SimClock()))
    assert verdict is Verdict.WARN
    assert "160 deg of travel" in text


def test_an_array_that_starts_by_itself_is_warned_of(tmp_path):
    assert said(turning.start(config(), machine(tmp_path)))[0] is Verdict.OK
    assert said(turning.start(config(service={"autostart": "explore"}), machine(tmp_path)))[0] is Verdict.WARN


def test_a_longest_move_that_the_guard_would_call_a_fault_is_found(tmp_path):
    slow = config(guard={"max_speed_deg_s": 10, "max_move_s": 30})  # 400 deg at 10 deg/s
    verdict, text = said(turning.actuator(slow, machine(tmp_path), SimClock()))
    assert verdict is Verdict.FAIL
    assert "the longest move takes 40.1 s" in text


def test_a_back_end_that_is_unknown_or_simulated_is_found(tmp_path):
    def found(**actuator):
        return said(turning.actuator(config(actuator=actuator), machine(tmp_path), SimClock()))

    assert found(kind="hamster")[0] is Verdict.FAIL
    assert found(kind="tb6600", options={"microstep": 3})[0] is Verdict.FAIL
    assert found(kind="ideal")[0] is Verdict.WARN
    assert "keeps its pulses to itself" in found(kind="tb6600")[1]
    assert found(**WIRED)[0] is Verdict.OK


# -------------------------------------------------------------------------------------------- speed


FAST = {"explore": {"unit_s": 0.5, "min_rotations": 1}, "exploit": {"separator": "duet", "run_s": 1}}


class SlowClock:
    """Every look at it is ``step`` seconds after the one before."""

    def __init__(self, *steps):
        self.steps, self.time = list(steps), 0.0

    def now(self):
        self.time += self.steps.pop(0)
        return self.time


def test_a_computer_as_fast_as_this_one_keeps_up():
    cost = speed.rehearsed(config(**FAST), SystemClock())
    assert 0 < cost.exploring < 100
    assert 0 < cost.separating < 100


def test_a_slow_computer_is_warned_and_one_that_loses_audio_fails():
    assert said(speed.headroom(config(**FAST), SlowClock(0, 0.9, 0.9)))[0] is Verdict.OK
    verdict, text = said(speed.headroom(config(**FAST), SlowClock(0, 0.9, 2.0)))
    assert verdict is Verdict.WARN
    assert "2 s per second of audio" in text
    assert said(speed.headroom(config(**FAST), SlowClock(0, 0.9, 61.0)))[0] is Verdict.FAIL


def test_the_made_up_voices_arrive_as_the_geometry_says():
    at_rest = speed.voices(config(), 0.0, 0.5)
    assert at_rest.shape == (2, 8000)
    assert 0 < abs(at_rest).max() < 2


def test_a_separator_that_does_not_exist_is_a_finding():
    assert said(speed.headroom(config(exploit={"separator": "magic"}), SystemClock()))[0] is Verdict.FAIL


# -------------------------------------------------------------------------------------------- machine


def test_a_program_that_is_not_there_or_fails_says_nothing():
    assert output_of(("no-such-program-here",)) is None
    assert output_of(("false",)) is None
    assert output_of(("echo", "yes")) == "yes"


def test_this_computer_is_seen_as_it_is():
    here = Machine()
    assert here.text("/proc/self/comm")
    assert here.text("/no/such/file") == ""
    assert here.bits in (32, 64)
    assert here.names("/dev", "nul[l]", "null") == ["/dev/null"]


# -------------------------------------------------------------------------------------------- the command


@pytest.fixture
def doctor(monkeypatch, capsys, tmp_path):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    monkeypatch.setenv("STATE_DIRECTORY", str(tmp_path / "state"))
    path = tmp_path / "ross.toml"

    def call(text, *options):
        path.write_text(QUICK + text)
        monkeypatch.setattr(sys, "argv", ["ross", "doctor", str(path), *options])
        with pytest.raises(SystemExit) as end:
            cli.main()
        said = capsys.readouterr()
        return end.value.code, said.out, said.err

    return call


QUICK = """
[audio]
source = "tcp:127.0.0.1:9"
[explore]
unit_s = 0.5
min_rotations = 1
[exploit]
separator = "duet"
run_s = 1
"""


def test_every_check_is_one_line_and_one_for_what_to_do(doctor):
    code, out, _ = doctor("[actuator]\nkind = 'ideal'\n")
    assert code == 2  # nobody sends audio there
    assert "fail  microphones  tcp:127.0.0.1:9" in out
    lines = [line for line in out.splitlines() if not line.lstrip().startswith("->")]
    assert all(line.split()[0] in ("ok", "warn", "fail") for line in lines)
    assert "-> choose another actuator.kind" in out


def test_what_must_be_mended_is_exit_code_2(doctor):
    code, out, _ = doctor("[actuator]\nkind = 'hamster'\n", "--json")
    report = json.loads(out)
    assert code == 2
    assert report["verdict"] == "fail"
    assert any("hamster" in check["found"] and check["verdict"] == "fail" for check in report["checks"])


def test_a_configuration_that_is_wrong_gets_one_line(doctor):
    code, out, err = doctor("[guard]\nlower_deg = 'left'\n")
    assert (code, out) == (2, "")
    assert err.count("\n") == 1


def test_a_check_that_breaks_hurts_no_other(tmp_path):
    def surprised(config, machine):
        yield ok("surprised", "so far")
        raise KeyError("this")

    found = list(examine(config(**FAST), machine(tmp_path), SystemClock(), (surprised, computer.python)))
    assert [each.check for each in found[:3]] == ["surprised", "surprised", "python"]
    assert "KeyError('this')" in found[1].found
