"""Control of a gimbal behind an autopilot is given back when no task needs it, whatever has happened meanwhile."""

import math

import pytest

from gimbal_rig import CONFIGURE, FREE, PAYLOAD, SET_POINT, Bench, after_a_task
from ross_payload.errors import ActuatorFault
from ross_sim.clock import QUANTUM


@pytest.fixture
def rig():
    return Bench("client")


@pytest.fixture
def released(rig):
    return after_a_task(rig)


def test_after_a_task_control_is_released_and_nothing_is_streamed(released):
    assert released.primary == FREE
    assert not {SET_POINT, CONFIGURE} & set(released.sent(3.0))
    assert released.far_end.angle() == pytest.approx(0.4, abs=math.radians(0.1))


def test_a_release_in_a_move_comes_into_force_at_its_end(rig):
    rig.actuator.command(1.0)
    rig.clock.sleep(0.5)
    rig.actuator.release_control()
    rig.clock.sleep(0.3)
    assert rig.primary == PAYLOAD
    rig.clock.sleep(3.0)
    assert rig.primary == FREE
    assert rig.far_end.angle() == pytest.approx(1.0, abs=math.radians(0.1))


def test_a_release_that_is_lost_is_said_again(rig):
    rig.actuator.command(0.1)
    rig.settle()
    rig.actuator.release_control()
    rig.far_end.port.sent.clear()
    while CONFIGURE not in rig.sent(0.01):
        pass
    rig.far_end.port.sent.clear()
    rig.clock.sleep(1.0)
    assert rig.primary == FREE


def test_control_that_was_taken_to_home_is_given_back(released):
    released.actuator.home()
    released.clock.sleep(1.0)
    assert released.primary == PAYLOAD
    released.actuator.release_control()
    released.clock.sleep(2.0)
    assert released.primary == FREE


def test_control_is_given_back_after_an_outage_that_seems_to_be_a_restart():
    """The autopilot seems to have restarted, and has not: it still says that we are in control."""
    rig = Bench()
    rig.actuator.command(0.3)
    rig.settle()
    port = rig.far_end.port
    receive = port.receive
    port.receive = lambda: receive()[:0]
    rig.clock.sleep(4.0)
    port.receive = receive
    rig.clock.sleep(0.5)
    with pytest.raises(ActuatorFault, match="has restarted: control is lost"):
        rig.actuator.rearm()
    assert rig.primary == PAYLOAD
    rig.actuator.release_control()
    rig.clock.sleep(2.0)
    assert rig.primary == FREE


def test_control_is_kept_and_given_back_by_a_payload_that_was_held_up():
    """What the autopilot has said meanwhile waits to be read."""
    rig = Bench()
    rig.actuator.command(0.3)
    rig.settle()
    rig.cancel()
    rig.clock.sleep(4.0)
    rig.clock.every(QUANTUM, lambda: rig.actuator.poll(rig.clock.now()))
    rig.clock.sleep(0.5)
    assert rig.state.healthy
    assert rig.primary == PAYLOAD
    rig.actuator.release_control()
    rig.clock.sleep(2.0)
    assert rig.primary == FREE


def test_control_of_a_gimbal_that_has_not_been_heard_since_it_was_taken_is_given_back(rig):
    rig.device.mute = True
    rig.clock.sleep(1.0)
    rig.actuator.take_control()
    rig.clock.sleep(2.0)
    assert rig.primary == PAYLOAD
    rig.actuator.release_control()
    rig.clock.sleep(1.0)
    assert rig.primary == FREE


@pytest.mark.parametrize("moved", [0.3, 0.8, 1.5])
def test_control_is_given_back_also_of_a_gimbal_that_is_silent_since_an_outage_in_a_move(rig, moved):
    """Nothing is sent to it after the outage, and its plan to brake is put off for as long."""
    rig.actuator.take_control()
    rig.actuator.command(2.5)
    rig.clock.sleep(moved)
    port = rig.far_end.port
    send, receive = port.send, port.receive
    port.send, port.receive = lambda message: None, lambda: receive() and []
    rig.clock.sleep(0.6)
    port.send, port.receive = send, receive
    rig.device.mute = True
    rig.clock.sleep(0.5)
    rig.actuator.release_control()
    rig.clock.sleep(2.0)
    assert rig.primary == FREE


@pytest.mark.parametrize("moved", [0.3, 3.0])
@pytest.mark.parametrize("mute", [1.0, 5.0])
def test_control_is_given_back_also_while_nothing_is_heard_of_the_gimbal_itself(mute, moved):
    rig = Bench()
    rig.actuator.take_control()
    rig.actuator.command(0.4)
    rig.clock.sleep(moved)
    rig.device.mute = True
    rig.clock.sleep(mute)
    rig.actuator.release_control()
    rig.clock.sleep(4.0)
    assert rig.primary == FREE


@pytest.mark.parametrize("outage", [2.5, 6.0])
def test_control_is_given_back_after_an_outage_of_the_link_in_which_a_task_ended(outage):
    rig = Bench()
    rig.actuator.command(0.3)
    rig.settle()
    port = rig.far_end.port
    send, receive = port.send, port.receive
    port.send, port.receive = (lambda message: None), (lambda: receive()[:0])
    rig.actuator.release_control()
    rig.clock.sleep(outage)
    assert rig.primary == PAYLOAD
    port.send, port.receive = send, receive
    rig.clock.sleep(2.5)
    assert rig.primary == FREE


def test_control_that_was_granted_as_the_link_failed_is_given_back_afterwards(rig):
    """The autopilot has put the payload in control, and nobody has heard that, nor that it was released."""
    port = rig.far_end.port
    send, receive = port.send, port.receive
    port.receive = lambda: receive()[:0]
    rig.actuator.command(0.3)
    rig.clock.sleep(0.2)
    port.send = lambda message: None
    rig.clock.sleep(2.5)
    rig.actuator.release_control()
    rig.clock.sleep(6.0)
    assert rig.primary == PAYLOAD
    port.send, port.receive = send, receive
    rig.clock.sleep(2.5)
    assert rig.primary == FREE


def test_control_that_a_killed_payload_has_left_behind_is_given_back(rig):
    """The first that the autopilot tells of control: later on it would be another program with our ids."""
    rig.far_end.autopilot.take_control(PAYLOAD)
    assert rig.sent(3.0).count(CONFIGURE) < 3
    assert rig.primary == FREE
    rig.clock.sleep(1.0)
    rig.far_end.autopilot.take_control(PAYLOAD)
    assert CONFIGURE not in rig.sent(3.0)
