"""A simulated device in a process of its own, and a guarded driver that turns it, in real time."""

from __future__ import annotations

import json
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from ports import free_port
from processes import ROSS, program
from ross_payload.actuators.guard import Guard
from ross_payload.actuators.mavlink_gimbal.component_port import opener
from ross_payload.actuators.registry import open_actuator
from ross_payload.clock import SystemClock
from ross_payload.config import Config
from ross_payload.interfaces import Services
from ross_payload.mavlink import Router

PERIOD = 0.010  # of the pump [s]
SERIAL_OVER_TCP = "serial:tcp:127.0.0.1:0"
"""A serial line for what is held to times: bytes of a pseudo terminal wait for a thread of the kernel, which some
kernels (6.18, with autogroups) let wait for seconds while programs of many sessions compute."""


class Process:
    """A ``ross`` command that tells where it is and obeys lines."""

    def __init__(self, running: subprocess.Popen[str], log: Path) -> None:
        self.running = running
        self.log = log
        self.told: dict[str, Any] = json.loads(running.stdout.readline() if running.stdout else "")

    def ask(self, line: str) -> dict[str, Any]:
        """Say a line and return the answer."""
        assert self.running.stdin and self.running.stdout
        self.running.stdin.write(line + "\n")
        self.running.stdin.flush()
        answer: dict[str, Any] = json.loads(self.running.stdout.readline())
        return answer


@contextmanager
def ross(folder: Path, *command: str, before: tuple[str, ...] = ROSS) -> Iterator[Process]:
    """Start a command that ends by SIGTERM, in good order and without a word but of a busy computer."""
    name = f"{command[0]}-{len(list(folder.iterdir()))}.log"
    pipes: dict[str, Any] = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with program([*before, *command], folder, name, code=None, lives=False, **pipes) as (running, log):
        yield Process(running, log)
    words = [line for line in log.read_text().splitlines() if "this computer does not keep up" not in line]
    assert (running.returncode, words) == (0, []), words


@contextmanager
def device(folder: Path, kind: str, *more: str) -> Iterator[Process]:
    """Start ``ross device``; a gimbal, a vehicle or grbl at a free port, unless it is told where."""
    free = kind in ("gimbal", "vehicle") and "--wire" not in more and "--config" not in more
    wire = ("--wire", f"udpout:127.0.0.1:{free_port()}") if free else ()
    if kind == "grbl" and "--wire" not in more:
        wire = ("--wire", SERIAL_OVER_TCP)
    with ross(folder, "device", kind, "--json", *wire, *more) as process:
        yield process


class Driver:
    """A guarded driver on the system's clock, polled by its pump."""

    def __init__(self, actuator: Guard, clock: SystemClock, poll: Callable[[], None]) -> None:
        self.actuator = actuator
        self.clock = clock
        self.poll = poll

    def until(self, true: Callable[[], bool], seconds: float = 20.0) -> None:
        """Wait for something to be true."""
        end = time.monotonic() + seconds
        while not true():
            assert time.monotonic() < end, self.actuator.state()
            time.sleep(0.005)

    def ready(self) -> None:
        """Wait until it may be moved; home it when it has to be."""
        self.until(lambda: self.actuator.state().healthy)
        if not self.actuator.state().homed:
            self.actuator.home()
        self.until(lambda: self.actuator.state().homed and self.actuator.state().settled, 30.0)

    def turn(self, goal: float) -> None:
        """Go somewhere [rad] and wait until it is there, which no fault may prevent."""
        self.actuator.command(goal)
        self.until(self._arrived)

    def _arrived(self) -> bool:
        state = self.actuator.state()
        assert not state.fault, state.fault
        return state.settled


@contextmanager
def driver(told: dict[str, Any], pump: bool = True, watchdog_s: float = 0.5, **options: Any) -> Iterator[Driver]:
    """Open the driver that fits what a device has told; feedback older than ``watchdog_s`` is a fault."""
    on_links = told["kind"] in ("mavlink_gimbal", "vehicle_yaw")
    links = [{"url": told["wire"], "role": "autopilot"}] if on_links else []
    port = {} if links else {"port": told["wire"]}
    actuator = {"kind": told["kind"], "options": port | options}
    config = Config.model_validate({"actuator": actuator, "links": links, "guard": {"watchdog_s": watchdog_s}})
    clock = SystemClock()
    with ExitStack() as stack:
        hub = stack.enter_context(Router.open(config.links, clock))
        guard = open_actuator(config, Services(clock, opener(hub, 191, clock)))
        stack.enter_context(guard)

        def poll() -> None:
            hub.poll()
            guard.poll(clock.now())

        if pump:
            stack.callback(clock.every(PERIOD, poll))
        yield Driver(guard, clock, poll)
