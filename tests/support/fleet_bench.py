"""Emulated payloads: full telemetry over real UDP, and whoever asks is answered.

Commands, parameters and metadata are answered by the payload's own servers; what is told is made up.
As a program: ``python fleet_bench.py udpout:127.0.0.1:14550 --payloads 5 --hz 10``. For a test `FleetBench` starts it,
and tells it what goes wrong; `FleetThread` does the same in the process of the test, where nobody counts its processor
time or memory.
"""

import argparse
import json
import math
import os
import subprocess
import sys
import threading
import time
from contextlib import suppress
from dataclasses import replace
from itertools import count
from queue import Empty, SimpleQueue

from emulated_commands import EmulatedCommands
from emulated_scene import full
from ross_payload.clock import SystemClock
from ross_payload.config import Config, Link
from ross_payload.config.parameter_store import Parameters
from ross_payload.mavlink import Router
from ross_payload.mavlink.component_info import files
from ross_payload.mavlink.ftp_server import FtpServer
from ross_payload.mavlink.param_server import ParamServer
from ross_protocols.mavlink.codec import chunks
from ross_protocols.mavlink.params import ListRequest, SetRequest, request_of, value_message
from ross_protocols.mavlink.values import Health, Heartbeat, Source, Status
from waiting import LIMIT_S

COMPONENT = 191
POLL = 0.010  # [s]
BOOTING = 0.3  # [s] that a start takes
OTHER = {"OTHER_ONE": 1.0, "OTHER_TWO": 2.5}  # parameters of another version


class OtherParameters:
    """The parameters of a payload of another version."""

    def __init__(self, component):
        self._component = component
        self._values = dict(OTHER)
        component.subscribe(self.on_packet)

    def on_packet(self, received):
        request = request_of(received.packet.message)
        if isinstance(request, SetRequest) and request.name in self._values:
            self._values[request.name] = request.value
        if isinstance(request, (ListRequest, SetRequest)) and request.target.includes(self._component.id):
            for index, (name, value) in enumerate(self._values.items()):
                self._component.send(value_message(name, value, index, len(self._values)))

    def tick(self, now):
        pass


class Emulated:
    """One payload, from its start to the next one."""

    def __init__(self, system, url, *, born, sources=3, other=False):
        self.system, self.url, self.sources, self.born = system, url, sources, born
        self.nan = False
        self._links = Router.open([Link(url=url)], SystemClock(), system_id=system, patient=True)
        self._component = self._links.component(COMPONENT)
        self._numbers = count(1)
        self._parameters = Parameters(Config())
        settings = (
            OtherParameters(self._component)
            if other
            else ParamServer(self._component, self._parameters, lambda name, value: None, self.say)
        )
        self.commands = EmulatedCommands(self._links, self._component, self.say)
        self._servers = [settings, self.commands, FtpServer(self._component, files())]

    def say(self, severity, text):
        for part in chunks(severity, text, next(self._numbers)):
            self._component.send(part)

    def poll(self, now):
        self._links.poll()
        for server in self._servers:
            server.tick(now - self.born)

    def speak(self, now):
        """Tell everything."""
        age = now - self.born
        if age < BOOTING:
            self._component.send(Heartbeat(Health.BOOT, 0))
            return
        for said in full(age, self.sources, self.system):
            self._component.send(self._changed(said))

    def _changed(self, said):
        """Tell what goes wrong."""
        if self.nan and isinstance(said, Source):
            return replace(said, azimuth=math.nan)
        if self.commands.state is not None and isinstance(said, (Status, Heartbeat)):
            return replace(said, state=self.commands.state)
        return said

    def close(self):
        self._parameters.close()
        self._links.close()


class Payloads:
    """All of them, and what they are told by lines of JSON: ``{"silent": [1]}``."""

    def __init__(self, url, number, sources, born):
        self.all = {system: Emulated(system, url, born=born, sources=sources) for system in range(1, number + 1)}
        self.twins = []
        self.silent = set()

    def obey(self, what, now):
        for name, systems in what.items():
            for system in systems:
                getattr(self, f"_{name}")(system, now)

    def everybody(self):
        return [one for one in [*self.all.values(), *self.twins] if one.system not in self.silent]

    def close(self):
        for one in [*self.all.values(), *self.twins]:
            one.close()

    def _silence(self, system, now):
        self.silent.add(system)

    def _speak(self, system, now):
        self.silent.discard(system)

    def _nan(self, system, now):
        self.all[system].nan = True

    def _crowd(self, system, now):
        self.all[system].sources = 200

    def _restart(self, system, now):
        self._start(system, now, other=False)

    def _change(self, system, now):
        self._start(system, now, other=True)

    def _twin(self, system, now):
        self.twins.append(Emulated(system, self.all[system].url, born=now - 5000.0))

    def _start(self, system, now, *, other):
        old = self.all[system]
        old.close()
        self.all[system] = Emulated(system, old.url, born=now, sources=old.sources, other=other)


def listen(told):
    """Queue what every line of the input tells; its end is queued as None."""
    while line := sys.stdin.readline():
        told.put((json.loads(line), lambda: print("done", flush=True)))  # noqa: T201 - the test waits for it
    told.put(None)


def run(url, number, hz, sources, told):
    """Speak until None is told; else it is a pair: what goes wrong, and what to call when it does."""
    payloads = Payloads(url, number, sources, time.monotonic() - 20.0)
    due = time.monotonic()
    while True:
        now = time.monotonic()
        with suppress(Empty):
            what = told.get_nowait()
            if what is None:
                break
            payloads.obey(what[0], now)
            what[1]()
        for one in payloads.everybody():
            one.poll(now)
            if now >= due:
                one.speak(now)
        due = max(due + 1 / hz, now) if now >= due else due
        time.sleep(POLL)
    payloads.close()


class FleetBench:
    """The program, for a test: a context manager. ``tell(silence=[1], speak=[2], nan=[1], crowd=[3], twin=[1])``,
    ``tell(restart=[1])``, ``tell(change=[1])`` (a start with other parameters)."""

    def __init__(self, port, payloads=1, hz=5.0, sources=3):
        options = ["--payloads", str(payloads), "--hz", str(hz), "--sources", str(sources)]
        self._command = [sys.executable, __file__, f"udpout:127.0.0.1:{port}", *options]

    def __enter__(self):
        environment = {**os.environ, "OMP_NUM_THREADS": "1"}
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(self._command, stdin=pipe, stdout=pipe, text=True, env=environment)
        return self

    def tell(self, **what):
        """Let something go wrong, or right again; returns when it does."""
        self.process.stdin.write(json.dumps(what) + "\n")
        self.process.stdin.flush()
        assert self.process.stdout.readline() == "done\n", "the emulated payloads have died"

    def __exit__(self, *error):
        self.process.stdin.close()
        self.process.stdout.close()
        self.process.wait(20)


class FleetThread:
    """What `FleetBench` does, on a thread: a context manager with the same ``tell``."""

    def __init__(self, port, payloads=1, hz=2.0, sources=3):
        self._told = SimpleQueue()
        self._thread = threading.Thread(
            target=run, args=(f"udpout:127.0.0.1:{port}", payloads, hz, sources, self._told), name="payloads"
        )

    def __enter__(self):
        self._thread.start()
        return self

    def tell(self, **what):
        """Let something go wrong, or right again; returns when it does."""
        done = threading.Event()
        self._told.put((what, done.set))
        assert done.wait(LIMIT_S), "the emulated payloads have died"

    def __exit__(self, *error):
        self._told.put(None)
        self._thread.join(LIMIT_S)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("url")
    parser.add_argument("--payloads", type=int, default=1)
    parser.add_argument("--hz", type=float, default=5.0)
    parser.add_argument("--sources", type=int, default=3)
    given = parser.parse_args()
    lines = SimpleQueue()
    threading.Thread(target=listen, args=(lines,)).start()
    run(given.url, given.payloads, given.hz, given.sources, lines)
