"""A payload in a process of its own, and what stands between it and its clients."""

import json
import os
import random
import re
import shutil
import socket
import threading
import time
import tomllib
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
import pytest
import soundfile
from pymavlink import mavutil
from pymavlink.dialects.v20 import ardupilotmega

import ports
from loudspeaker import Loudspeaker
from processes import ROSS, program
from waiting import wait_for

PULSE_PLUGIN = "alsa-lib/libasound_module_pcm_pulse.so"
LOOPBACK = "127.0.0.1"
RATE = 16000
ANSWERED_S = 1.0  # in which a command that was sent again is answered
ROOM = 4 << 20  # [bytes]: what arrives while a test does something else is read later
CONFIG = """
audio.source = "{source}"
actuator = {{ kind = "tb6600", options = {{ ahead_ms = 500 }} }}
service = {{ state_dir = "state", log_format = "json" }}
"""


@pytest.fixture(scope="session")
def free_port():
    """Tell a port that nobody listens on."""
    return ports.free_port


class Payload:
    """``ross run`` or ``ross sitl --serve``: what it logs and keeps."""

    def __init__(self, process, folder, log):
        self.process, self.folder, self._log = process, folder, log

    def log(self):
        return [json.loads(line) for line in self._log.read_text().splitlines() if line.startswith("{")]

    def lines(self):
        return [line["message"] for line in self.log()]

    def answers(self, answer):
        """The numbers of the orders from links that the mission answered so."""
        said = [line["fields"] for line in self.log()]
        return [one["order"] for one in said if one.get("answer") == answer and one["order"]]

    def kept(self):
        """What was set in flight and outlives a restart, by name."""
        path = self.folder / "state" / "params.toml"
        told = tomllib.loads(path.read_text())["parameters"] if path.exists() else {}
        return {name: one["value"] for name, one in told.items()}


@contextmanager
def process_of(command, folder, code=0):
    """A process that is told to go in the end, and must go in good order with this exit code."""
    with program([*ROSS, *command], folder, code=code) as (process, log):
        yield Payload(process, folder, log)


@pytest.fixture(scope="session")
def living():
    """Run a ``ross`` command that lives until it is told to go."""
    return process_of


@pytest.fixture(scope="session")
def noise(tmp_path_factory):
    """Five minutes of two microphones in an empty room, ten seconds again and again."""
    path = tmp_path_factory.mktemp("noise") / "noise.wav"
    samples = np.random.default_rng(0).normal(0, 0.01, (RATE * 10, 2))
    with soundfile.SoundFile(path, "w", RATE, 2, "PCM_24") as file:
        for _ in range(30):
            file.write(samples)
    return path


@pytest.fixture(scope="session")
def ross_run(noise):
    """Start ``ross run`` with these links; gives the payload when it is idle."""

    @contextmanager
    def start(folder, *links, more="", source=f"file:{noise}"):
        folder.mkdir(parents=True, exist_ok=True)
        told = "".join(f"[[links]]\n{link}\n" for link in links)
        (folder / "ross.toml").write_text(CONFIG.format(source=source) + more + told)
        with process_of(["run", "ross.toml"], folder) as payload:
            wait_for(lambda: payload.process.poll() is not None or {"idle", "stopped"} & set(payload.lines()))
            yield payload

    return start


class Ground:
    """pymavlink's mavutil as a ground station that knows what ArduPilot's dialect knows."""

    def __init__(self, system_id=255):
        self.link = mavutil.mavudp(f"{LOOPBACK}:0", input=True, source_system=system_id, source_component=190)
        self.link.port.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, ROOM)
        self.port = self.link.port.getsockname()[1]
        self.heard = []
        self._beat = 0.0
        self._repeated = {}  # when a command was sent again last, by its number [s]

    def listen(self):
        """Take in what has arrived; say once a second that we are here."""
        if time.monotonic() > self._beat + 1.0:
            self._beat = time.monotonic()
            self.link.mav.send(ardupilotmega.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3))
        while (message := self.link.recv_match()) is not None:
            message.arrived = time.monotonic()
            self.heard.append(message)

    def of(self, name, sender=191):
        """What has been heard of a message from a component."""
        self.listen()
        return [one for one in self.heard if one.get_type() == name and one.get_srcComponent() == sender]

    def wait(self, name, fits=lambda message: True, seconds=60.0, since=0):
        return wait_for(lambda: [one for one in self.of(name)[since:] if fits(one)], seconds, name)[0]

    def command(self, number, *values, system=1, confirmation=0):
        numbers = [*values, *[0.0] * (7 - len(values))]
        self.link.mav.send(
            ardupilotmega.MAVLink_command_long_message(system, 191, number, confirmation, *map(float, numbers))
        )

    def order(self, number, *values, system=1, seconds=60.0, last=False):
        """Command; return the first answer that is not that of an earlier command, or the ``last`` one."""
        before, going = len(self.of("COMMAND_ACK")), ardupilotmega.MAV_RESULT_IN_PROGRESS
        self.command(number, *values, system=system)
        return self.wait(
            "COMMAND_ACK", lambda ack: ack.command == number and not (last and ack.result == going), seconds, before
        ).result

    def obeyed(self, number, *values, seconds=60.0):
        """Command, and again as clients do, until it is known what finally becomes of it.

        What was said again last time is answered again, too: that answer must not pass for one to this command.
        """
        self.rest(self._repeated.get(number, 0.0) + ANSWERED_S - time.monotonic())
        before, end = len(self.of("COMMAND_ACK")), time.monotonic() + seconds
        for confirmation in range(256):
            self.command(number, *values, confirmation=confirmation)
            if confirmation:
                self._repeated[number] = time.monotonic()
            again = time.monotonic() + 0.4
            while time.monotonic() < again:
                acks = [ack.result for ack in self.of("COMMAND_ACK")[before:] if ack.command == number]
                if over := [result for result in acks if result != ardupilotmega.MAV_RESULT_IN_PROGRESS]:
                    return over[0]
                time.sleep(0.01)
            assert time.monotonic() < end, f"no answer to {number}"

    def set(self, name, value):
        """Set a parameter, and again until the payload says that it is so."""
        kind = ardupilotmega.MAV_PARAM_TYPE_REAL32
        for _ in range(50):
            self.link.mav.send(ardupilotmega.MAVLink_param_set_message(1, 191, name.encode(), value, kind))
            self.rest(0.3)
            if [one.param_value for one in self.of("PARAM_VALUE") if one.param_id == name][-1:] == [value]:
                return
        raise AssertionError(f"{name} was never set")

    def rest(self, seconds):
        """Only listen."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.listen()
            time.sleep(0.01)

    def texts(self):
        return [one.text for one in self.of("STATUSTEXT")]


@pytest.fixture(scope="module")
def ground_stations():
    """Make ground stations; they are closed in the end."""
    with pytest.MonkeyPatch.context() as patch, ExitStack() as stack:
        patch.setattr(mavutil, "mavlink", ardupilotmega)
        patch.setenv("MAVLINK20", "1")

        def make(**options):
            ground = Ground(**options)
            stack.callback(ground.link.close)
            return ground

        yield make


class Weather:
    """A UDP path with loss, doubles, disorder and damage both ways; it keeps what went up to the payload.

    The payload sends to ``port`` first; whoever else sends there is a client. ``client`` is where what it says goes.
    """

    def __init__(self, client, *, loss=0.0, double=0.0, late=0.0, damage=0.0, seed=0):
        self._rates = {"lost": loss, "doubled": double, "late": late, "damaged": damage}
        self._dice = random.Random(seed)  # noqa: S311
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind((LOOPBACK, 0))
        self._socket.settimeout(0.05)
        self.port = self._socket.getsockname()[1]
        self._client = (LOOPBACK, client)
        self._payload = None
        self._held = []
        self.captured = []
        self.fates = dict.fromkeys(self._rates, 0)
        self._open = True
        self._thread = threading.Thread(target=self._blow)
        self._thread.start()

    def close(self):
        self._open = False
        self._thread.join()
        self._socket.close()

    def up(self, datagram):
        """Send something to the payload, whatever the weather."""
        self._socket.sendto(datagram, self._payload)

    def _blow(self):
        while self._open:
            try:
                datagram, source = self._socket.recvfrom(2048)
            except (TimeoutError, ConnectionRefusedError):
                self._release()
                continue
            if source == self._client:
                self.captured.append(datagram)
                self._fly(datagram, self._payload)
            else:
                self._payload = source
                self._fly(datagram, self._client)

    def _fly(self, datagram, where):
        fates = [fate for fate, rate in self._rates.items() if self._dice.random() < rate]
        for fate in fates:
            self.fates[fate] += 1
        if where is None or "lost" in fates:
            return
        if "damaged" in fates:
            datagram = bytearray(datagram)
            datagram[self._dice.randrange(len(datagram))] ^= self._dice.randrange(1, 256)
        if "late" in fates:
            self._held.append((bytes(datagram), where))
            return
        for _ in range(1 + ("doubled" in fates)):
            self._socket.sendto(datagram, where)
        self._release(keep=self._dice.randrange(3))

    def _release(self, keep=0):
        while len(self._held) > keep:
            self._socket.sendto(*self._held.pop(self._dice.randrange(len(self._held))))


@pytest.fixture(scope="module")
def weather():
    """Make paths of bad weather; they are closed in the end."""
    with ExitStack() as stack:

        def make(client, **rates):
            path = Weather(client, **rates)
            stack.callback(path.close)
            return path

        yield make


@pytest.fixture(scope="session")
def guide(request):
    """The program of the guide that has this word in it."""
    page = request.config.rootpath / "docs" / "how-to" / "interoperate.md"
    programs = re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    return lambda word: next(program for program in programs if word in program)


@pytest.fixture
def loudspeaker(tmp_path):
    if shutil.which("pulseaudio") is None:
        pytest.skip("needs the package pulseaudio")
    if not any(Path("/usr/lib").glob(f"*/{PULSE_PLUGIN}")):
        pytest.skip("needs the package libasound2-plugins")
    folder = Path(os.path.realpath(tmp_path)) / "p"  # a socket's path is short
    folder.mkdir(mode=0o700)
    with Loudspeaker(folder) as server:
        yield server
