"""A bus in this process, and who else is on it."""

import pytest

from dronecan_bench import Peer
from dronecan_wire import Stranger, Wire


@pytest.fixture
def wire():
    return Wire()


@pytest.fixture
def peer(wire):
    return Peer(wire)


@pytest.fixture
def stranger(wire):
    return Stranger(wire, 9)
