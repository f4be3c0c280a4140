"""From a stop to the first step that comes later: measured on the pulses themselves, whoever gives the stop.

Edges carry the time at which they are due, so that nothing here depends on when the far end looks. A move starts from
rest and accelerates at a known rate, a stop decelerates at the same: when it began follows from the steps alone.
"""

import math
import signal
import socket
import threading
import time
from contextlib import ExitStack, nullcontext

import numpy as np
import pytest
import soundfile

from ross_payload.actuators.registry import open_actuator
from ross_payload.actuators.tb6600.pulses import Line, PulseCodec, RecordingPulses
from ross_payload.clock import SystemClock
from ross_payload.config import Config
from ross_payload.errors import ActuatorFault
from ross_payload.interfaces import Services
from ross_sim.clock import SimClock
from ross_sim.devices.wires import WireServer

LOOPBACK = "127.0.0.1"
STEPS = 112.5 / 0.1125  # acceleration [1/s^2] at sixteenth steps
FASTEST = 225 / 0.1125  # [1/s]
WANTED = 0.050  # [s]
BUSY_COMPUTER = 0.150  # [s] that the test grants a computer which does much else
TURN, STOP, CANCEL, REARM, HOME = 54003, 54004, 54005, 54009, 54010
ENDS = {signal.SIGTERM: "SIGTERM", signal.SIGUSR1: "a call of the pump dies"}  # in a process that breaks on request
RATE = 16000
SECONDS = 600  # of noise that the payload hears
CONFIG = """
[audio]
source = "file:noise.wav"
[actuator]
kind = "tb6600"
options = {{ port = "{wire}" }}
[service]
state_dir = "state"
[[links]]
url = "udpin:127.0.0.1:{port}"
"""
SEPARATING = """
import threading
import numpy as np
from ross_payload import cli, plugins
from ross_payload.dsp.stft import Stft
from ross_payload.interfaces import Scene

stft = Stft(16000, 2048, 512)
heard = stft.analyse(np.random.default_rng(0).laplace(size=(2, 160000)).astype(np.float32))
scene = Scene(stft.frequencies, 0.05, 343.0, 3, np.array([1e-4, -1e-4, 0.0]), None)
separator = plugins.load("ross_payload.separators", "auto")
def separate():
    while True:
        separator.batch(heard, scene)
threading.Thread(target=separate, daemon=True).start()
cli.main()
"""
BREAKING = """
import signal
import time
from pathlib import Path
from ross_payload import cli
from ross_payload.links import Links

poll, broken = Links.poll, []
def dying(links):
    if broken:
        Path("died").write_text(str(time.monotonic()))
        raise ZeroDivisionError
    poll(links)
Links.poll = dying
signal.signal(signal.SIGUSR1, lambda number, frame: broken.append(number))
cli.main()
"""


class Bench:
    """The far end of the pulses: reports them when they are due, and keeps them."""

    codec = PulseCodec

    def __init__(self):
        self._player = RecordingPulses()

    def arrived(self, frame, now):
        self._player.send(frame)

    def due(self, now):
        self._player.play(now)
        return self._player.receive()

    def turning(self, since):
        return rises(self._player.sent, since).size > 0

    def began(self, since):
        return deceleration_began(rises(self._player.sent, since))


def rises(segments, since):
    """When the steps of a move that began after ``since`` are due [s]."""
    times = [segment.start + edges["time"][(edges["line"] == Line.STEP) & edges["level"]]
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


def test_the_beginning_of_a_deceleration_is_found_in_the_steps_of_a_whole_move():
    clock, config = SimClock(), Config.model_validate({"actuator": {"kind": "tb6600"}})
    port = RecordingPulses(clock.now)
    with open_actuator(config, Services(clock, lambda url: port)) as actuator:
        actuator.poll(clock.now())
        actuator.command(math.radians(90))
        for _ in range(200):
            clock.sleep(0.010)
            actuator.poll(clock.now())
    steps = rises(port.sent, 0.0)
    assert steps.size == 800
    assert deceleration_began(steps) == pytest.approx((steps[0] + steps[-1]) / 2, abs=1e-9)  # the move is symmetric


class Rig:
    """`ross run` in a process of its own, its ground station, and the bench."""

    def __init__(self, folder, start, ground_station, port):
        self.folder, self._start, self._ground_station, self._port = folder, start, ground_station, port
        self._stack = ExitStack()
        self.bench = Bench()

    def __enter__(self):
        server = self._stack.enter_context(WireServer(LOOPBACK, 0, self.bench, SystemClock()))
        config = CONFIG.format(wire=f"pulses:tcp:{LOOPBACK}:{server.port}", port=self._port)
        (self.folder / "ross.toml").write_text(config)
        self.process = self._stack.enter_context(self._start())
        self.ground = self._stack.enter_context(self._ground_station(self._port))
        until(lambda: "ROSS_STATUS" in self.ground.latest)
        return self

    def __exit__(self, *reason):
        self._stack.__exit__(*reason)

    def turn(self, after):
        """Begin to turn by 90 degrees; return ``after`` [s] when the first step is out."""
        here = math.degrees(self.ground.latest["ROSS_STATUS"].heading)
        self.began = time.monotonic()
        assert self.ground.order(TURN, here + (90 if here < 0 else -90), wait=0) == 5
        until(lambda: self.bench.turning(self.began))
        time.sleep(after)

    def latency(self, give):
        """How long after ``give`` the steps come later [s]; None: they ran out."""
        given = time.monotonic()
        give()
        until(lambda: self.ground.latest["ROSS_STATUS"].joint_rate == 0 and self.process.poll() is None)
        time.sleep(0.5)
        if self.ground.order(REARM) == 0:
            return self.bench.began(self.began) - given
        assert (self.ground.order(HOME), self.ground.order(REARM)) == (0, 0)
        return None


@pytest.fixture
def rig(tmp_path, process, ground_station, free_port):
    """Make a rig whose payload is started in some way."""
    noise = np.random.default_rng(0).integers(-300, 300, (SECONDS * RATE, 2), np.int16)
    soundfile.write(tmp_path / "noise.wav", noise, RATE)

    def make(before=("-m", "ross_payload.cli")):
        def start():
            return process(["run", "ross.toml"], tmp_path, "payload", before)

        return Rig(tmp_path, start, ground_station, free_port(socket.SOCK_DGRAM))

    return make


def until(found, seconds=30.0):
    """Wait until something is so."""
    end = time.monotonic() + seconds
    while not found():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.005)


@pytest.fixture
def judge(capsys):
    """Print the figures [ms] of what did not run out, and hold them against what is wanted."""

    def look(latencies, what):
        whole = np.array([latency for latency in latencies if latency is not None])
        median, high, most = np.percentile(whole, [50, 95, 100]) * 1e3
        with capsys.disabled():
            count = f"{whole.size} of {len(latencies)}"
            print(f"{what}: {count}, median {median:.1f}, p95 {high:.1f}, max {most:.1f} ms")  # noqa: T201
        assert most < WANTED * 1e3
        assert whole.size > 0.9 * len(latencies)

    return look


@pytest.mark.parametrize("command", [STOP, CANCEL])
def test_a_command_decelerates_soon(rig, command):
    with rig() as payload:
        payload.turn(0.3)
        latency = payload.latency(lambda: payload.ground.command(command))
    assert latency is None or latency < BUSY_COMPUTER


@pytest.mark.parametrize("number", ENDS, ids=ENDS.get)
def test_an_end_of_the_process_decelerates_soon(rig, number):
    assert ended(rig, number, 0.3) < BUSY_COMPUTER


def ended(rig, number, after):
    """The latency of a signal in the middle of a move, or of the death that it brings [s]."""
    died = pytest.raises(AssertionError, match="periodic call failed") if number == signal.SIGUSR1 else nullcontext()
    with died, rig(("-c", BREAKING)) as payload:
        payload.turn(after)
        given = time.monotonic()
        payload.process.send_signal(number)
        payload.process.wait(30)
    told = payload.folder / "died"
    return payload.bench.began(payload.began) - (float(told.read_text()) if told.exists() else given)


def test_another_thread_decelerates_soon():
    assert all(latency < BUSY_COMPUTER for latency in stopped_by_a_thread([0.2, 0.6]) if latency is not None)


def stopped_by_a_thread(moments):
    """Latencies of `Guard.stop` in the middle of moves, in this process."""
    clock, port, config = SystemClock(), RecordingPulses(time.monotonic), Config.model_validate(
        {"actuator": {"kind": "tb6600"}})  # fmt: skip
    latencies = []
    with open_actuator(config, Services(clock, lambda url: port)) as actuator, ExitStack() as stack:
        stack.callback(clock.every(0.010, lambda: actuator.poll(clock.now())))
        until(lambda: actuator.state().healthy)
        for after in moments:
            began = clock.now()
            actuator.command(-math.copysign(math.radians(180), actuator.state().angle))
            time.sleep(after)
            given = []
            thread = threading.Thread(target=lambda given=given: (given.append(clock.now()), actuator.stop()))
            thread.start()
            thread.join()
            until(lambda: actuator.state().rate == 0)
            time.sleep(0.2)
            latencies.append(deceleration_began(rises(port.sent, began)) - given[0])
            try:
                actuator.rearm()
            except ActuatorFault:  # the steps ran out
                latencies[-1] = None
                actuator.home()
                time.sleep(0.5)
                actuator.rearm()
    return latencies


@pytest.mark.soak
@pytest.mark.parametrize("before", [("-m", "ross_payload.cli"), ("-c", SEPARATING)], ids=["idle", "separating"])
@pytest.mark.parametrize("command", [STOP, CANCEL])
def test_fifty_commands_decelerate_within_50_ms(rig, command, before, judge):
    latencies = []
    with rig(before) as payload:
        for after in np.random.default_rng(1).uniform(0.1, 0.7, 50):
            payload.turn(after)
            latencies.append(payload.latency(lambda: payload.ground.command(command)))
    judge(latencies, f"command {command}, {'separating' if before[0] == '-c' else 'idle'}")


@pytest.mark.soak
@pytest.mark.parametrize("number", ENDS, ids=ENDS.get)
def test_thirty_ends_of_a_process_decelerate_within_50_ms(rig, judge, number):
    judge([ended(rig, number, after) for after in np.random.default_rng(2).uniform(0.1, 0.7, 30)], ENDS[number])


@pytest.mark.soak
def test_fifty_stops_by_another_thread_decelerate_within_50_ms(judge):
    judge(stopped_by_a_thread(np.random.default_rng(3).uniform(0.1, 1.1, 50)), "guard.stop()")
