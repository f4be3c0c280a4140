"""An actuator that is late at the start is waited for and then no fault; a fault of motion stays one."""

import numpy as np
import pytest

from dronecan_bench import URL, Peer, play
from dronecan_wire import Wire
from ross_payload.dronecan.allocator import Allocator
from ross_payload.dronecan.node import Identity, Node
from ross_payload.dronecan.persistence import PersistentIds
from ross_payload.events import State, StateChanged
from ross_payload.orders import TurnTo
from ross_protocols.dronecan.messages import Health, Mode, NodeStatus, Received
from ross_protocols.dronecan.node_messages import Decoder
from ross_sim.devices.far_end import Fault

OTHER = bytes(range(50, 66))  # what tells the autopilot from all other nodes


@pytest.fixture
def wire():
    return Wire()


@pytest.fixture
def peer(wire):
    return Peer(wire)


class Allocating:
    """An autopilot on the bus of a servo: gives ids from a time on, and hears how healthy others say they are."""

    def __init__(self, bus, now):
        plug = bus.plug()
        rng = np.random.default_rng(2)
        self.node = Node(Identity("org.example.autopilot", OTHER, 10), plug, rng, now)
        self.allocator = Allocator(self.node, PersistentIds(None, rng), now)
        self.beats = []
        self.node.subscribe(self._note)

    def _note(self, received, now):
        if isinstance(received.message, NodeStatus) and received.node not in (0, 50):
            self.beats.append((now, received.message.health, received.message.mode))

    def poll(self, now):
        self.node.poll(now)
        self.allocator.poll(now)


def test_an_id_that_comes_late_leaves_a_healthy_node_and_a_payload_that_turns(tmp_path):
    """ArduPilot does not arm with a node on the bus that says ERROR."""
    servo = {"kind": "dronecan_servo", "options": {"port": URL}}
    autopilot, given, states = [], [], []

    def script(bench):
        begin = bench.clock.now()
        while not given:
            if not autopilot and bench.clock.now() > 6.0:
                autopilot.append(Allocating(bench.far_end.crowd.bus, bench.clock.now()))
            for each in autopilot:
                each.poll(bench.clock.now())
                given.extend(each.beats[:1])
            assert not given or bench.clock.now() - begin > 5.0, "not late"
            yield
        for _ in range(300):
            autopilot[0].poll(bench.clock.now())
            yield
        bench.runner.order(TurnTo(0.5))
        yield from (None for _ in range(300))
        states.append((bench.heard.fault, bench.far_end.angle()))

    play(script, None, tmp_path, actuator=servo, dronecan={"port": URL, "node_id": 0})
    late = [(health, mode) for time, health, mode in autopilot[0].beats if time > given[0][0] + 2.0]
    assert set(late) == {(Health.OK, Mode.OPERATIONAL)}
    assert states == [("", pytest.approx(0.5, abs=0.02))]


class States:
    """Notes the states of the mission, and when they began."""

    def __init__(self, clock):
        self.clock, self.entered = clock, []

    def on_input(self, heard):
        pass

    def on_event(self, event, heard):
        if isinstance(event, StateChanged):
            self.entered.append((self.clock.now(), event.state))


def test_a_task_of_autostart_begins_when_the_id_has_come(tmp_path):
    servo = {"kind": "dronecan_servo", "options": {"port": URL}}
    states = []

    def script(bench):
        states.append(States(bench.clock))
        bench.runner.observers += states
        while bench.clock.now() < 6.0:
            yield
        assert bench.heard.fault
        autopilot = Allocating(bench.far_end.crowd.bus, bench.clock.now())
        while bench.clock.now() < 16.0:
            autopilot.poll(bench.clock.now())
            yield

    tables = {"dronecan": {"port": URL, "node_id": 0}, "service": {"autostart": "explore"}}
    play(script, None, tmp_path, actuator=servo, **tables)
    found = [state for time, state in states[0].entered if time > 6.0]
    assert found[:2] == [State.IDLE, State.LEAD_IN], found


def test_an_autopilot_that_is_late_leaves_a_healthy_node_and_a_payload_that_turns(wire, peer, tmp_path):
    gimbal = {"kind": "mavlink_gimbal"}
    states = []

    def script(bench):
        yield from peer.wait(1.5)
        assert peer.latest(NodeStatus).health is Health.ERROR
        assert "heartbeat" in bench.heard.fault
        while bench.heard.fault:
            yield from peer.wait(0.1)
        yield from peer.wait(2.0)
        states.append(peer.latest(NodeStatus).health)
        bench.runner.order(TurnTo(0.5))
        yield from (None for _ in range(600))
        states.append(bench.far_end.angle())

    play(script, wire.open, tmp_path, powered=8.0, actuator=gimbal)
    assert states == [Health.OK, pytest.approx(0.5, abs=0.03)]


def test_a_fault_of_motion_stays_after_its_cause_has_gone(tmp_path):
    servo = {"kind": "dronecan_servo", "options": {"port": URL}}
    beats = []

    def script(bench):
        plug, ear = bench.far_end.crowd.bus.plug(), Decoder(0)
        bench.runner.order(TurnTo(1.5))
        yield from (None for _ in range(40))
        bench.far_end.afflict(Fault.STUCK)
        yield from (None for _ in range(300))
        bench.far_end.afflict(Fault.STUCK, False)
        plug.receive()
        for _ in range(500):
            said = [ear.feed(frame) for frame in plug.receive()]
            beats.extend(each.message for each in said if isinstance(each, Received) and each.node == 121)
            yield

    play(script, None, tmp_path, actuator=servo)
    assert {beat.health for beat in beats if isinstance(beat, NodeStatus)} == {Health.ERROR}
