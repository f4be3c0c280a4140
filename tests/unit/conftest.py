"""A ground station and a payload's links in one process, with the air between them."""

from types import SimpleNamespace

import numpy as np
import pytest

from command_line import run  # noqa: F401
from nobody import closed  # noqa: F401
from ross_payload.config import Link
from ross_payload.mavlink import Router
from ross_payload.transport.ports import Counts
from ross_protocols.mavlink.codec import Decoder
from ross_protocols.mavlink.dialect import ross
from ross_sim.clock import SimClock
from signing_bench import key_file, payload  # noqa: F401

URL = "udpout:127.0.0.1:14550"


class Air:
    """The payload's end of a link on which frames are lost, doubled, delayed and damaged, as often as told."""

    def __init__(self, loss=0.0, doubled=0.0, delayed=0.0, damaged=0.0, seed=1):
        self.counts = Counts()
        self.odds = SimpleNamespace(loss=loss, doubled=doubled, delayed=delayed, damaged=damaged)
        self.random = np.random.default_rng(seed)
        self.up, self.down = [], []
        self.late = {"up": [], "down": []}

    def send(self, frame):
        self.down += self._through(frame, "down")

    def receive(self):
        arrived, self.up = self.up + self._late("up"), []
        return arrived

    def close(self):
        pass

    def call(self, frame):
        """Send a frame up, from the ground."""
        self.up += self._through(frame, "up")

    def listen(self):
        """What has come down."""
        arrived, self.down = self.down + self._late("down"), []
        return arrived

    def _late(self, way):
        """What was delayed until now: a few tenths of a second when looked at every 10 ms."""
        if not self.late[way] or self.random.random() > 0.03:
            return []
        late, self.late[way] = self.late[way], []
        return late

    def _through(self, frame, way):
        odds, draw = self.odds, self.random.random
        frames = [] if draw() < odds.loss else [frame] * (2 if draw() < odds.doubled else 1)
        if frames and draw() < odds.delayed:
            self.late[way] += frames
            return []
        if frames and draw() < odds.damaged:
            place = int(self.random.integers(len(frame)))
            frames[0] = frame[:place] + bytes([frame[place] ^ int(self.random.integers(1, 256))]) + frame[place + 1 :]
        return frames


class Ground:
    """A ground station: packs with pymavlink, keeps what it hears."""

    def __init__(self, air, system_id=255, component_id=190):
        self.air = air
        self.mavlink = ross.MAVLink(None, srcSystem=system_id, srcComponent=component_id)
        self.decoder = Decoder()
        self.heard = []

    def send(self, message):
        self.air.call(message.pack(self.mavlink))
        self.mavlink.seq = (self.mavlink.seq + 1) % 256

    def long(self, number, *numbers, target=(1, 191), confirmation=0):
        padded = [*numbers, *[0.0] * (7 - len(numbers))]
        self.send(ross.MAVLink_command_long_message(*target, number, confirmation, *padded))

    def int(self, number, *numbers, target=(1, 191)):
        p1, p2, p3, p4, x, y, z = [*numbers, *[0] * (7 - len(numbers))]
        self.send(ross.MAVLink_command_int_message(*target, 0, number, 0, 0, p1, p2, p3, p4, x, y, z))

    def listen(self):
        """What has come down since the last time."""
        fresh = [packet.message for data in self.air.listen() for packet in self.decoder.feed(data)]
        self.heard += fresh
        return fresh


class Sky(SimpleNamespace):
    """A payload's links, the air and a ground station, on one clock."""

    def wait(self, seconds, *servers):
        """Let time pass, in steps of 10 ms; return the messages that the ground station hears."""
        heard = []
        for _ in range(round(seconds * 100)):
            self.clock.advance()
            self.links.poll()
            for server in servers:
                server.tick(self.clock.now())
            heard += self.ground.listen()
        return heard


@pytest.fixture(scope="module")
def sky():
    """Make links of a payload, the air and a ground station: ``sky(loss=0.2).ground``."""
    opened = []

    def make(accept=(), max_bytes_s=0, **odds):
        air = Air(**odds)
        clock = SimClock()
        links = Router(clock, 1)
        opened.append(links)
        links.attach(Link(url=URL, accept=accept, max_bytes_s=max_bytes_s), air)
        return Sky(clock=clock, links=links, air=air, ground=Ground(air))

    yield make
    for links in opened:
        links.close()
