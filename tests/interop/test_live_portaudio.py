"""A payload in real time beside `ross world` hears, turns and finds what a mission in lock-step does.

Over TCP, and through a real sound system: the world feeds PulseAudio, the payload listens by PortAudio. What is heard
is what the world made, sample by sample, and all that is not is counted, whatever the computer does. The voice is held
to that of lock-step when the computer did not pause.
"""

import ctypes.util
import json
import os
import shutil
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest

from processes import ROSS, program
from waiting import wait_for

PAYLOAD = Path(__file__).with_name("live_payload.py")
SUPPORT = Path(__file__).parents[1] / "support"
PULSE_PLUGIN = "libasound_module_pcm_pulse.so"
RATE = 16000
TALKERS = (40, 155, -80)  # [deg], also those of the demo
LESS = 1.5  # [dB]: a mission that a pause has delayed hears other words
LEAST = 6.0  # [dB]: one that the computer paused for a while, too
LATE = 0.4  # [s] by which a world that computes late, and says so, may silence its microphones
SHORT = """
title = "a short mission in real time"
target = 2
[payload.explore]
lead_in_s = 1.0
unit_s = 1.0
min_rotations = 2
max_rotations = 2
[payload.exploit]
separator = "gaussian"
track = false
check_s = 1.0
run_s = 2.0
max_restarts = 0
[noise]
snr_db = 25
[[talkers]]
azimuth_deg = 40
start_s = 1.3
[[talkers]]
azimuth_deg = 155
start_s = 1.3
[[talkers]]
azimuth_deg = -80
start_s = 1.3
"""
PATIENT = """
[payload.actuator.options]
ahead_ms = 100
"""
SIX = """
[payload.explore]
min_rotations = 6
max_rotations = 6
"""  # as in lock-step: one rotation more, and another ten seconds are separated
SCENARIOS = Path(__file__).parents[2] / "sim" / "scenarios"


@pytest.fixture
def sound_card(tmp_path):
    """A PulseAudio server of our own with one microphone pair, fed by a pipe; gives the pipe and the environment."""
    lacking = {
        "pulseaudio": shutil.which("pulseaudio"),
        "libportaudio2": ctypes.util.find_library("portaudio"),
        "libasound2-plugins": next(Path("/usr/lib").glob(f"*/alsa-lib/{PULSE_PLUGIN}"), None),
    }
    for package, found in lacking.items():
        if not found:
            pytest.skip(f"needs a system package: apt-get install {package}")
    with pulse(tmp_path / "pulse") as (pipe, environment):
        yield pipe, environment


@contextmanager
def pulse(folder):
    folder.mkdir(mode=0o700)
    socket, pipe = folder / "native", folder / "microphones"
    modules = [
        f"module-native-protocol-unix socket={socket} auth-anonymous=1",
        f"module-pipe-source file={pipe} format=float32le rate=16000 channels=2 channel_map=front-left,front-right",
    ]
    own = {"HOME": folder, "PULSE_RUNTIME_PATH": folder, "PULSE_STATE_PATH": folder, "XDG_RUNTIME_DIR": folder}
    environment = os.environ | {name: str(path) for name, path in own.items()}
    command = ["pulseaudio", "-n", "--daemonize=no", "--exit-idle-time=-1", "--use-pid-file=no", "--disable-shm=yes"]
    loads = [part for module in modules for part in ("-L", module)]
    with (folder / "log").open("w") as log, subprocess.Popen([*command, *loads], env=environment, stderr=log) as server:
        try:
            wait_for(lambda: (pipe.exists() and socket.exists()) or server.poll() is not None)
            assert server.poll() is None, (folder / "log").read_text()
            yield pipe, os.environ | {"PULSE_SERVER": f"unix:{socket}"}
        finally:
            server.terminate()


def fly(scenario, folder, pipe=None, environment=None, alone=()):
    """Fly live and in lock-step; the two reports. ``alone``: only live."""
    quiet = 0.0 if pipe is None else 0.5  # [s]: about as long as a sound card takes until it is heard
    sound = ["--pcm", "tcp:127.0.0.1:0"] if pipe is None else ["--pipe", pipe, "--format", "f32le"]
    out = folder / "flown"
    options = ["world", scenario, "--json", "--quiet", quiet, "--out", out, *sound]
    with program([*ROSS, *options], folder, stdout=subprocess.PIPE, lives=False) as (world, _):
        told = json.loads(world.stdout.readline()) | {"pid": world.pid}
        command = [sys.executable, PAYLOAD, scenario, out, str(quiet), json.dumps(told), *alone]
        environment = (environment or os.environ) | {"PYTHONPATH": str(SUPPORT)}
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False, timeout=290)
        assert done.returncode == 0, done.stderr
    reports = json.loads(done.stdout)
    return reports["live"], reports["lock_step"]


def is_sound(live):
    """Nothing but what is told was lost of what was heard, and everybody is found, and the target by voice."""
    told = {name: live[name] for name in ("lost", "zeros", "stretches", "late_s", "complaints", "reason")}
    assert all(place == (0, 0.0) for place in map(tuple, live["stretches"])), f"in its place, unchanged: {told}"
    assert 0 <= live["lost"] - live["zeros"] <= live["unread"], f"all that is lost is told: {told}"
    assert live["lost"] <= (RATE * live["late_s"] if live["late_s"] > LATE else 0), told
    assert (live["complaints"], live["outcome"]) == ([], "target_found"), told
    assert found(live) == pytest.approx(TALKERS, abs=3.0)
    assert gain(live) > LEAST, told


def agree(live, lock_step):
    is_sound(live)
    assert lock_step["outcome"] == "target_found"
    assert found(live) == pytest.approx(found(lock_step), abs=1.5)
    paused = live["lost"] or live["late_s"] > LATE  # of a voice with holes SI-SDR tells the holes
    assert paused or gain(live) > gain(lock_step) - LESS


def found(report):
    """The azimuth of the source nearest to each talker [deg]."""
    azimuths = [source["azimuth_deg"] for source in report["sources"]]
    return [min(azimuths, key=lambda azimuth: abs((azimuth - talker + 180) % 360 - 180)) for talker in TALKERS]


def gain(report):
    return next(group["si_sdri_db"] for group in report["groups"] if group["target"])


@pytest.fixture
def short(tmp_path):
    path = tmp_path / "short.toml"
    path.write_text(SHORT + PATIENT)
    return path


def test_over_tcp_a_short_mission_hears_all_and_finds_everybody(short, tmp_path):
    is_sound(fly(short, tmp_path, alone=("alone",))[0])


@pytest.mark.soak
def test_over_tcp_a_short_mission_is_that_of_lock_step(short, tmp_path):
    agree(*fly(short, tmp_path))


@pytest.mark.alone
@pytest.mark.soak
def test_through_a_sound_card_a_short_mission_is_that_of_lock_step(sound_card, short, tmp_path):
    pipe, environment = sound_card
    agree(*fly(short, tmp_path, pipe, environment))


@pytest.mark.alone
@pytest.mark.soak
def test_through_a_sound_card_the_demo_is_that_of_lock_step(sound_card, tmp_path):
    path = tmp_path / "demo.toml"
    path.write_text((SCENARIOS / "demo.toml").read_text() + PATIENT + SIX)
    pipe, environment = sound_card
    agree(*fly(path, tmp_path, pipe, environment))
