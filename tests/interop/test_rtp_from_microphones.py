"""From the wave at the microphone, through PulseAudio, PortAudio and ``ross run``, to a player of others; a figure."""

import contextlib
import fcntl
import os
import shutil
import subprocess
import threading
from pathlib import Path

import numpy as np
import pytest

from ports import free_port
from processes import ROSS
from rtp_players import Player, delay_of, ffmpeg, found_in, in_use
from voice_sender import CLOCK, RATE
from waiting import wait_for

SECONDS = 40.0  # of noise
PLAYED = 8.0  # of it that are waited for
PAYLOAD = """
[audio]
source = "device:pulse"
[actuator]
kind = "tb6600"
[service]
state_dir = "state"
[[links]]
url = "udpin:127.0.0.1:{link}"
[[listening.streams]]
sink = "rtp"
what = "mixture"
options = {{ address = "127.0.0.1", port = {port}, codec = "{codec}" }}
"""
SDP = (
    "v=0\no=- 1 1 IN IP4 127.0.0.1\ns=-\nc=IN IP4 127.0.0.1\nt=0 0\n"
    "m=audio {port} RTP/AVP {kind}\na=rtpmap:{kind} {name}\n"
)
KINDS = {"opus": (111, "opus/48000/2"), "L16": (96, f"L16/{RATE}/1")}


class Microphones:
    """A sound server with two microphones, which hear noise in the pace of the clock."""

    def __init__(self, folder, noise):
        self._folder, self._over = folder, threading.Event()
        self._data = np.rint(np.repeat(noise[:, None], 2, axis=1) * 32767).astype("<i2").tobytes()
        names = {"PULSE_SERVER": f"unix:{folder / 'native'}", "PULSE_RUNTIME_PATH": folder, "HOME": folder}
        self.environment = os.environ | {name: str(value) for name, value in names.items()}
        self.environment["XDG_CONFIG_HOME"] = str(folder)
        self._writer = threading.Thread(target=self._write)
        self.began = 0.0

    def __enter__(self):
        source = f"module-pipe-source source_name=mic file={self._folder / 'pipe'} format=s16le rate={RATE} channels=2"
        command = ["pulseaudio", "-n", "--daemonize=no", "--exit-idle-time=-1", "--use-pid-file=no", "-L"]
        command += [f"module-native-protocol-unix socket={self._folder / 'native'} auth-anonymous=1", "-L", source]
        with (self._folder / "pulse.log").open("ab") as log:
            self._server = subprocess.Popen(command, env=self.environment, stdout=log, stderr=log)
        wait_for((self._folder / "native").exists, what=(self._folder / "pulse.log").read_text)
        self._writer.start()
        return self

    def __exit__(self, *_):
        self._over.set()
        self._writer.join()
        self._server.kill()
        self._server.wait()

    def _write(self):
        pipe = os.open(self._folder / "pipe", os.O_WRONLY | os.O_NONBLOCK)
        fcntl.fcntl(pipe, fcntl.F_SETPIPE_SZ, 4096)  # 64 ms: what nobody records is gone, and does not wait
        self.began, sent = CLOCK.now(), 0
        with contextlib.suppress(BrokenPipeError):
            while not self._over.wait(0.005) and sent < len(self._data):
                due = min(int((CLOCK.now() - self.began) * RATE) * 4, len(self._data))
                with contextlib.suppress(BlockingIOError):
                    os.write(pipe, self._data[sent:due])
                sent = due
        os.close(pipe)


@pytest.mark.soak
@pytest.mark.parametrize("codec", ["opus", "L16"])
def test_what_a_microphone_hears_is_played_soon(tmp_path, codec):
    for name in ("pulseaudio", "ffmpeg"):
        if shutil.which(name) is None:
            pytest.skip(f"{name} is missing; see tests/support/debian_packages.sh")
    folder = Path(os.path.realpath(tmp_path)) / "p"  # a socket's path is short
    folder.mkdir(mode=0o700)
    noise = 0.1 * np.random.default_rng(0).standard_normal(round(SECONDS * RATE)).clip(-4, 4)
    port, link = free_port(2), free_port()
    (tmp_path / "payload.toml").write_text(PAYLOAD.format(port=port, link=link, codec=codec))
    kind, name = KINDS[codec]
    (tmp_path / "voice.sdp").write_text(SDP.format(port=port, kind=kind, name=name))
    with Microphones(folder, noise) as microphones, (tmp_path / "log").open("wb") as log:
        playing = Player(ffmpeg(str(tmp_path / "voice.sdp"), port, codec))
        wait_for(lambda: in_use(port))
        command = ["env", *ROSS, "run", "payload.toml"]
        payload = subprocess.Popen(command, cwd=tmp_path, env=microphones.environment, stderr=log)
        try:
            wait_for(lambda: playing.seconds > PLAYED or payload.poll() is not None, what=(tmp_path / "log").read_text)
        finally:
            samples, times, counts = playing.end()
            payload.terminate()
            payload.wait()
    assert len(samples) > 2 * RATE, (tmp_path / "log").read_text()
    place, _ = found_in(noise, samples)
    delay = delay_of(place, microphones.began, samples, times, counts)
    print(f"{codec}: {1000 * delay:.0f} ms from the microphone to the output of ffmpeg")  # noqa: T201 - the figure
    assert 0.05 < delay < 0.4
