"""Whatever goes wrong when a wire is used for the last time, it is closed."""

from __future__ import annotations

import numpy as np
import pytest

from dronecan_wire import UNIQUE
from ross_payload.dronecan.node import Identity, Node
from ross_payload.errors import LinkError
from ross_payload.interfaces import Services
from ross_sim.clock import SimClock
from ross_sim.devices.ideal import Options, backend


class Broken:
    """A port that takes nothing."""

    def __init__(self, error):
        self.error, self.closed = error, 0

    def send(self, frame):
        raise self.error

    def receive(self):
        return []

    def close(self):
        self.closed += 1


def test_an_ideal_actuator_closes_a_wire_that_does_not_take_its_stop():
    port = Broken(LinkError("cut"))
    actuator = backend.open(Options(), Services(SimClock(), lambda url: port))
    actuator.__enter__()
    with pytest.raises(LinkError):
        actuator.__exit__(None, None, None)
    actuator.__exit__(None, None, None)
    assert port.closed == 1


def test_a_node_closes_a_bus_that_does_not_take_its_farewell():
    port = Broken(OSError("no buffer space"))
    node = Node(Identity("org.ross.payload", UNIQUE, 42), port, np.random.default_rng(0), 0.0)
    with pytest.raises(OSError, match="no buffer space"):
        node.close()
    assert port.closed == 1
