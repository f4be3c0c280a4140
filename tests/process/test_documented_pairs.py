"""Payload and ground station meet when both are started as README and guides print it, in either order."""

import asyncio
import json
import re
import shlex
import signal
import subprocess
import time
from contextlib import ExitStack, contextmanager

import pytest

import ports
from ground_page import browser
from manual import block, command
from mavproxy_prompt import mavproxy, need_mavproxy
from processes import ROSS, program
from ross_payload.ground.terminal.command import DEFAULT_URL as OF_MONITOR
from ross_payload.ground.web.command import DEFAULT_URL as OF_GROUND
from ross_sim.sitl.serve import GROUND_STATION
from waiting import wait_for

README, LIVE, WATCH = "README.md", "docs/how-to/simulate-live.md", "docs/how-to/watch-from-the-ground.md"
MONITOR, DRONE, TELEMETRY = (
    "docs/how-to/terminal-monitor.md",
    "docs/how-to/on-a-drone.md",
    "docs/how-to/read-telemetry.md",
)
GIMBAL = "docs/how-to/turntable-as-gimbal.md"
MEET_S = 10.0  # from the start of the later program until the payload is shown
BUSY_TIMEOUT_S = 60.0  # the same on a computer that is busy with other tests
PORTS = ("14550", "14540", "40001", "40002", "8765")  # printed, or the default


class Printed:
    """Commands as printed, with free ports in place of the printed and default ones."""

    def __init__(self, folder):
        self.folder = folder
        self._ports = {port: str(ports.free_port()) for port in PORTS}

    def free(self, text):
        return re.sub("|".join(PORTS), lambda found: self._ports[found[0]], text)

    def words(self, line, default=()):
        """The arguments for `ross`; a program that is printed without its default URL is told the free one."""
        words = shlex.split(line)[1:]
        words += () if "14550" in line else default
        return [self.free(word) for word in words]


def test_the_defaults_of_payload_and_ground_are_two_ends_of_one_port():
    assert OF_GROUND == OF_MONITOR == "udpin:127.0.0.1:14550"
    assert OF_GROUND.replace("udpin", "udpout") == GROUND_STATION


# ------------------------------------------------------------------------------------------------ programs


@contextmanager
def running(arguments, folder, name):
    """A program that is ended by Ctrl-C; its output is in a file."""
    with program([*ROSS, *arguments], folder, f"{name}.log", end=signal.SIGINT, code=None) as (_, log):
        yield log


@contextmanager
def served(printed, line):
    with running(printed.words(line, ["--telemetry", GROUND_STATION]), printed.folder, "payload"):
        yield


@contextmanager
def in_a_room(printed, step=1):
    """The simulated room in one terminal, the payload in another, as `simulate live` has it; -1: the payload first."""
    text = block(LIVE, "toml", "# ross.toml").text + '\nstate_dir = "state"\n'
    (printed.folder / "ross.toml").write_text(printed.free(text))
    world = printed.words(command(LIVE, "ross world demo --pcm"))
    payload = printed.words(command(LIVE, "ross run"))
    enrol(printed)
    order = [("room", world), ("payload", payload)]
    with ExitStack() as stack:
        for name, arguments in order[::step]:
            stack.enter_context(running(arguments, printed.folder, name))
        yield


def enrol(printed):
    """The room writes clean speech of the target, which is enrolled."""
    line = command(LIVE, "ross world demo --pcm")
    with running(printed.words(line), printed.folder, "first"):
        wait_for((printed.folder / "clean.wav").exists)
    done = subprocess.run([*ROSS, *printed.words(command(LIVE, "ross enroll"))], cwd=printed.folder, check=False)
    assert done.returncode == 0


@contextmanager
def as_a_gimbal(printed):
    (printed.folder / "gimbal.toml").write_text(block(GIMBAL, "toml", "talkers").text)
    with served(printed, command(GIMBAL, "ross sitl")):
        yield


@contextmanager
def behind_an_autopilot(printed):
    """`on a drone`: the autopilot as a process between a payload and the ground."""
    (printed.folder / "drone.toml").write_text(printed.free(DRONE_SCENARIO))
    line = command(DRONE, "ross autopilot")
    with ExitStack() as stack:
        stack.enter_context(running(printed.words(line), printed.folder, "autopilot"))
        stack.enter_context(running(["sitl", "--serve", "--scenario", "drone.toml"], printed.folder, "payload"))
        yield


DRONE_SCENARIO = """
title = "a payload under a vehicle"
[payload.telemetry]
system_id = 0
[[payload.links]]
url = "udpout:127.0.0.1:14540"
role = "autopilot"
[[talkers]]
azimuth_deg = 40.0
"""

PAYLOADS = {
    "README": lambda printed: served(printed, command(README, "ross sitl --serve")),
    "simulate-live": lambda printed: served(printed, command(LIVE, "ross sitl --serve")),
    "read-telemetry": lambda printed: served(printed, command(TELEMETRY, "ross sitl")),
    "gimbal": as_a_gimbal,
    "room": in_a_room,
    "room-later": lambda printed: in_a_room(printed, step=-1),
    "drone": behind_an_autopilot,
}


# -------------------------------------------------------------------------------------------------- ground


class Page:
    """`ross ground`, seen by a browser."""

    def __init__(self, printed, line):
        self._url = printed.free("http://127.0.0.1:8765/")
        self._arguments = [*printed.words(line, [OF_GROUND]), "--port", printed.free("8765")]
        self._folder = printed.folder

    def started(self):
        return running(self._arguments, self._folder, "ground")

    def shows(self):
        try:
            return asyncio.run(asyncio.wait_for(self._look(), 1.0))
        except (OSError, TimeoutError):
            return False

    async def _look(self):
        async with browser(self._url) as page:
            while "1-191" not in json.dumps(await page.next("fleet")):
                pass
            return True


class Monitor:
    """`ross monitor` on a pipe, which prints a line for every change."""

    def __init__(self, printed, line):
        self._arguments = printed.words(line, [OF_MONITOR])
        self._log = printed.folder / "monitor.log"

    def started(self):
        return running(self._arguments, self._log.parent, "monitor")

    def shows(self):
        return "1-191" in self._log.read_text()


class Proxy:
    """`ross mavproxy`, asked for the state of the payload."""

    def __init__(self, printed, line):
        need_mavproxy()
        self._command = [*ROSS[1:], *printed.words(line)]
        self._folder, self._prompt = printed.folder, None

    @contextmanager
    def started(self):
        with mavproxy(self._command, self._folder) as self._prompt:
            yield

    def shows(self):
        self._prompt.type("ross status")
        time.sleep(0.2)  # between two questions, not for an answer
        return re.search(r"RoSS \d+-191  \w+", self._prompt.said())


GROUNDS = {
    "ground": lambda printed: Page(printed, command(WATCH, "ross ground")),
    "ground-all": lambda printed: Page(printed, command(WATCH, "ross ground udpin:0.0.0.0")),
    "monitor": lambda printed: Monitor(
        printed, command(MONITOR, "ross monitor udpin:127.0.0.1:14550 >>").split(">>")[0]
    ),
    "mavproxy": lambda printed: Proxy(printed, command("docs/how-to/mavproxy.md", "ross mavproxy")),
}


def meet(folder, payload, ground, *, payload_first, seconds):
    """Start both as printed; return how long the payload takes to be shown [s]."""
    printed = Printed(folder)
    station = GROUNDS[ground](printed)
    order = [PAYLOADS[payload](printed), station.started()]
    with ExitStack() as stack:
        for program in order if payload_first else order[::-1]:
            stack.enter_context(program)
        began = time.monotonic()
        wait_for(station.shows, seconds)
        return time.monotonic() - began


FULL = [(payload, ground) for payload in PAYLOADS for ground in GROUNDS]
SHORT = [("README", "ground", False)]  # the other order and the other programs: below


@pytest.mark.parametrize(("payload", "ground", "payload_first"), SHORT)
def test_a_documented_pair_meets_whoever_is_started_first(payload, ground, payload_first, tmp_path):
    meet(tmp_path, payload, ground, payload_first=payload_first, seconds=BUSY_TIMEOUT_S)


@pytest.mark.soak
@pytest.mark.parametrize("payload_first", [True, False])
@pytest.mark.parametrize(("payload", "ground"), FULL)
def test_every_documented_pair_meets_within_ten_seconds(payload, ground, payload_first, tmp_path):
    assert meet(tmp_path, payload, ground, payload_first=payload_first, seconds=BUSY_TIMEOUT_S) <= MEET_S
