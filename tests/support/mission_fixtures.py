"""Fixtures of simulated missions."""

import json
import socket
import sys
import threading
import time
from contextlib import contextmanager
from functools import partial
from types import SimpleNamespace

import pytest

import ports
from command_line import called
from processes import PYTHON, ROSS, program
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.dialect import common, ross
from short_mission import SHORT

LOOPBACK = "127.0.0.1"
IN_PROGRESS = 5  # MAV_RESULT


@contextmanager
def without_picture():
    """Draw no picture of a mission in this process, where nobody looks at it: `mission.png` stays empty."""
    with pytest.MonkeyPatch.context() as patch:
        nothing = SimpleNamespace(draw=lambda path, *_, **__: path.touch())  # nor is matplotlib imported
        patch.setitem(sys.modules, "ross_sim.sitl.mission_figure", nothing)
        yield


@contextmanager
def without_figures():
    """Draw no figures of a study in this process, where nobody looks at them: they take longer than a small study."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("ross_sim.study.runs.study_run.draw", lambda *_: [])
        yield


@pytest.fixture(scope="module")
def undrawn():
    """No mission of this module is drawn."""
    with without_picture():
        yield


@pytest.fixture
def short(tmp_path):
    path = tmp_path / "short.toml"
    path.write_text(SHORT)
    return path


@pytest.fixture
def run(monkeypatch, capsys):
    return partial(called, monkeypatch, capsys)


@pytest.fixture
def fly(run):
    """Run a simulated mission that succeeds; its report."""

    def call(*arguments):
        code, out, err = run("sitl", "--json", *arguments)
        assert code == 0, err
        return json.loads(out)

    return call


@pytest.fixture
def free_port():
    """Tell a port that nobody listens on."""
    return ports.free_port


@pytest.fixture
def process():
    """Run ``ross`` with its errors in a file; it ends by SIGTERM, with code 0."""

    @contextmanager
    def start(arguments, folder, name, before=ROSS[1:], **pipes):
        command = [*PYTHON, *before, *arguments]
        with program(command, folder, f"{name}.log", lives=False, **{"stdout": None} | pipes) as (running, _):
            yield running

    return start


@pytest.fixture
def ground_station():
    """Make a ground station that speaks to a UDP port."""
    return Ground


class Ground:
    """A ground station on UDP: gives commands, waits for their end, keeps the latest of every message."""

    def __init__(self, port):
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.connect((LOOPBACK, port))
        self._socket.settimeout(0.2)
        self._encoder, self._decoder = Encoder(255, 190), Decoder()
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._listen, name="ground")
        self._heard = threading.Condition()
        self._answers = []
        self.latest, self.beats, self.silence = {}, 0, 0.0
        self.streams = {}  # the latest ROSS_STREAM of each

    def _listen(self):
        beat, next_beat = None, 0.0
        while not self._over.is_set():
            if time.monotonic() > next_beat:
                self.send(common.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3))
                next_beat = time.monotonic() + 1
            try:
                packets = self._decoder.feed(self._socket.recv(2048))
            except OSError:
                continue
            for packet in packets:
                self.latest[packet.name] = packet.message
                if packet.name == "ROSS_STREAM":
                    self.streams[packet.message.number] = packet.message
                if packet.name == "HEARTBEAT":
                    now = time.monotonic()
                    self.beats, self.silence = self.beats + 1, max(self.silence, now - (beat or now))
                    beat = now
                if packet.name == "COMMAND_ACK":
                    with self._heard:
                        self._answers.append(packet.message)
                        self._heard.notify_all()

    def send(self, message):
        try:
            self._socket.send(self._encoder.encode(message))
        except OSError:
            return  # nobody is there yet

    def command(self, number, *numbers):
        """Send a command, once."""
        self.send(ross.MAVLink_command_long_message(1, 191, number, 0, *numbers, *[0] * (7 - len(numbers))))

    def order(self, number, *numbers, wait=60.0):
        """Give a command; return its last answer, or the first with ``wait`` = 0."""
        with self._heard:
            self._answers.clear()
            self.command(number, *numbers)
            end = time.monotonic() + max(wait, 5.0)
            while time.monotonic() < end:
                own = [answer.result for answer in self._answers if answer.command == number]
                if own and (wait == 0 or own[-1] != IN_PROGRESS):
                    return own[-1]
                self._heard.wait(0.2)
        return None

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *reason):
        self._over.set()
        self._thread.join(10)
        self._socket.close()
