"""A DroneCAN bus in this process, in virtual time, with strangers on it who say and hear whatever a test wants."""

from __future__ import annotations

import numpy as np

from ross_payload.dronecan.node import Identity, Node
from ross_payload.errors import LinkError
from ross_protocols.dronecan.node_messages import Decoder, Encoder

UNIQUE = bytes(range(16))
PERIOD = 0.01  # [s] of the pump


class Wire:
    """A bus: every end hears all others."""

    def __init__(self):
        self.ends = []
        self.down = False

    def open(self, url="can:test:0"):
        if self.down:
            raise LinkError("no bus")
        end = End(self)
        self.ends.append(end)
        return end


class End:
    def __init__(self, wire):
        self.wire, self.frames = wire, []

    def send(self, frame):
        if self.wire.down:
            raise LinkError("the bus is down")
        for end in self.wire.ends:
            if end is not self:
                end.frames.append(frame)

    def receive(self):
        if self.wire.down:
            raise LinkError("the bus is down")
        frames, self.frames = self.frames, []
        return frames

    def close(self):
        if self in self.wire.ends:
            self.wire.ends.remove(self)


class Stranger:
    """Another node, of which we hear everything."""

    def __init__(self, wire, node_id):
        self.end, self.voice, self.ear = wire.open(), Encoder(node_id), Decoder(node_id)

    def say(self, frames):
        for frame in frames:
            self.end.send(frame)

    def heard(self):
        return [said for frame in self.end.receive() if (said := self.ear.feed(frame)) is not None]


def node_on(wire, node_id=42, unique_id=UNIQUE, **more):
    identity = Identity("org.ross.payload", unique_id, node_id, software=(1, 2))
    return Node(identity, wire.open(), np.random.default_rng(int.from_bytes(unique_id, "little")), 0.0, **more)


def run(node, seconds, begin=0.0):
    for n in range(round(seconds / PERIOD)):
        node.poll(begin + n * PERIOD)
    return begin + seconds


def of(kind, said):
    return [each for each in said if isinstance(getattr(each, "message", None), kind)]
