"""Players of others, on real sockets: what they play, and how late it comes out of them."""

import os
import shutil
import socket
import subprocess
import threading

import numpy as np
import pytest
import scipy.signal

from lossy_network import voiced
from ross_payload.audio.sinks import info_of
from voice_sender import CLOCK, RATE, ear, opened, talking
from waiting import wait_for

VOICE = voiced(20.0, RATE) + 0.01 * np.random.default_rng(1).standard_normal(20 * RATE).astype(np.float32)
SECONDS = 6.0  # that are played
RAW = f"audio/x-raw,format=F32LE,rate={RATE},channels=1"
CAPS = "application/x-rtp,media=audio,clock-rate={},encoding-name={},payload={}"
CODECS = {
    "opus": (CAPS.format(48000, "OPUS", 111), "rtpopusdepay ! opusdec plc=true use-inband-fec=true"),
    "L16": (CAPS.format(RATE, "L16", 96) + ",channels=1", "rtpL16depay"),
}


def ffmpeg(sdp, _port, _codec):
    quick = "-protocol_whitelist file,udp,rtp -fflags nobuffer -flags low_delay -probesize 32 -analyzeduration 0"
    return ["ffmpeg", "-loglevel", "error", *quick.split(), "-i", sdp, *f"-f f32le -ar {RATE} -ac 1 -".split()]


def gstreamer(_sdp, port, codec):
    caps, decoder = CODECS[codec]
    line = f"udpsrc port={port} address=127.0.0.1 caps={caps} ! rtpjitterbuffer latency=60 ! {decoder}"
    return ["gst-launch-1.0", "-q", *f"{line} ! audioconvert ! audioresample ! {RAW} ! fdsink fd=1 sync=false".split()]


class Player:
    """A program that writes samples of 32 bits to its output, each with the time at which it came."""

    def __init__(self, command):
        self._process = subprocess.Popen(command, stdout=subprocess.PIPE)
        self._parts = []
        self._thread = threading.Thread(target=self._read)
        self._thread.start()

    def _read(self):
        while part := os.read(self._process.stdout.fileno(), 65536):
            self._parts.append((CLOCK.now(), part))

    @property
    def seconds(self):
        return sum(len(part) for _, part in self._parts) / 4 / RATE

    def end(self):
        self._process.kill()
        self._process.wait()
        self._thread.join()
        self._process.stdout.close()
        times = np.array([time for time, _ in self._parts])
        data = b"".join(part for _, part in self._parts)
        return np.frombuffer(data[: len(data) // 4 * 4], "<f4"), times, np.cumsum([len(p) for _, p in self._parts]) / 4


@pytest.mark.parametrize("codec", ["opus", "L16"])
@pytest.mark.parametrize("player", [ffmpeg, gstreamer], ids=lambda player: player.__name__)
def test_a_player_of_others_plays_it_at_once(tmp_path, record_property, player, codec):
    command = player("voice.sdp", 0, codec)[0]
    if shutil.which(command) is None:
        pytest.skip(f"{command} is missing; see tests/support/debian_packages.sh")
    with ear() as sock:
        port = sock.getsockname()[1]
    with opened(port, tmp_path, codec=codec) as sink:
        (tmp_path / "voice.sdp").write_text(info_of(sink).sdp)
        playing = Player(player(str(tmp_path / "voice.sdp"), port, codec))
        try:
            wait_for(lambda: _in_use(port))
            with talking(sink, VOICE) as began:
                wait_for(lambda: playing.seconds > SECONDS)
        finally:
            samples, times, counts = playing.end()
    last = len(samples) - RATE  # a second of what was played, somewhere in the voice
    sought = samples[last:].astype(float)
    spoken = np.tile(VOICE, 2).astype(float)
    energy = scipy.signal.correlate(spoken**2, np.ones(RATE), "valid", "fft")
    place = int(np.argmax(scipy.signal.correlate(spoken, sought, "valid", "fft") / np.sqrt(np.maximum(energy, 1e-3))))
    original = spoken[place : place + RATE]
    scaled = original * (original @ sought) / (original @ original)
    quality = 10 * np.log10(scaled @ scaled / ((sought - scaled) @ (sought - scaled)))
    assert quality > {"opus": 10, "L16": 60}[codec]
    heard_at = began + (place - last + counts) / RATE  # of the last sample of each part
    delay = float(np.median((times - heard_at)[counts > RATE]))
    record_property("quality_db", round(quality, 1))
    record_property("delay_ms", round(1000 * delay))
    assert -0.03 < delay < 0.4


def _in_use(port):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        try:
            sock.bind(("127.0.0.1", port))
        except OSError:
            return True
    return False
