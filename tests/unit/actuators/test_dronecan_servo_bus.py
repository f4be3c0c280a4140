"""The driver of a DroneCAN servo on buses that fail and among strangers."""

import math
from itertools import pairwise

import numpy as np
import pytest

from can_servo_bench import Rig
from examples import in_soak
from ross_payload.dronecan.node import Identity, Node
from ross_payload.dronecan.shared_bus import SharedBuses
from ross_payload.errors import ActuatorFault, LimitError, LinkError, NotHomed
from ross_protocols.can import CanFrame
from ross_protocols.dronecan.gimbal_messages import AngularCommand, GimbalStatus
from ross_protocols.dronecan.messages import ArrayCommand, Health, Mode, NodeStatus
from ross_protocols.dronecan.transfer import SERVICE
from ross_sim.clock import QUANTUM, SimClock
from ross_sim.devices.far_end import Fault

MODEL = {"feedback": "model"}
GIMBAL = {"command": "gimbal"}
COMMANDS = ["unitless", "position", "pwm", "gimbal"]


class BreakableWire:
    """A bus that may be down: neither takes frames nor gives any."""

    def __init__(self, port):
        self._port = port
        self.down = self.deaf = False

    def send(self, frame):
        if self.down or self.deaf:
            raise LinkError("wire 'can:x' takes no frames: no buffer")
        self._port.send(frame)

    def receive(self):
        arrived = self._port.receive()
        if self.down:
            raise LinkError("wire 'can:x' is down: Network is down")
        return arrived

    def close(self):
        self._port.close()


def breakable(**options):
    wires = []
    rig = Rig(wrap=lambda port: wires.append(BreakableWire(port)) or wires[0], **options)
    return rig, wires[0]


# ------------------------------------------------------------------------------------------ the bus goes and comes


def test_a_bus_that_goes_down_is_named_and_the_servo_stops_at_the_last_set_point():
    rig, wire = breakable()
    rig.go(150, 0.8)
    wire.down, here = True, rig.true_deg
    rig.clock.sleep(0.02)
    assert rig.state.fault == "wire 'can:x' is down: Network is down"
    rig.clock.sleep(2.0)
    assert abs(rig.true_deg - here) < 5
    assert not rig.state.settled


@pytest.mark.parametrize("what", ["down", "deaf"])
def test_a_bus_that_comes_back_moves_nothing_until_it_is_asked(what):
    rig, wire = breakable()
    rig.go(150, 0.8)
    setattr(wire, what, True)
    rig.clock.sleep(0.5)
    rig.actuator.home()  # in vain: this is not kept for later
    rig.clock.sleep(1.5)
    assert rig.state.fault.startswith("wire 'can:x'")
    setattr(wire, what, False)
    said, stands = len(rig.values()), rig.true_deg
    rig.clock.sleep(2.0)
    assert len(rig.values()) == said
    assert rig.true_deg == pytest.approx(stands, abs=0.1)
    with pytest.raises(ActuatorFault):
        rig.go(20)


@pytest.mark.parametrize("options", [{}, MODEL, GIMBAL])
def test_after_the_bus_came_back_home_and_rearm_make_it_move_again(options):
    rig, wire = breakable(**options)
    rig.actuator.home()
    rig.clock.sleep(3.0)
    rig.go(100, 0.8)
    wire.down = True
    rig.clock.sleep(1.0)
    wire.down = False
    rig.clock.sleep(0.1)
    rig.actuator.home()
    rig.clock.sleep(3.0)
    rig.actuator.rearm()
    rig.go(-20, 4.0)
    assert rig.state.settled
    assert rig.true_deg == pytest.approx(-20, abs=0.25)


def test_closing_while_the_bus_is_down_takes_no_time():
    rig, wire = breakable()
    rig.go(150, 0.8)
    wire.down, begin = True, rig.clock.now()
    rig.actuator.__exit__(None, None, None)
    assert rig.clock.now() - begin < 0.05


@pytest.mark.parametrize("command", COMMANDS)
def test_a_program_that_hangs_or_dies_leaves_a_servo_at_its_last_set_point(command):
    rig = Rig(command=command)
    rig.go(150, 0.8)
    rig.hang()
    last = rig.true_deg
    rig.clock.sleep(3.0)
    assert abs(rig.true_deg - last) < 5  # what its set-points led at 90 deg/s
    assert abs(rig.node.shaft.rate) < math.radians(0.1)  # held by friction, or creeping within a count of its encoder


@pytest.mark.parametrize("pause", [0.6, *in_soak(0.15, 3.0)])
def test_after_a_pause_of_the_program_set_points_go_on_where_they_ended(pause):
    rig = Rig(**MODEL)
    rig.actuator.home()
    rig.clock.sleep(3.0)
    rig.go(150, 0.8)
    rig.hang()
    rig.clock.sleep(pause)
    before = len(rig.values()) - 1
    rig.clock.every(QUANTUM, lambda: rig.actuator.poll(rig.clock.now()))
    rig.clock.sleep(4.0)
    joints = [math.degrees(rig.options.joint_of(value)) for value in rig.values()[before:]]
    steps = [after - earlier for earlier, after in pairwise(joints)]
    assert abs(steps[0]) < 0.2
    assert max(steps) <= 225 * 0.02 + 0.2
    assert joints[-1] == pytest.approx(150, abs=0.2)


# ------------------------------------------------------------------------------------------ strangers


def test_a_double_that_was_switched_on_with_the_servo_is_noticed():
    rig = Rig()
    rig.far_end.afflict(Fault.DUPLICATE)
    rig.clock.sleep(0.2)
    assert rig.state.fault in (
        "another node has the servo's id 50",
        "the servo restarted after 0 s, or another node has the servo's id: its position is uncertain",
    )


def test_two_masters_do_not_fight():
    rig = Rig()
    rig.go(100, 0.8)
    rig.far_end.afflict(Fault.TAKEN)
    rig.clock.sleep(0.1)
    said = len(rig.values())
    rig.clock.sleep(2.0)
    assert len(rig.values()) == said
    assert rig.true_deg == pytest.approx(0, abs=0.25)  # where the other one holds it


def test_a_gimbal_has_no_business_with_commands_of_actuators():
    rig = Rig(gimbal_id=1, **GIMBAL)
    rig.say(9, ArrayCommand(()))
    rig.say(9, AngularCommand(2, 1.0))
    rig.say(9, GimbalStatus(2, 1.0))
    rig.clock.sleep(0.1)
    assert rig.state.healthy
    rig.say(9, AngularCommand(1, 1.0))
    rig.clock.sleep(0.1)
    assert "node 9 commands actuator 1 too" in rig.state.fault


def test_a_bus_that_only_reports_do_not_pass_is_named_too():
    rig = Rig()
    rig.go(100, 0.5)
    flood = CanFrame(12 << 24 | 20998 << 8 | 7, bytes(7) + b"\xc0")  # between commands and reports
    plug = rig.far_end.crowd.bus.plug()
    rig.clock.before_calls(lambda now: plug.sent.extend([flood] * 100))
    rig.clock.sleep(0.6)
    assert rig.state.fault.startswith("the bus is full: ")
    assert rig.state.fault.endswith("most of them from node 7")


@pytest.mark.parametrize("beats_only", [True, *in_soak(False)])
def test_a_busy_bus_on_which_the_servo_is_heard_is_no_fault(beats_only):
    rig = Rig(guard={"watchdog_s": 2.5}, **(MODEL if beats_only else {}))
    rig.node._next_report = math.inf if beats_only else 0.0
    rig.actuator.__exit__(None, None, None)
    rig.actuator.__enter__()
    plug = rig.far_end.crowd.bus.plug()
    rig.clock.before_calls(lambda now: plug.sent.extend([CanFrame(30 << 24 | 20998 << 8 | 7, bytes(8))] * 100))
    rig.actuator.home()
    rig.clock.sleep(3.0)
    rig.go(60, 4.0)
    assert rig.state.healthy, rig.state.fault
    assert rig.state.settled


def test_a_frame_lost_now_and_then_is_no_fault():
    rig = Rig()
    rig.far_end.crowd.plug.damage = 0.03
    for goal in (120, -120, 0):
        rig.go(goal, 5.0)
        assert rig.state.healthy
        assert rig.state.settled


@pytest.mark.soak
def test_a_good_encoder_does_not_tremble():
    rig = Rig()
    for goal in (3, -150, 150, 149, 0):
        rig.go(goal, 5.0)
        assert rig.state.healthy


def test_a_trembling_encoder_is_noticed_at_rest():
    rig = Rig()
    rig.far_end.afflict(Fault.NOISY)
    rig.clock.sleep(1.0)
    assert "is noisy" in rig.state.fault


# ------------------------------------------------------------------------------------------ who we are


def test_without_a_node_id_nothing_is_said_but_the_question_for_one():
    rig = Rig(own_node_id=0)
    assert rig.state.fault == "waiting for a node id"
    with pytest.raises(ActuatorFault, match="waiting for a node id"):
        rig.go(10)
    frames = []
    rig.passes = lambda frame: frames.append(frame) or True
    rig.clock.sleep(6.0)
    assert {frame.id & 0x7F for frame in frames} == {0}
    assert "no allocator on the bus answers" in rig.state.fault
    assert rig.values() == []


def test_where_the_payload_is_a_node_already_the_driver_speaks_through_it():
    clock, shared = SimClock(), []

    def wrap(port):
        buses = SharedBuses(lambda url: port, clock)
        tap = buses.open("can:x:y")
        identity = Identity("org.ross.payload", bytes(16), 77)
        shared.append(Node(identity, tap, np.random.default_rng(0), 0.0))
        shared[0].stands(Health.OK, Mode.OPERATIONAL)
        tap.bus.node = shared[0]
        return buses.open("can:x:y")

    rig = Rig(wrap=wrap)
    rig.clock.every(QUANTUM, lambda: shared[0].poll(rig.clock.now()))
    senders = set()
    rig.passes = lambda frame: senders.add(frame.id & 0x7F) or True
    rig.go(30, 3.0)
    assert rig.state.settled
    assert senders == {77}
    beats = [message for _, message in rig.heard if isinstance(message, NodeStatus)]
    assert len(beats) == 3


def questions(rig, seconds):
    """How often the driver asks the servo something."""
    asked = []
    rig.passes = lambda frame: asked.append(frame.id & SERVICE) or True
    rig.clock.sleep(seconds)
    return sum(map(bool, asked))


def test_the_servo_is_asked_once_who_it_is_and_tells_it():
    rig = Rig()
    assert rig.actuator.identity == "org.ross.servo, software 1.0, hardware 1.0"
    assert questions(rig, 5.0) == 0


def test_a_servo_that_never_tells_who_it_is_is_asked_three_times_and_is_well():
    rig = Rig(wrap=Deaf)
    assert questions(rig, 10.0) == 2  # and once before
    assert rig.actuator.identity == ""
    assert rig.state.healthy


class Deaf:
    """A bus on which no answer arrives."""

    def __init__(self, port):
        self._port = port
        self.send, self.close = port.send, port.close

    def receive(self):
        return [frame for frame in self._port.receive() if not frame.id & SERVICE]


@pytest.mark.parametrize("goal", [math.nan, math.inf, -math.inf, 1e9], ids=str)
def test_a_goal_that_is_none_is_refused_by_the_driver_itself(goal):
    rig = Rig()
    with pytest.raises(LimitError, match="outside the travel"):
        rig.actuator._actuator.command(goal)
    rig.clock.sleep(0.5)
    assert rig.values() == []


def test_a_model_that_is_not_homed_refuses():
    with pytest.raises(NotHomed):
        Rig(**MODEL).actuator._actuator.command(0.1)


def test_late_polls_ask_for_no_more_than_the_speed_of_the_move():
    rig, chance = Rig(), np.random.default_rng(0)
    rig.go(-60)
    rig.clock.sleep(4.0)
    driver, sent, due = rig.actuator._actuator._driver, [], [0.0]
    command, poll = driver._client.command, rig.actuator.poll
    driver._client.command = lambda joint: (sent.append((rig.clock.now(), math.degrees(joint))), command(joint))

    def late(now):
        if now >= due[0]:
            due[0] = now + round(chance.uniform(0.01, 0.04), 2) - QUANTUM / 2
            poll(now)

    rig.actuator.poll = late
    rig.actuator.command(math.radians(60), math.radians(60))
    rig.clock.sleep(4.0)
    speeds = [(there - here) / (then - now) for (now, here), (then, there) in pairwise(sent) if then > now]
    assert len(speeds) > 60
    assert max(speeds) <= 60.5
    assert rig.true_deg == pytest.approx(60, abs=0.3)
