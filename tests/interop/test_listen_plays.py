"""``ross listen`` plays through PortAudio into a real sound system, PulseAudio in user space."""

import os
import shutil
import subprocess
import threading
from pathlib import Path

import numpy as np
import pytest

from processes import ROSS
from voice_sender import RATE, ear, opened, talking
from waiting import wait_for

PITCH = 400.0  # of what is played [Hz]
PLUGIN = "alsa-lib/libasound_module_pcm_pulse.so"


class Loudspeaker:
    """A sound server with one output, and what is played into it."""

    def __init__(self, folder):
        self.environment = os.environ | {
            "PULSE_SERVER": f"unix:{folder / 'native'}",
            "PULSE_RUNTIME_PATH": str(folder),
            "XDG_CONFIG_HOME": str(folder),
            "HOME": str(folder),
        }
        self._folder, self._parts = folder, []
        self._reader = threading.Thread(target=self._read)

    def __enter__(self):
        out = f"module-null-sink sink_name=out format=s16le rate={RATE} channels=1"
        command = ["pulseaudio", "-n", "--daemonize=no", "--exit-idle-time=-1", "--use-pid-file=no", "-L"]
        command += [f"module-native-protocol-unix socket={self._folder / 'native'} auth-anonymous=1", "-L", out]
        with (self._folder / "pulse.log").open("ab") as log:
            self._server = subprocess.Popen(command, env=self.environment, stdout=log, stderr=log)
        wait_for((self._folder / "native").exists, what=(self._folder / "pulse.log").read_text)
        command = ["parec", "--device=out.monitor", "--raw", "--format=s16le", f"--rate={RATE}", "--channels=1"]
        self._recorder = subprocess.Popen(command, env=self.environment, stdout=subprocess.PIPE)
        self._reader.start()
        return self

    def __exit__(self, *_):
        for process in (self._recorder, self._server):
            process.kill()
            process.wait()
        self._reader.join()
        self._recorder.stdout.close()

    def _read(self):
        while part := os.read(self._recorder.stdout.fileno(), 4096):
            self._parts.append(part)

    @property
    def samples(self):
        data = b"".join(self._parts)
        return np.frombuffer(data[: len(data) // 2 * 2], "<i2") / 32768


@pytest.fixture
def loudspeaker(tmp_path):
    if shutil.which("pulseaudio") is None:
        pytest.skip("needs the package pulseaudio")
    if not any(Path("/usr/lib").glob(f"*/{PLUGIN}")):
        pytest.skip("needs the package libasound2-plugins")
    folder = Path(os.path.realpath(tmp_path)) / "p"  # a socket's path is short
    folder.mkdir(mode=0o700)
    with Loudspeaker(folder) as server:
        yield server


def played(loudspeaker):
    """What was played of a second or more, without the silence before it; empty until there is as much."""
    samples = loudspeaker.samples
    loud = np.flatnonzero(np.abs(samples) > 0.1)
    return samples[loud[0] : loud[0] + RATE] if len(loud) > RATE else samples[:0]


def test_a_tone_that_is_streamed_is_played(loudspeaker, tmp_path):
    tone = 0.5 * np.sin(2 * np.pi * PITCH * np.arange(4 * RATE) / RATE)
    with ear() as sock:
        port = sock.getsockname()[1]
    command = ["env", *ROSS, "listen", f"rtp://127.0.0.1:{port}?codec=L16&rate={RATE}", "--device", "pulse"]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with opened(port, tmp_path, codec="L16") as sink, talking(sink, tone):
        listener = subprocess.Popen(command, env=loudspeaker.environment | {"PYTHONUNBUFFERED": "1"}, **pipes)
        try:
            wait_for(lambda: len(played(loudspeaker)) or listener.poll() is not None)
            second = played(loudspeaker)
            wait_for(lambda: "since the microphone" in listener.stdout.readline() or listener.poll() is not None)
        finally:
            listener.terminate()
            _, complained = listener.communicate()
    assert listener.returncode == 130, complained
    spectrum = np.abs(np.fft.rfft(second * np.hanning(len(second))))
    assert np.argmax(spectrum) == pytest.approx(PITCH * len(second) / RATE, abs=2)
