"""A bus that goes and comes back, and several who share it."""

import threading
import time
from contextlib import suppress

import numpy as np
import pytest

from dronecan_wire import UNIQUE, node_on, of, run
from ross_payload.dronecan.node import Identity, Node
from ross_payload.dronecan.shared_bus import SharedBuses, node_of
from ross_payload.errors import LinkError
from ross_protocols.can import CanFrame
from ross_protocols.dronecan.messages import NodeStatus
from ross_sim.clock import SimClock


def test_a_bus_that_is_down_is_named_and_forgotten_when_it_is_back(wire, stranger):
    node = node_on(wire)
    wire.down = True
    run(node, 1.5)
    assert node.trouble == "the bus is down"
    wire.down = False
    run(node, 1.5, 1.5)
    assert node.trouble == "the bus is down"  # nobody was heard on it
    stranger.say(stranger.voice.broadcast(NodeStatus(1)))
    run(node, 0.1, 3.0)
    assert node.trouble == ""
    assert of(NodeStatus, stranger.heard())


def test_a_bus_without_anybody_else_is_well_after_a_while(wire):
    node = node_on(wire)
    wire.down = True
    run(node, 1.5)
    wire.down = False
    run(node, 6.0, 1.5)
    assert node.trouble == ""


def test_users_of_one_bus_share_it_and_hear_the_same(wire, stranger):
    buses = SharedBuses(wire.open, SimClock())
    one, other = buses.open("can:test:0"), buses.open("can:test:0")
    assert len(wire.ends) == 2
    frame = CanFrame(1, b"x")
    stranger.end.send(frame)
    assert (one.receive(), other.receive()) == ([frame], [frame])
    one.send(frame)
    assert other.receive() == []
    assert stranger.end.receive() == [frame]
    one.close()
    one.close()
    assert len(wire.ends) == 2
    other.close()
    assert len(wire.ends) == 1
    buses.open("can:test:0").close()


def test_a_bus_that_fails_is_opened_again(wire, stranger):
    clock = SimClock()
    tap = SharedBuses(wire.open, clock).open("can:test:0")
    wire.down = True
    with pytest.raises(LinkError, match="the bus is down"):
        tap.receive()
    assert len(wire.ends) == 1
    wire.down = False
    with pytest.raises(LinkError, match="the bus is down"):
        tap.receive()
    clock.sleep(1.0)
    frame = CanFrame(1, b"x")
    assert eventually(tap.receive) == []  # it is opened on a thread of its own
    stranger.end.send(frame)
    assert tap.receive() == [frame]
    tap.close()


def test_a_bus_that_does_not_come_back_is_one_trouble(wire):
    clock = SimClock()
    tap = SharedBuses(wire.open, clock).open("can:test:0")
    node = Node(Identity("x", UNIQUE, 5), tap, np.random.default_rng(1), 0.0)
    wire.down, troubles = True, set()
    for _ in range(50):
        clock.sleep(0.5)
        node.poll(clock.now())
        time.sleep(0.002)  # for the thread that tries to open it
        troubles.add(node.trouble)
    assert troubles == {"the bus is down"}
    node.close()


def test_a_bus_that_comes_back_when_nobody_wants_it_is_closed_again(wire):
    clock, wanted, opened = SimClock(), threading.Event(), threading.Event()
    ports = iter([wire.open])

    def slowly(url):
        for at_once in ports:
            return at_once()
        assert wanted.wait(20)
        port = wire.open()
        opened.set()
        return port

    tap = SharedBuses(slowly, clock).open("can:test:0")
    wire.down = True
    for _ in range(2):
        with pytest.raises(LinkError):
            tap.receive()
        clock.sleep(1.0)
    wire.down = False
    tap.close()
    wanted.set()
    assert opened.wait(20)
    deadline = time.monotonic() + 20
    while wire.ends and time.monotonic() < deadline:
        time.sleep(0.01)
    assert wire.ends == []


def eventually(receive):
    for _ in range(1000):
        with suppress(LinkError):
            return receive()
        time.sleep(0.01)
    raise AssertionError("the bus does not come back")


def test_a_wire_that_is_no_can_bus_is_not_shared(wire):
    buses = SharedBuses(wire.open, SimClock())
    assert buses.open("pulses:x") is not buses.open("pulses:x")
    assert len(wire.ends) == 2


def test_who_shares_the_bus_finds_its_node(wire):
    buses = SharedBuses(wire.open, SimClock())
    tap, driver = buses.open("can:test:0"), buses.open("can:test:0")
    assert node_of(driver) is None
    tap.bus.node = node = Node(Identity("x", UNIQUE, 5), tap, np.random.default_rng(1), 0.0)
    assert node_of(driver) is node
    assert node_of(wire.open()) is None
