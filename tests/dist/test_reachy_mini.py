"""The example back end of a Reachy Mini: installed, held to the contracts, and tried on a daemon in another process."""

import contextlib
import importlib.util
import json
import re
import shutil
import sys
import urllib.request
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from manual import command
from own_plugin import install, module, run, run_line
from processes import program
from rigs import rig_of
from ross_payload.actuators.wires import open_wire
from ross_payload.clock import SystemClock
from ross_payload.config import load
from ross_payload.doctor.examination import measured
from ross_payload.errors import ConfigError, LinkError
from ross_payload.service.check import loaded
from ross_sim.clock import QUANTUM
from ross_sim.devices.far_end import Fault
from waiting import wait_for

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "docs" / "examples" / "plugins" / "reachy_mini"
PAGE = "docs/how-to/reachy-mini.md"
CARD = '''
"""In the place of PortAudio: a card that nobody can open while the daemon has it, and that tells how it is routed."""
import json, os, threading, time, urllib.request
import numpy as np

class PortAudioError(Exception):
    pass

class default:
    device = [0, -1]

def ask(path):
    with urllib.request.urlopen(f"http://{os.environ['DAEMON']}{path}", timeout=20) as answer:
        return json.load(answer)

def query_hostapis():
    return [{"name": "ALSA"}]

def query_devices():
    names = ("Reachy Mini Audio: USB Audio (hw:2,0)",)
    return [{"name": n, "hostapi": 0, "max_input_channels": 2, "default_samplerate": 16000.0} for n in names]

def check_input_settings(**settings):
    if not ask("/api/media/status")["released"]:
        raise PortAudioError("Device unavailable [PaErrorCode -9985]")

def _terminate(): pass
def _initialize(): pass

class InputStream:
    samplerate = 16000

    def __init__(self, callback, **settings):
        names = ("AUDIO_MGR_OP_L", "AUDIO_MGR_OP_R")
        routes = [ask(f"/api/audio/config/parameter/{name}")["values"] for name in names]
        self.scales = np.array([0.01 * 2.0 ** source if category == 3 else 0.0 for category, source in routes])
        self.callback, self.active = callback, False
        self.thread = threading.Thread(target=self.work, daemon=True)

    def start(self):
        self.active = True
        self.thread.start()

    def work(self):
        generator, begin, sent = np.random.default_rng(3), time.monotonic(), 0
        while self.active:
            due = int((time.monotonic() - begin) * 16000)
            frames = generator.normal(0, self.scales, (due - sent, 2)).astype(np.float32)
            if len(frames):
                self.callback(frames, len(frames), None, None)
            sent = due
            time.sleep(0.01)

    def close(self, ignore_errors=True):
        self.active = False
'''


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The example, installed beside its files."""
    folder = tmp_path_factory.mktemp("own") / "reachy_mini"
    shutil.copytree(EXAMPLE, folder, ignore=shutil.ignore_patterns("build", "__pycache__"))
    install(folder)
    shutil.rmtree(folder / "ross_reachy_mini")  # only what is installed counts
    (folder / "site" / "sounddevice.py").write_text(CARD)
    return folder


@contextmanager
def emulated(folder, tmp_path, monkeypatch, port="0"):
    """The emulated daemon in another process; yields its address."""
    monkeypatch.setenv("PYTHONPATH", str(folder / "site"))
    with program(module("ross_reachy_mini.emulated_daemon", port), tmp_path, "daemon.log", code=None) as (_, log):
        address = wait_for(lambda: re.search(r"listens on (\S+)\n", log.read_text()))[1]
        monkeypatch.setenv("DAEMON", address)
        yield address


@pytest.fixture
def daemon(folder, tmp_path, monkeypatch):
    with emulated(folder, tmp_path, monkeypatch) as address:
        yield address


def ask(address, path, method="POST"):
    with urllib.request.urlopen(urllib.request.Request(f"http://{address}{path}", method=method), timeout=30) as answer:
        return json.load(answer)


def configured(folder, address, name="here.toml", extra=""):
    text = (folder / "reachy.toml").read_text().replace("localhost:8000", address)
    (folder / name).write_text(f"{text}watchdog_s = 5\n{extra}[service]\nstate_dir = '{folder}/state'\n")
    return name  # the watchdog: the computer may be busy


def test_its_configuration_is_good(folder):
    done = run_line(folder, command(PAGE, "ross config check"))
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.soak
def test_the_actuator_keeps_the_contract(folder):
    contract = ["pytest", "-q", "-p", "no:cacheprovider", "tests/contract/test_actuator.py"]
    held = run(folder, *contract, "--actuator-kind", "reachy_mini", cwd=ROOT)
    assert held.returncode == 0, held.stdout
    assert int(re.search(r"(\d+) passed", held.stdout)[1]) > 20


@pytest.mark.soak
def test_the_microphones_keep_the_contract(folder, daemon):
    contract = ["pytest", "-q", "-p", "no:cacheprovider", "tests/contract/test_audio_source.py", "-k", "reachy_mini"]
    held = run(folder, *contract, "--audio-source", f"reachy_mini:{daemon}", cwd=ROOT)
    assert held.returncode == 0, held.stdout
    assert int(re.search(r"(\d+) passed", held.stdout)[1]) > 10


@pytest.mark.soak
def test_the_probe_turns_the_head_of_a_daemon_in_another_process(folder, daemon):
    probed = run_line(folder, f"ross actuators probe {configured(folder, daemon)} --move --yes")
    assert probed.returncode == 0, probed.stdout + probed.stderr
    assert "it turns the way it is commanded" in probed.stdout
    assert abs(ask(daemon, "/emulator/state")["angle"]) < 0.03  # there and back


@pytest.mark.parametrize(
    ("trouble", "said"),
    [
        ("sleep", "the head is not upright: wake the robot up first"),
        ("taken", "it did not move"),  # another program moves it, and the daemon ignores targets
    ],
)
def test_a_robot_that_cannot_be_turned_is_a_fault(folder, daemon, trouble, said):
    ask(daemon, f"/emulator/{trouble}")
    probed = run_line(folder, f"ross actuators probe {configured(folder, daemon)} --move --yes")
    assert probed.returncode == 2
    assert said in probed.stdout + probed.stderr


def test_two_raw_microphones_are_heard_and_everything_is_given_back(folder, daemon, monkeypatch):
    before = ask(daemon, "/emulator/state")
    config = load(folder / configured(folder, daemon))
    config = config.model_copy(update={"audio": config.audio.model_copy(update={"channels": (3, 0)})})
    monkeypatch.syspath_prepend(folder / "site")
    monkeypatch.setitem(sys.modules, "sounddevice", module_of(folder / "site" / "sounddevice.py"))
    health, _ = measured(config, SystemClock())
    assert health.level_db == pytest.approx((-22, -40), abs=0.5)  # microphone n has 6 dB n more
    assert ask(daemon, "/emulator/state") == before


def module_of(path):
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_a_daemon_that_cannot_route_them_is_one_line_that_says_what_to_do(folder, daemon):
    ask(daemon, "/emulator/refuse-integers")
    done = run_line(folder, f"ross devices --tap {configured(folder, daemon)}")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr
    assert "do it on its computer: xvf_host AUDIO_MGR_OP_L 3 0; xvf_host AUDIO_MGR_OP_R 3 1" in done.stderr
    assert not ask(daemon, "/emulator/state")["released"]


@pytest.mark.parametrize(("line", "code"), [("ross devices --tap", 2), ("ross actuators probe", 2)])
def test_a_daemon_that_is_not_there_is_one_line(folder, tmp_path, monkeypatch, line, code):
    with emulated(folder, tmp_path, monkeypatch) as address:
        pass
    done = run_line(folder, f"{line} {configured(folder, address)}")
    assert done.returncode == code, done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    assert address.partition(":")[2] in done.stdout + done.stderr


def test_a_daemon_that_goes_is_told_and_one_that_comes_back_is_connected_to(folder, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(folder / "site")
    with emulated(folder, tmp_path, monkeypatch) as address:
        port = open_wire(f"reachy_mini:{address}", SystemClock())
        (first, *_) = wait_for(port.receive)
    with contextlib.closing(port):
        wait_for(lambda: gone(port))
        with emulated(folder, tmp_path / "again", monkeypatch, address.partition(":")[2]):
            state = wait_for(lambda: received(port))[-1]
            port.send({"target_head_pose": state["head_pose"] | {"yaw": 0.3}, "target_body_yaw": 0.3})
            wait_for(lambda: [each for each in received(port) if abs(each["head_pose"]["yaw"] - 0.3) < 0.01])
    assert first["control_mode"] == "enabled"


def gone(port):
    """Why nothing more will arrive; nothing while something does."""
    try:
        port.receive()
    except LinkError as error:
        return str(error)
    return ""


def received(port):
    """What has arrived; nothing while the daemon is gone."""
    with contextlib.suppress(LinkError):
        return port.receive()
    return []


@pytest.fixture
def rig(folder, monkeypatch):
    """Driver and simulated robot in simulated time."""
    monkeypatch.syspath_prepend(folder / "site")
    rig = rig_of("reachy_mini").open()
    yield rig
    rig.actuator.__exit__(None, None, None)


def angles(rig, seconds):
    seen = []
    for _ in range(round(seconds / QUANTUM)):
        rig.clock.sleep(QUANTUM)
        seen.append(rig.far_end.angle())
    return np.array(seen)


def test_motors_that_are_off_are_switched_on_without_a_jump(rig):
    rig.far_end.mode = "disabled"
    rig.clock.sleep(0.1)
    rig.actuator.command(1.0)
    steps = np.abs(np.diff(angles(rig, 3.0)))
    assert steps.max() < 2 * rig.speed * QUANTUM  # a set-point comes every other quantum
    assert rig.far_end.mode == "enabled"
    assert rig.far_end.angle() == pytest.approx(1.0, abs=rig.tolerance)


def test_motors_that_go_off_in_a_turn_are_a_fault_and_nothing_switches_them_on(rig):
    rig.actuator.command(1.5)
    rig.clock.sleep(0.6)
    rig.far_end.mode = "disabled"
    rig.clock.sleep(1.0)
    assert rig.state.fault == "the motors are disabled: expected enabled"
    assert rig.far_end.mode == "disabled"


def test_a_head_that_does_not_follow_is_a_fault(rig):
    rig.far_end.afflict(Fault.TAKEN)
    rig.actuator.command(1.5)
    rig.clock.sleep(4.0)
    assert "the head does not follow" in rig.state.fault


def test_a_head_that_hangs_is_not_turned(rig):
    rig.far_end.lie_down()
    rig.clock.sleep(0.1)
    rig.actuator.command(1.5)
    assert np.ptp(angles(rig, 1.0)) == 0
    assert rig.state.fault == "the head is not upright: wake the robot up first"


def test_at_rest_nothing_is_sent_so_that_others_may_move_it(rig, monkeypatch):
    rig.actuator.command(0.5)
    rig.settle(within=3.0)
    rig.clock.sleep(0.5)
    sent = []
    monkeypatch.setattr(rig.far_end, "take", sent.append)
    rig.clock.sleep(1.0)
    assert sent == []


def test_release_switches_the_motors_off(rig):
    rig.actuator.release()
    rig.clock.sleep(0.1)
    assert rig.far_end.mode == "disabled"


def test_nod_and_height_stay_as_they_were(rig):
    rig.far_end.take({"target_head_pose": dict.fromkeys(("x", "y", "roll", "yaw"), 0.0) | {"pitch": 0.2, "z": 0.01}})
    rig.clock.sleep(0.5)
    rig.actuator.command(1.0)
    rig.settle(within=3.0)
    pose = rig.far_end.state()["head_pose"]
    assert (pose["pitch"], pose["z"], pose["yaw"]) == pytest.approx((0.2, 0.01, 1.0), abs=1e-3)


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        (
            "channels = [0, 1]",
            "channels = [0, 4]",
            "audio.channels: expected 0 to 3, microphones of the robot, got [0, 4]",
        ),
        ('{ port = "reachy_mini:localhost:8000" }', "{ body_follows = false }", "within -65 to 65, got -160 and 160"),
        ('"reachy_mini:localhost:8000"\nch', '"reachy_mini:localhost"\nch', "audio.source: expected tcp:HOST:PORT"),
    ],
)
def test_a_mistake_in_the_configuration_is_one_line(folder, monkeypatch, before, after, said):
    monkeypatch.syspath_prepend(folder / "site")
    text = (folder / "reachy.toml").read_text()
    assert before in text
    (folder / "wrong.toml").write_text(text.replace(before, after))
    with pytest.raises(ConfigError) as error:
        loaded(folder / "wrong.toml")
    assert said in str(error.value)
    assert "\n" not in str(error.value)
