"""`ross run` in a process of its own with a `tb6600`, its ground station, and the far end of its pulses."""

import math
import subprocess
import sys
import time
from contextlib import ExitStack, contextmanager

import numpy as np
import pytest
import soundfile

from ross_payload.actuators.tb6600.pulse_segments import PulseCodec, PulseLine, RecordingPulses
from ross_payload.clock import SystemClock, hurry
from ross_sim.devices.wire_servers import WireServer
from waiting import wait_for

BUSY = "while True: pass"
RATE, SECONDS = 16000, 600  # of noise
LOOPBACK = "127.0.0.1"
AT_REST = 0.2  # [s] without a step: longer than between two of them, and than a segment is on its way
STEPS = 112.5 / 0.1125  # acceleration [1/s^2] at sixteenth steps
FASTEST = 225 / 0.1125  # [1/s]
TURN, STOP, CANCEL, REARM, HOME = 54003, 54004, 54005, 54009, 54010
CONFIG = """
[audio]
source = "file:noise.wav"
[actuator]
kind = "tb6600"
options = {{ port = "{wire}", ahead_ms = {ahead_ms} }}
[service]
state_dir = "state"
[[links]]
url = "udpin:127.0.0.1:{port}"
"""
SEPARATING = """
import threading
import numpy as np
from ross_payload import cli, plugins
from ross_payload.computing import computing
from ross_payload.dsp.stft import Stft
from ross_payload.interfaces import Scene

stft = Stft(16000, 2048, 512)
heard = stft.analyse(np.random.default_rng(0).laplace(size=(2, 160000)).astype(np.float32))
scene = Scene(stft.frequencies, 0.05, 343.0, 3, np.array([1e-4, -1e-4, 0.0]), None)
separator = plugins.load("ross_payload.separators", "auto")
def separate():  # as a mission does, without a pause
    with computing():
        while True:
            separator.batch(heard, scene)
threading.Thread(target=separate, daemon=True).start()
cli.main()
"""


@pytest.fixture(scope="module")
def noise(tmp_path_factory):
    """The file of what a payload hears that has nobody to hear."""
    path = tmp_path_factory.mktemp("noise") / "noise.wav"
    soundfile.write(path, np.random.default_rng(0).integers(-300, 300, (SECONDS * RATE, 2), np.int16), RATE)
    return path


class Bench:
    """The far end of the pulses: reports them when they are due, and keeps them."""

    codec = PulseCodec

    def __init__(self):
        self._player = RecordingPulses()
        self._urgent = False

    def arrived(self, frame, now):
        self._player.send(frame)

    def due(self, now):
        if not self._urgent:  # on the thread of the wire: a module waits for no busy program
            self._urgent = True
            hurry()
        self._player.play(now)
        return self._player.receive()

    def turning(self, since):
        return rises(self._player.sent, since).size > 0

    def last(self):
        """When the last step that has arrived is due [s]."""
        return float(rises(self._player.sent, 0.0)[-1])

    def began(self, since):
        return deceleration_began(rises(self._player.sent, since))


def rises(segments, since):
    """When the steps of a move that began after ``since`` are due [s]."""
    times = [segment.start + edges["time"][(edges["line"] == PulseLine.STEP) & edges["level"]]
             for segment in list(segments) if (edges := segment.edges).size]  # fmt: skip
    times = np.concatenate([np.empty(0), *times])
    return times[times >= since]


def deceleration_began(steps):
    """When a move from rest to rest began to decelerate [s].

    A deceleration to rest at T has its steps at T - sqrt(2 n / a); two of them give T. An acceleration from rest at B
    has its first at B + sqrt(1 / a), because the counter moves half-way. Both rates are the same: in between lies the
    beginning, or a stretch at full speed.
    """
    gap = steps[-1] - steps[-2]
    end = steps[-1] + (2 / STEPS - gap**2) / (2 * gap)
    begin = steps[0] - math.sqrt(1 / STEPS)
    return max((begin + end) / 2, end - FASTEST / STEPS)


class Rig:
    """`ross run` in a process of its own, its ground station, and the bench."""

    def __init__(self, folder, start, ground_station, port, ahead_ms=40, *, more=""):
        self.folder, self._start, self._ground_station, self._port = folder, start, ground_station, port
        self._ahead_ms, self._more = ahead_ms, more
        self._stack = ExitStack()
        self.bench = Bench()

    def __enter__(self):
        server = self._stack.enter_context(WireServer(LOOPBACK, 0, self.bench, SystemClock()))
        config = CONFIG.format(wire=f"pulses:tcp:{LOOPBACK}:{server.port}", port=self._port, ahead_ms=self._ahead_ms)
        (self.folder / "ross.toml").write_text(config + self._more)
        self.process = self._stack.enter_context(self._start())
        self.ground = self._stack.enter_context(self._ground_station(self._port))
        wait_for(lambda: "ROSS_STATUS" in self.ground.latest)
        return self

    def __exit__(self, *reason):
        self._stack.__exit__(*reason)

    def turn(self, after):
        """Begin to turn by 90 degrees; return ``after`` [s] when the first step is out."""
        here = math.degrees(self.ground.latest["ROSS_STATUS"].heading)
        self.began = time.monotonic()
        assert self.ground.order(TURN, here + (90 if here < 0 else -90), wait=0) == 5
        wait_for(lambda: self.bench.turning(self.began))
        time.sleep(after)

    def turn_to_the_end(self):
        """Turn by 90 degrees; return the last answer."""
        here = math.degrees(self.ground.latest["ROSS_STATUS"].heading)
        return self.ground.order(TURN, here + (90 if here < 0 else -90))

    def latency(self, give):
        """How long after ``give`` the steps come later [s]; None: they ran out."""
        given = time.monotonic()
        give()
        wait_for(lambda: self.ground.latest["ROSS_STATUS"].joint_rate == 0 and self.process.poll() is None)
        wait_for(lambda: time.monotonic() > self.bench.last() + AT_REST)
        if self.ground.order(REARM) == 0:
            return self.bench.began(self.began) - given
        assert (self.ground.order(HOME), self.ground.order(REARM)) == (0, 0)
        return None


@contextmanager
def busy_loops():
    """Two processes that compute without a pause."""
    loops = [subprocess.Popen([sys.executable, "-c", BUSY]) for _ in range(2)]
    try:
        yield
    finally:
        for loop in loops:
            loop.kill()
            loop.wait()
