"""The computer is a folder and a table of what its programs print; ports, files and permissions are real."""

import os
from types import SimpleNamespace

import numpy as np
import pytest
import soundfile

from doctor_bench import FAST, config, machine, put, said
from examples import in_soak
from ross_payload.clock import SystemClock
from ross_payload.doctor import computer_checks, examination, speed, wire_checks
from ross_payload.doctor.findings import Verdict, ok, warn, worst
from ross_payload.doctor.machine import Machine
from ross_payload.health import AudioHealth, AudioTrouble
from ross_payload.service.state_folder import check_state_folder
from ross_sim.clock import SimClock


def test_whatever_is_not_well_says_what_to_do():
    assert worst([]) is Verdict.OK
    assert worst([ok("a", ""), warn("b", "", "do")]) is Verdict.WARN


# -------------------------------------------------------------------------------------------- computer


@pytest.mark.parametrize(("bits", "verdict"), [(64, Verdict.OK), (32, Verdict.WARN)])
def test_a_32_bit_system_is_warned_of(tmp_path, bits, verdict):
    assert said(computer_checks.python(config(), machine(tmp_path, bits=bits)))[0] is verdict


@pytest.mark.parametrize(
    ("programs", "verdict"),
    [({"timedatectl": "yes"}, Verdict.OK), ({"timedatectl": "no"}, Verdict.WARN), ({}, Verdict.WARN)],
)
def test_a_clock_that_nobody_sets_is_warned_of(tmp_path, programs, verdict):
    assert said(computer_checks.clock(config(), machine(tmp_path, programs)))[0] is verdict


@pytest.mark.parametrize(("reading", "verdict"), [("41000", Verdict.OK), ("82000", Verdict.WARN), (None, Verdict.OK)])
def test_a_hot_processor_is_warned_of(tmp_path, reading, verdict):
    if reading:
        put(tmp_path, "/sys/class/thermal/thermal_zone0/temp", reading + "\n")
    assert said(computer_checks.heat(config(), machine(tmp_path)))[0] is verdict


@pytest.mark.parametrize(
    ("answer", "verdict", "words"),
    [
        ("throttled=0x0", Verdict.OK, "never"),
        ("throttled=0x50005", Verdict.WARN, "under-voltage, throttled now"),
        ("throttled=0x50000", Verdict.WARN, "under-voltage, throttled since boot"),
        (None, Verdict.WARN, "gives no answer"),
    ],
)
def test_a_pi_tells_about_its_supply(tmp_path, answer, verdict, words):
    put(tmp_path, "/proc/device-tree/model", "Raspberry Pi 5 Model B Rev 1.0\0")
    found = said(computer_checks.power(config(), machine(tmp_path, {"vcgencmd": answer})))
    assert found[0] is verdict
    assert words in found[1]


@pytest.mark.parametrize(("allowed", "verdict"), [(True, Verdict.OK), (False, Verdict.WARN)])
def test_pulses_without_real_time_priority_are_warned_of(tmp_path, allowed, verdict):
    pulses = config(actuator={"kind": "tb6600"})
    assert said(computer_checks.priority(pulses, machine(tmp_path, may_hurry=lambda: allowed)))[0] is verdict


def test_other_actuators_need_no_priority(tmp_path):
    others = config(actuator={"kind": "grbl"})
    assert not list(computer_checks.priority(others, machine(tmp_path, may_hurry=lambda: False)))


def test_another_computer_is_not_asked_for_its_supply(tmp_path):
    assert not list(computer_checks.power(config(), machine(tmp_path, {"vcgencmd": "throttled=0x5"})))


# -------------------------------------------------------------------------------------------- microphones


def recording(tmp_path, first, second):
    """What the doctor finds of two microphones that were recorded."""
    path = tmp_path / "heard.wav"
    soundfile.write(path, np.stack([first, second], axis=1), 16000, subtype="PCM_24")
    return said(examination.microphones(config(audio={"source": f"file:{path}"}), SimClock()))


def noise(seed):
    return 0.1 * np.random.default_rng(seed).standard_normal(16000 * 5)


def test_two_microphones_that_hear_are_well(tmp_path):
    verdict, text = recording(tmp_path, noise(1), noise(2))
    assert verdict is Verdict.OK
    assert "levels -20 and -20 dB" in text


@pytest.mark.parametrize("seconds", [0.0, 1.0, 2.9])
def test_microphones_of_which_little_was_heard_are_not_judged(tmp_path, seconds):
    n = round(seconds * 16000)
    verdict, text = recording(tmp_path, noise(1)[:n], noise(2)[:n])
    assert verdict is Verdict.FAIL
    assert text.startswith(f"expected 4 s of audio, got {seconds} s")


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


def test_microphones_that_give_hardly_anything_are_a_warning(tmp_path):
    verdict, text = recording(tmp_path, 1e-5 * noise(1), 1e-5 * noise(2))
    assert verdict is Verdict.WARN
    assert "hardly any sound" in text


@pytest.mark.parametrize(("lost_s", "advice"), [(2.0, "another rate"), (0.1, "another USB port")])
def test_so_many_lost_samples_as_of_another_rate_are_told_as_such(monkeypatch, lost_s, advice):
    health = AudioHealth(trouble=AudioTrouble.LOST, lost=round(lost_s * 16000), level_db=(-20.0, -20.0))
    heard = np.stack([noise(1), noise(2)]).astype(np.float32)
    monkeypatch.setattr(examination, "measured", lambda config, clock: (health, heard))
    verdict, text = said(examination.microphones(config(), SimClock()))
    assert verdict is Verdict.WARN
    assert advice in text


def test_microphones_that_are_not_there_are_a_failure(tmp_path):
    lost = config(audio={"source": f"file:{tmp_path / 'no.wav'}"})
    assert said(examination.microphones(lost, SimClock()))[0] is Verdict.FAIL


def test_every_trouble_that_ears_have_has_words():
    assert set(examination.TROUBLES) == set(AudioTrouble)


# -------------------------------------------------------------------------------------------- folders


def test_the_state_folder_of_the_service_is_the_one_checked(tmp_path):
    (tmp_path / "var/lib/ross").mkdir(parents=True)
    service = Machine(root=tmp_path, environment={"STATE_DIRECTORY": "/var/lib/ross"}, run=lambda words: None)
    assert said(computer_checks.state(config(), service)) == (Verdict.OK, "/var/lib/ross can be written -> ")


def test_relative_paths_are_those_of_the_folder_in_which_we_are(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "state").write_text("in the way")
    (tmp_path / "key").write_bytes(bytes(32))
    (tmp_path / "key").chmod(0o600)
    here = Machine()
    link = {"url": "udpout:127.0.0.1:9", "key_file": "key"}
    assert said(wire_checks.links(config(links=[link]), here))[0] is Verdict.OK
    folder = {"folder": "state/recordings"}
    found = said(computer_checks.recordings(config(recording=folder), here))
    assert found[1].startswith("recording.folder: state/recordings cannot be made: Not a directory")


def test_a_state_folder_of_others_is_a_failure_a_recording_folder_only_where_it_is_needed(tmp_path):
    foreign = machine(tmp_path, may_use=lambda path: False)
    assert said(computer_checks.state(config(), foreign))[0] is Verdict.FAIL
    assert said(computer_checks.recordings(config(), foreign))[0] is Verdict.WARN
    assert said(computer_checks.recordings(config(recording={"always": True}), foreign))[0] is Verdict.FAIL


def test_a_disk_that_is_mounted_read_only_is_no_matter_of_permissions(tmp_path, monkeypatch):
    """As an SD card with errors is by the kernel."""
    monkeypatch.setattr(os, "access", lambda path, mode: not mode & os.W_OK)
    monkeypatch.setattr(os, "statvfs", lambda path: SimpleNamespace(f_flag=os.ST_RDONLY))
    kept = config(service={"state_dir": str(tmp_path)}, recording={"folder": str(tmp_path)})
    verdict, text = said(computer_checks.state(kept, Machine()))
    assert verdict is Verdict.FAIL
    assert text.startswith(f"{tmp_path} is on a file system that is mounted read-only")
    text = said(computer_checks.recordings(kept, Machine()))[1]
    assert text.startswith(f"recording.folder: {tmp_path} cannot be written: Read-only file system")
    check_state_folder(kept)  # a stop needs no disk: the payload runs


@pytest.mark.parametrize(("name", "why"), [("file/all", "Not a directory"), ("file", "File exists")])
def test_a_recording_folder_that_cannot_be_made_is_named_with_the_reason(tmp_path, name, why):
    (tmp_path / "file").write_text("")
    found = said(computer_checks.recordings(config(recording={"folder": f"/{name}"}), machine(tmp_path)))
    assert found[0] is Verdict.WARN
    assert found[1].startswith(f"recording.folder: /{name} cannot be made: {why} -> ")


@pytest.mark.parametrize(("mode", "verdict"), [(0o700, Verdict.OK), (0o755, Verdict.WARN)])
def test_recordings_that_others_may_read_are_warned_of(tmp_path, mode, verdict):
    (tmp_path / "srv").mkdir()
    (tmp_path / "srv").chmod(mode)
    wanted = config(recording={"folder": "/srv", "min_free_gb": 0, "max_gb": 0.001})
    assert said(computer_checks.recordings(wanted, machine(tmp_path)))[0] is verdict


def test_a_disk_without_room_is_warned_of(tmp_path):
    wanted = config(recording={"folder": "/srv", "min_free_gb": 10_000})
    assert said(computer_checks.recordings(wanted, machine(tmp_path)))[0] is Verdict.WARN


def test_a_model_of_voices_that_cannot_be_used_is_told_also_without_a_target(tmp_path):
    """`ross run` would not start."""
    folder = tmp_path / "voice-data" / "ross" / "voice-models"
    folder.mkdir(parents=True)
    (folder / "damaged.onnx").write_text("no network")
    here = Machine(environment={"XDG_DATA_HOME": str(tmp_path / "voice-data")})
    for asked in ({}, {"service": {"target": "anna"}}):
        verdict, text = said(computer_checks.voice(config(**asked), here))
        assert verdict is Verdict.FAIL
        assert "voice_print.model: " in text
        assert "damaged.onnx: expected an ONNX file" in text


def test_a_voice_that_is_sought_must_be_enrolled(tmp_path):
    here = Machine(environment={"XDG_DATA_HOME": str(tmp_path)})
    verdict, text = said(computer_checks.voice(config(service={"target": "anna"}), here))
    assert verdict is Verdict.FAIL
    assert "ross enroll anna" in text
    assert said(computer_checks.voice(config(service={"autostart": "seek"}), here))[0] is Verdict.FAIL
    assert said(computer_checks.voice(config(), here))[0] is Verdict.OK


# -------------------------------------------------------------------------------------------- turning


WIRED = {"kind": "tb6600", "options": {"port": "pulses:tcp:127.0.0.1:5000"}}


def test_an_array_that_turns_half_a_circle_reaches_every_axis(tmp_path):
    enough = config(guard={"lower_deg": -90, "upper_deg": 90}, actuator=WIRED)
    assert said(examination.actuator(enough, machine(tmp_path), SimClock()))[0] is Verdict.OK
    short = config(guard={"lower_deg": -80, "upper_deg": 80})
    verdict, text = said(examination.actuator(short, machine(tmp_path), SimClock()))
    assert verdict is Verdict.WARN
    assert "160 deg of travel" in text


def test_an_array_that_starts_by_itself_is_warned_of(tmp_path):
    assert said(examination.autostart(config(), machine(tmp_path)))[0] is Verdict.OK
    assert said(examination.autostart(config(service={"autostart": "explore"}), machine(tmp_path)))[0] is Verdict.WARN


def test_a_longest_move_that_the_guard_would_call_a_fault_is_found(tmp_path):
    slow = config(guard={"max_speed_deg_s": 10, "max_move_s": 30})  # 400 deg at 10 deg/s
    verdict, text = said(examination.actuator(slow, machine(tmp_path), SimClock()))
    assert verdict is Verdict.FAIL
    assert "the longest move takes 40.1 s" in text


def test_a_back_end_that_is_unknown_or_simulated_is_found(tmp_path):
    def found(**actuator):
        return said(examination.actuator(config(actuator=actuator), machine(tmp_path), SimClock()))

    assert found(kind="hamster")[0] is Verdict.FAIL
    assert found(kind="tb6600", options={"microstep": 3})[0] is Verdict.FAIL
    assert found(kind="ideal")[0] is Verdict.WARN
    assert "keeps its pulses in memory" in found(kind="tb6600")[1]
    assert found(**WIRED)[0] is Verdict.OK


# -------------------------------------------------------------------------------------------- speed


class SlowClock:
    """Every look at it is ``step`` seconds after the one before."""

    def __init__(self, *steps):
        self.steps, self.time = list(steps), 0.0

    def now(self):
        self.time += self.steps.pop(0)
        return self.time


@pytest.mark.parametrize("motion", [{}, *in_soak({"continuous": True, "rate_deg_s": 90})])
def test_a_computer_as_fast_as_this_one_keeps_up(motion):
    cost = speed.rehearsed(config(**FAST | {"explore": FAST["explore"] | motion}), SystemClock())
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


# -------------------------------------------------------------------------------------------- what `ross run` refuses

LINK = {"url": "udpout:127.0.0.1:14550"}
REFUSED = {
    "links.1.url": {"links": [LINK, LINK]},
    "gimbal.mode": {"gimbal": {"mode": "device"}},
    "listening: separator": {"listening": {"separator": "paper"}},
    "listening.streams.0.sink": {"listening": {"streams": [{"sink": "loudspeaker"}]}},
    "actuator.kind": {"actuator": {"kind": "mavlink_gimbal"}},
}


@pytest.mark.parametrize("key", REFUSED)
def test_what_ross_run_would_refuse_is_a_failure(tmp_path, key):
    path = tmp_path / "heard.wav"
    soundfile.write(path, np.stack([noise(1), noise(2)], axis=1), 16000)
    tables = FAST | {"audio": {"source": f"file:{path}"}} | REFUSED[key]
    last = list(examination.examine(config(**tables), machine(tmp_path), SimClock()))[-1]
    assert (last.check, last.verdict) == ("configuration", Verdict.FAIL)
    assert last.found.startswith(key)
