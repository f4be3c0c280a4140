"""A whole payload in simulated time, in a silent room, whose node is on a bus; a script lives along, hop by hop."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from dronecan_wire import Stranger, of
from ross_payload.config import Config
from ross_payload.config.parameter_store import Parameters
from ross_payload.dronecan.shared_bus import SharedBuses
from ross_payload.interfaces import AudioBlock, Port, VoicePrint
from ross_payload.mavlink import Router
from ross_payload.mount import FixedMount
from ross_payload.orders import Shutdown
from ross_payload.service.payload import Parts, assembled
from ross_payload.service.runner import Runner
from ross_payload.sessions.session_store import SessionStore
from ross_payload.timebase import Timebase
from ross_protocols.dronecan.node_messages import Reply
from ross_protocols.mavlink.codec import Decoder
from ross_protocols.mavlink.values import Text
from ross_sim.clock import SimClock
from ross_sim.devices.far_end import far_end_of
from ross_sim.sitl.recording import drained

URL = "can:test:0"
SEED = 1
UNIQUE_ID = np.random.default_rng(SEED).bytes(16)  # of the payload
HOPS = 6000  # a script that takes longer has failed


class Peer(Stranger):
    """Another node: asks, and remembers what it hears."""

    def __init__(self, wire, node_id=9):
        super().__init__(wire, node_id)
        self.all, self.answers = [], []

    def listen(self):
        for said in self.heard():
            (self.answers if isinstance(said, Reply) else self.all).append(said)

    def ask(self, request, node=121):
        """Ask, and give hops until the answer is there; none comes within half a second: None."""
        self.answers.clear()
        self.say(self.voice.request(request, node))
        for _ in range(50):
            yield
            self.listen()
            if self.answers:
                return self.answers[-1].response
        return None

    def wait(self, seconds):
        for _ in range(round(seconds * 100)):
            yield
            self.listen()

    def latest(self, kind):
        return of(kind, self.all)[-1].message


class Silence:
    """Two microphones that hear nothing, in lock-step with the clock."""

    rate = 16000

    def __init__(self, clock: SimClock) -> None:
        self._clock = clock
        self._index = 0

    def read(self, n: int) -> AudioBlock:
        time = self._clock.now()
        self._clock.sleep(n / self.rate)
        self._index += n
        return AudioBlock(np.zeros((2, n), np.float32), self._index - n, time)

    def __enter__(self) -> Silence:
        return self

    def __exit__(self, *_: object) -> None:
        """Nothing to give back."""


@dataclass
class Bench:
    """What a script works with."""

    clock: SimClock
    parameters: Parameters
    runner: Runner
    restarts: list[str]
    orders: list[Any]  # that reached the mission
    far_end: Any
    said: dict[int, str]  # STATUSTEXT, by id

    @property
    def texts(self) -> list[str]:
        """What an operator on MAVLink would read."""
        return list(self.said.values())

    def sent(self, frame: bytes) -> None:
        """Take what leaves on MAVLink."""
        for packet in Decoder().feed(frame):
            if isinstance(packet.value, Text):
                self.said[packet.value.id] = self.said.get(packet.value.id, "") + packet.value.text

    heard: Any = None  # the latest Input

    def tell(self, *events: Any) -> None:
        """Let everybody who watches the mission believe that it said something."""
        for event in events:
            for observer in self.runner.observers[:-1]:
                observer.on_event(event, self.heard)


class LatePort:
    """The wire of an actuator whose far end is switched on some time after the payload."""

    def __init__(self, port: Port, clock: SimClock, begin: float) -> None:
        self._port, self._clock, self._begin = port, clock, begin

    def send(self, frame: Any) -> None:
        """Send a frame; before the beginning nobody is there."""
        if self._clock.now() >= self._begin:
            self._port.send(frame)

    def receive(self) -> list[Any]:
        """Return what has arrived."""
        arrived = self._port.receive()
        return arrived if self._clock.now() >= self._begin else []

    def close(self) -> None:
        """Close the wire."""
        self._port.close()


class Living:
    """An observer that lets a script live: a generator that yields when a hop shall pass."""

    def __init__(self, bench: Bench, script: Iterator[None]) -> None:
        self._bench = bench
        self._script = script
        self._hops = 0
        self._done = False

    def on_input(self, heard: Any) -> None:
        self._hops += 1
        self._bench.heard = heard
        self._bench.orders += heard.orders
        if not self._done and next(self._script, self) is self:
            self._done = True
            self._bench.runner.order(Shutdown())
        assert self._hops < HOPS, "the script waits for ever"

    def on_event(self, event: Any, heard: Any) -> None:
        """What is said goes over the bus."""


def payload(
    tables: dict[str, Any],
    open_can: Callable[[str], Port] | None,
    folder: Path,
    powered: float = 0.0,
    target: VoicePrint | None = None,
) -> Any:
    """A payload, unless told otherwise with an ideal actuator; without ``open_can`` the bus is the actuator's.

    What turns is there from ``powered`` [s] on.
    """
    config = Config.model_validate({"actuator": {"kind": "ideal"}, "dronecan": {"port": URL}} | tables)
    return _aboard(config, open_can, folder, powered, target)


@contextmanager
def _aboard(
    config: Config, open_can: Callable[[str], Port] | None, folder: Path, powered: float, target: VoicePrint | None
) -> Iterator[Bench]:
    clock, far_end, restarts = SimClock(), far_end_of(config), []
    clock.before_calls(far_end.advance)

    def open_port(url: str) -> Port:
        return open_can(url) if open_can and url.startswith("can:") else LatePort(far_end.port, clock, powered)

    buses = SharedBuses(open_port, clock)
    with Router.open((), clock, system_id=1, state=folder) as links, Parameters(config, folder / "params.toml") as kept:
        parts = Parts(
            clock=clock,
            source=Silence(clock),
            open_port=buses.open,
            links=links,
            mount=FixedMount(None),
            timebase=Timebase(clock),
            parameters=kept,
            store=SessionStore(folder / "recordings"),
            drained=drained(clock),
            voiceprint=target,
            state=folder,
            rng=np.random.default_rng(SEED),
            restart=lambda: restarts.append("asked"),
        )
        with assembled(parts) as runner:
            bench = Bench(clock, kept, runner, restarts, [], far_end, {})
            links.component(config.telemetry.component_id).tap(bench.sent)
            yield bench


def live(bench: Bench, script: Iterator[None]) -> None:
    """Run the payload until the script ends, or somebody shuts it down."""
    bench.runner.observers.append(Living(bench, script))
    bench.runner.run()


def play(script, open_can, folder, powered=0.0, target=None, **tables):
    """Let a script live with a payload, which seeks ``target``; return the bench."""
    with payload(tables, open_can, folder, powered, target) as bench:
        live(bench, script(bench))
    return bench
