"""A ground station, and a payload's telemetry in the air."""

import math
import time
from dataclasses import replace

import numpy as np
import pytest

from ross_payload.config import Config, Link
from ross_payload.events import Event
from ross_payload.interfaces import Attitude, AudioBlock, Input
from ross_payload.mavlink import Router
from ross_payload.mavlink.message_board import Board
from ross_payload.mavlink.message_scheduler import Stream, periods
from ross_payload.pointing import Pointing
from ross_payload.telemetry.component import Telemetry
from ross_payload.telemetry.reporter import Reporter
from ross_payload.telemetry.snapshot import Snapshot
from ross_payload.transport.ports import Counts
from ross_protocols.mavlink import values as v
from ross_protocols.mavlink.codec import Decoder
from ross_protocols.mavlink.dialect import ross
from ross_protocols.mavlink.values import Value
from ross_sim.clock import SimClock

REST = Snapshot(
    earth=True, heading=0.2, present=True, joint=0.2, joint_rate=0.0, settled=True, homed=True, rotation_max=12,
    criterion=1.0,
)  # fmt: skip


class Ground:
    """A ground station on a link without limits; it holds the clock."""

    def __init__(self) -> None:
        self.now = 0.0
        self.rest = self.snapshot = REST
        self.heard: list[tuple[float, Value]] = []
        self._board = Board()
        self._stream = Stream(periods(Config().telemetry), lambda value: 0)
        self.reporter = Reporter(self._board, lambda severity, text: None)

    def wait(self, seconds: float, step: float = 0.01) -> None:
        for _ in range(round(seconds / step)):
            self.reporter.observe(self._present())
            self._listen()
            self.now += step

    def _present(self) -> Snapshot:
        return replace(self.snapshot, time_usec=round(self.now * 1e6))

    def _listen(self) -> None:
        self.heard += [(self.now, value) for value in self._stream.due(self._board, self.now, math.inf)]

    def say(self, *events: Event) -> None:
        for event in events:
            self.reporter.handle(event, self._present())
            self._listen()

    def all(self, kind: type) -> list:
        return [value for _, value in self.heard if type(value) is kind]

    def latest(self, kind: type):
        return self.all(kind)[-1]

    def forget(self) -> None:
        self.heard.clear()


def hop(index: int = 16000, start: float = 0.0, end: float = 0.01, known: bool = True, fault: str = "") -> Input:
    """One Input of 10 ms; angles in radians."""
    block = AudioBlock(np.zeros((2, 160), np.float32), index, index / 16000)
    pointing = Pointing(joint=end, base=0.5, offset=-0.5, earth=known)
    return Input(block, start, pointing, settled=False, attitude=Attitude(0.5, known=known), fault=fault)


class Port:
    """One end of a link; the other end reads what came and may speak."""

    def __init__(self) -> None:
        self.counts = Counts()
        self.decoder = Decoder()
        self.packets: list = []
        self.times: list[float] = []
        self._arriving: list[bytes] = []
        self._mavlink = ross.MAVLink(None, srcSystem=255, srcComponent=190)

    def send(self, frame: bytes) -> None:
        got = self.decoder.feed(frame)
        self.packets += got
        self.times += [time.monotonic()] * len(got)

    def receive(self) -> list[bytes]:
        arrived, self._arriving = self._arriving, []
        return arrived

    def close(self) -> None:
        """Nothing to give back."""

    def call(self, message, frame: bytes | None = None) -> None:
        self._arriving.append(message.pack(self._mavlink) if frame is None else frame)
        self._mavlink.seq = (self._mavlink.seq + 1) % 256

    def values(self, kind: type) -> list:
        return [packet.value for packet in self.packets if type(packet.value) is kind]

    def names(self) -> set[str]:
        return {packet.name for packet in self.packets}

    def texts(self) -> list[str]:
        return [text.text for text in self.values(v.Text)]

    def messages(self, name: str) -> list:
        return [packet.message for packet in self.packets if packet.name == name]


class Sky:
    """A payload's telemetry on simulated time, with some links."""

    Port = Port
    hop = staticmethod(hop)

    def __init__(self, *links: Link, **parts) -> None:
        self.clock = SimClock()
        self.links = Router(self.clock, 1)
        self.ports = [Port() for _ in links]
        for link, port in zip(links, self.ports, strict=True):
            self.links.attach(link, port)
        self.telemetry = Telemetry(Config(), self.clock, self.links, **parts)
        self.clock.every(0.01, self.links.poll)

    def __enter__(self) -> "Sky":
        self.telemetry.__enter__()
        return self

    def __exit__(self, *error) -> None:
        self.telemetry.__exit__(*error)
        self.links.close()

    def live(self, seconds: float) -> None:
        for index in range(round(seconds * 100)):
            self.telemetry.on_input(hop(index * 160))
            self.clock.advance()


@pytest.fixture
def ground() -> Ground:
    """A ground station that hears what a reporter puts on the board."""
    return Ground()


@pytest.fixture
def aloft() -> type[Sky]:
    """Make telemetry with links: ``with aloft(GROUND) as sky``."""
    return Sky
