"""What goes wrong with a DroneCAN servo is named in time, and never taken for settled."""

import math
import random

import pytest

from can_servo_bench import OWN, SERVO, Rig
from examples import in_soak
from ross_payload.errors import ActuatorFault
from ross_protocols.dronecan.messages import ArrayCommand, Command, Health, LogMessage, Mode, NodeStatus, Status
from ross_sim.clock import QUANTUM

pytestmark = pytest.mark.lockstep


def test_a_jammed_servo_is_named_before_it_is_20_degrees_behind_and_pulls_no_more():
    rig = Rig()
    rig.go(90, 0.5)
    rig.node.shaft.jammed = True
    stuck = rig.true_deg
    rig.clock.sleep(0.6)
    assert "does not follow" in rig.state.fault
    rig.clock.sleep(0.1)
    assert math.degrees(rig.options.joint_of(rig.values()[-1])) == pytest.approx(stuck, abs=0.3)
    assert not rig.state.settled
    with pytest.raises(ActuatorFault, match="does not follow"):
        rig.go(0)


def test_after_a_jam_homing_and_rearming_make_it_move_again():
    rig = Rig()
    rig.go(90, 0.5)
    rig.node.shaft.jammed = True
    rig.clock.sleep(1.0)
    rig.node.shaft.jammed = False
    rig.actuator.home()
    rig.clock.sleep(0.1)
    rig.actuator.rearm()
    rig.go(-20, 4.0)
    assert rig.state.settled
    assert rig.true_deg == pytest.approx(-20, abs=0.25)


def test_a_restart_in_a_move_is_a_fault_and_the_servo_is_told_nothing_more():
    rig = Rig()
    rig.clock.sleep(2.0)
    rig.go(150, 0.5)
    rig.node.restart()
    rig.clock.sleep(0.1)
    assert "restarted after 2 s" in rig.state.fault
    said, stands = len(rig.values()), rig.true_deg
    rig.clock.sleep(1.0)
    assert len(rig.values()) == said
    assert abs(rig.true_deg - stands) < 8
    assert not rig.state.settled


def test_a_silent_servo_is_a_fault_while_it_moves():
    rig = Rig()
    rig.go(150, 0.5)
    rig.node.silent = True
    rig.clock.sleep(0.6)
    assert "no report for" in rig.state.fault
    assert not rig.state.settled


@pytest.mark.parametrize(
    ("health", "mode", "words"),
    [
        (Health.CRITICAL, Mode.OPERATIONAL, "health critical, mode operational"),
        (Health.ERROR, Mode.OPERATIONAL, "health error"),
        (Health.OK, Mode.SOFTWARE_UPDATE, "mode software update"),
    ],
)
def test_what_the_servo_says_of_itself_is_a_fault_in_words_until_it_is_well(health, mode, words):
    rig = Rig()
    rig.node.health, rig.node.mode = health, mode
    rig.clock.sleep(1.1)
    assert words in rig.state.fault
    with pytest.raises(ActuatorFault, match=words):
        rig.go(10)
    rig.node.health, rig.node.mode = Health.OK, Mode.OPERATIONAL
    rig.clock.sleep(1.1)
    assert rig.state.healthy


def test_a_warning_of_the_servo_is_no_fault():
    rig = Rig()
    rig.node.health = Health.WARNING
    rig.clock.sleep(1.1)
    assert rig.state.healthy


@pytest.mark.parametrize(
    ("node", "message", "words"),
    [
        (OWN, NodeStatus(5), "has our node id 121"),
        (9, ArrayCommand((Command(1, 0, 0.3),)), "node 9 commands actuator 1 too"),
        (9, Status(1, 0.0), "alone, got node 9's too"),
    ],
)
def test_somebody_else_on_the_bus_is_a_fault(node, message, words):
    rig = Rig()
    rig.go(90, 0.5)
    rig.say(node, message)
    rig.clock.sleep(0.1)
    assert words in rig.state.fault
    rig.clock.sleep(3.0)
    assert rig.state.rate == 0.0
    assert rig.true_deg < 45


def test_neighbours_with_other_actuators_are_welcome():
    rig = Rig()
    rig.say(9, ArrayCommand((Command(2, 0, 0.3),)))
    rig.say(9, Status(2, 1.0))
    rig.say(9, NodeStatus(3, Health.CRITICAL))
    rig.clock.sleep(0.1)
    assert rig.state.healthy
    assert rig.state.angle == 0.0


def test_the_log_of_the_servo_is_ours(caplog):
    rig = Rig()
    for _ in range(3):
        rig.say(SERVO, LogMessage(3, "motor", "hot"))
        rig.clock.sleep(0.1)
    assert [(record.levelname, record.getMessage()) for record in caplog.records] == [("ERROR", "servo: motor: hot")]


BREAKS = {
    "does not follow": lambda node: setattr(node.shaft, "jammed", True),
    "no report for": lambda node: setattr(node, "silent", True),
    "restarted after": lambda node: node.restart(),
    "health critical": lambda node: setattr(node, "health", Health.CRITICAL),
}


@pytest.mark.parametrize("words", BREAKS)
@pytest.mark.parametrize("seed", [0, *in_soak(*range(1, 20))])
def test_whatever_breaks_in_a_move_is_named_in_time_and_never_settled(words, seed):
    chance = random.Random(seed)  # noqa: S311
    rig = Rig()
    rig.clock.sleep(1.0)
    rig.go(chance.choice([-1, 1]) * chance.uniform(90, 195), chance.uniform(0.2, 1.0))
    BREAKS[words](rig.node)
    for _ in range(110):  # a heartbeat and a bit
        rig.clock.sleep(QUANTUM)
        assert not rig.state.settled
    assert words in rig.state.fault
    rig.node.silent = False
    rig.clock.sleep(3.0)
    assert rig.node.shaft.rate == 0.0
    assert not rig.state.settled
