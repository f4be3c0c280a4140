"""A real sound system, PulseAudio in user space: what is played into its microphones arrives through PortAudio."""

import contextlib
import json
import os
import shutil
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from processes import ROSS

RATE, CHANNELS = 16000, 4
PERIODS = (16, 20, 32, 40)  # of the tone on each channel [samples]
AMPLITUDE = 0.25
PLUGIN = "alsa-lib/libasound_module_pcm_pulse.so"

PAYLOAD = """
import json, sys, time
import numpy as np
from ross_payload.audio.open_source import open_source
from ross_payload.clock import SystemClock
from ross_payload.config import Config, validated
from ross_payload.errors import RossError
from ross_payload.interfaces import AudioFlag

asked = json.loads(sys.argv[1])
config = validated(Config, {"audio": asked["audio"]}, "test")
blocks = []
try:
    with open_source(config, SystemClock()) as source:
        print("open", flush=True)
        wall, cpu = time.monotonic(), time.process_time()
        hops = config.audio.rate_hz / config.hop
        end = asked["seconds"] * hops
        while len(blocks) < end:
            blocks.append(source.read(config.hop))
            if not source.status().reopened:
                end = min(max(end, len(blocks) + asked["after_s"] * hops), 60 * hops)
            if len(blocks) == 100:
                time.sleep(asked["busy_s"])
        cpu, status = (time.process_time() - cpu) / (time.monotonic() - wall), source.status()
except RossError as error:
    sys.exit(f"{type(error).__name__}: {error}")
samples = np.concatenate([block.samples for block in blocks], axis=1)
missing = np.array([bool(block.flags & AudioFlag.MISSING) for block in blocks])
times = np.array([block.time for block in blocks])
np.savez(asked["out"], samples=samples, missing=missing, times=times)
print(json.dumps({"lost": status.lost, "reopened": status.reopened, "cpu": cpu, "trouble": status.trouble}))
"""


class Pulse:
    """The server, and somebody who plays a tone on each channel of its only microphone in real time."""

    def __init__(self, folder):
        self._folder = folder
        self._pipe = folder / "pipe"
        self.environment = os.environ | {
            "PULSE_SERVER": f"unix:{folder / 'native'}",
            "PULSE_RUNTIME_PATH": str(folder),
            "XDG_CONFIG_HOME": str(folder),
            "HOME": str(folder),
        }
        self._server = None
        self._over = threading.Event()
        self._player = threading.Thread(target=self._play)

    def start(self):
        channel_map = "front-left,front-right,rear-left,rear-right"
        source = f"module-pipe-source source_name=mic file={self._pipe} format=s16le rate={RATE}"
        command = ["pulseaudio", "-n", "--daemonize=no", "--exit-idle-time=-1", "--use-pid-file=no", "-L"]
        command += [f"module-native-protocol-unix socket={self._folder / 'native'} auth-anonymous=1", "-L"]
        command += [f"{source} channels={CHANNELS} channel_map={channel_map}"]
        with (self._folder / "pulse.log").open("ab") as log:
            self._server = subprocess.Popen(command, env=self.environment, stdout=log, stderr=log)
        until = time.monotonic() + 20
        while not (self._folder / "native").exists():
            assert time.monotonic() < until, (self._folder / "pulse.log").read_text()
            time.sleep(0.05)

    def kill(self):
        self._server.kill()
        self._server.wait()
        for name in ("native", "pipe"):
            (self._folder / name).unlink(missing_ok=True)

    def __enter__(self):
        self.start()
        self._player.start()
        return self

    def __exit__(self, *_):
        self._over.set()
        self._player.join()
        self.kill()

    def _play(self):
        while not self._over.is_set():
            with contextlib.suppress(OSError):  # no server, or it died: play to the next one
                pipe = os.open(self._pipe, os.O_WRONLY | os.O_NONBLOCK)
                with open(pipe, "wb", buffering=0) as sink:  # noqa: PTH123 - a descriptor
                    self._play_into(sink)
            time.sleep(0.05)

    def _play_into(self, sink):
        begin, count, waiting = time.monotonic(), 0, b""
        while not self._over.is_set():
            due = round((time.monotonic() - begin) * RATE)
            numbers = np.arange(count, due)
            tones = [AMPLITUDE * np.sin(2 * np.pi * numbers / period) for period in PERIODS]
            waiting += np.rint(np.stack(tones, axis=1) * 2**15).astype("<i2").tobytes()
            waiting = waiting[sink.write(waiting) or 0 :]  # after a pause it is more than the pipe takes
            count = due
            time.sleep(0.01)


@pytest.fixture
def pulse(tmp_path):
    if shutil.which("pulseaudio") is None:
        pytest.skip("needs the package pulseaudio")
    if not any(Path("/usr/lib").glob(f"*/{PLUGIN}")):
        pytest.skip("needs the package libasound2-plugins")
    try:
        import sounddevice  # noqa: F401
    except OSError:
        pytest.skip("needs the package libportaudio2")
    folder = Path(os.path.realpath(tmp_path)) / "p"  # a socket's path is short
    folder.mkdir(mode=0o700)
    with Pulse(folder) as server:
        yield server


class Payload:
    """A payload that records, in another process."""

    def __init__(self, pulse, folder, *, seconds, after_s=0.0, busy_s=0.0, **audio):
        """Record for ``seconds`` [s], and ``after_s`` [s] from when the device was opened again, a minute at most."""
        self._out = folder / "heard.npz"
        audio = {"source": "device:pulse", "device_channels": CHANNELS} | audio
        asked = json.dumps(
            {"audio": audio, "seconds": seconds, "after_s": after_s, "busy_s": busy_s} | {"out": str(self._out)}
        )
        command = [sys.executable, "-c", PAYLOAD, asked]
        environment = pulse.environment | {"OMP_NUM_THREADS": "1"}
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
        self.process = subprocess.Popen(command, env=environment, **pipes)

    def wait_until_open(self):
        assert self.process.stdout.readline() == "open\n", self.process.stderr.read()

    def finish(self):
        """What was heard: samples, flags, times, and the status at the end."""
        out, error = self.process.communicate(timeout=120)
        assert self.process.returncode == 0, error
        return np.load(self._out), json.loads(out.splitlines()[-1])


def tone(samples, period):
    """The amplitude of a tone."""
    phase = np.exp(-2j * np.pi * np.arange(len(samples)) / period)
    return 2 * abs(np.mean(samples * phase))


def repeats(samples, period):
    """Whether a tone goes on without a jump."""
    return np.abs(samples[period:] - samples[:-period]).max() < 1e-4


@pytest.mark.alone
def test_each_tone_arrives_on_its_channel_unbroken_while_the_reader_is_busy(pulse, tmp_path):
    heard, status = Payload(pulse, tmp_path, seconds=2.5, busy_s=1.0, channels=(2, 1)).finish()
    first, second = heard["samples"][:, -2 * RATE :]
    assert tone(first, PERIODS[2]) == pytest.approx(AMPLITUDE, rel=0.01)
    assert tone(second, PERIODS[1]) == pytest.approx(AMPLITUDE, rel=0.01)
    assert tone(first, PERIODS[1]) < 1e-3
    assert tone(second, PERIODS[2]) < 1e-3
    assert status["lost"] == 0
    assert repeats(heard["samples"][0], PERIODS[2])
    assert np.diff(heard["times"]) == pytest.approx(0.01, rel=0.011)
    assert status["cpu"] < 0.15


def test_a_server_that_is_killed_is_found_again_and_the_gap_is_as_long_as_it_was(pulse, tmp_path):
    payload = Payload(pulse, tmp_path, seconds=4, after_s=2)  # a busy computer notices late, and opens late
    payload.wait_until_open()
    time.sleep(0.5)
    pulse.kill()
    time.sleep(1)
    pulse.start()
    heard, status = payload.finish()
    assert status["reopened"] >= 1
    assert status["trouble"] == ""
    assert status["lost"] / RATE > 1.0
    assert np.sum(heard["missing"]) * 0.01 == pytest.approx(status["lost"] / RATE, abs=0.3)
    assert tone(heard["samples"][0, -RATE:], PERIODS[0]) == pytest.approx(AMPLITUDE, rel=0.05)
    assert np.diff(heard["times"]) == pytest.approx(0.01, rel=0.011)


def test_a_device_that_does_not_exist_gets_one_line_with_those_that_do(pulse, tmp_path):
    payload = Payload(pulse, tmp_path, seconds=1, source="device:violin")
    _, error = payload.process.communicate(timeout=60)
    assert payload.process.returncode == 1
    assert "no microphones named 'violin'; there are:" in error
    assert "'pulse' (ALSA" in error


def test_ross_devices_lists_the_real_devices(pulse):
    command = [*ROSS, "devices", "--json"]
    listed = subprocess.run(command, env=pulse.environment, capture_output=True, text=True, check=True, timeout=60)
    assert "pulse" in [device["name"] for device in json.loads(listed.stdout)]
