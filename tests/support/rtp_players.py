"""Players of others that write what they play to their output: ffmpeg and GStreamer."""

import os
import socket
import subprocess
import threading

import numpy as np
import scipy.signal

from voice_sender import CLOCK, RATE

RAW = f"audio/x-raw,format=F32LE,rate={RATE},channels=1"
CAPS = "application/x-rtp,media=audio,clock-rate={},encoding-name={},payload={}"
CODECS = {
    "opus": (CAPS.format(48000, "OPUS", 111), "rtpopusdepay ! opusdec plc=true use-inband-fec=true"),
    "L16": (CAPS.format(RATE, "L16", 96) + ",channels=1", "rtpL16depay"),
}


def ffmpeg(sdp, _port, _codec):
    """Return the command of ffmpeg."""
    quick = "-protocol_whitelist file,udp,rtp -fflags nobuffer -flags low_delay -probesize 32 -analyzeduration 0"
    return ["ffmpeg", "-loglevel", "error", *quick.split(), "-i", sdp, *f"-f f32le -ar {RATE} -ac 1 -".split()]


def gstreamer(_sdp, port, codec):
    """Return the command of GStreamer."""
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
        """How much was played [s]."""
        return sum(len(part) for _, part in self._parts) / 4 / RATE

    def end(self):
        """Stop it; return samples (n,), when each part came [s], and how many had come by then."""
        self._process.kill()
        self._process.wait()
        self._thread.join()
        self._process.stdout.close()
        times = np.array([time for time, _ in self._parts])
        data = b"".join(part for _, part in self._parts)
        return np.frombuffer(data[: len(data) // 4 * 4], "<f4"), times, np.cumsum([len(p) for _, p in self._parts]) / 4


def found_in(voice, samples):
    """Return where in a voice (n,) the last second of what was played begins [samples], and its SI-SDR [dB]."""
    sought, spoken = samples[len(samples) - RATE :].astype(float), voice.astype(float)
    energy = scipy.signal.correlate(spoken**2, np.ones(RATE), "valid", "fft")
    place = int(np.argmax(scipy.signal.correlate(spoken, sought, "valid", "fft") / np.sqrt(np.maximum(energy, 1e-3))))
    original = spoken[place : place + RATE]
    scaled = original * (original @ sought) / (original @ original)
    return place, 10 * np.log10(scaled @ scaled / ((sought - scaled) @ (sought - scaled)))


def delay_of(place, began, samples, times, counts):
    """Return how late [s] the newest sample of each part that a player wrote was, in the median."""
    heard_at = began + (place - (len(samples) - RATE) + counts) / RATE
    return float(np.median((times - heard_at)[counts > RATE]))


def in_use(port):
    """Tell whether a program has a UDP port open."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        try:
            sock.bind(("127.0.0.1", port))
        except OSError:
            return True
    return False
