"""``ross listen`` plays through PortAudio into a real sound system, PulseAudio in user space."""

import subprocess

import numpy as np
import pytest

from processes import ROSS
from voice_sender import RATE, ear, opened, talking
from waiting import wait_for

PITCH = 400.0  # of what is played [Hz]


def played(loudspeaker):
    """What was played of a second or more, without the silence before it; empty until there is as much."""
    samples = loudspeaker.samples
    loud = np.flatnonzero(np.abs(samples) > 0.1)
    return samples[loud[0] : loud[0] + RATE] if len(loud) > RATE else samples[:0]


@pytest.mark.soak
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
