"""Who turns a gimbal behind an autopilot: the payload while somebody holds it for a task, else whoever wants to."""

import math
from contextlib import suppress

import pytest

from examples import in_soak
from gimbal_rig import CONFIGURE, FREE, GROUND, ITSELF, PAYLOAD, SET_POINT, Bench, after_a_task
from ross_payload.errors import ActuatorFault
from ross_sim.clock import QUANTUM
from ross_sim.devices.far_end import Fault
from ross_sim.devices.gimbal_far_end import GimbalFarEnd


@pytest.fixture
def rig():
    return Bench("client")


@pytest.fixture
def released(rig):
    return after_a_task(rig)


def noticed(rig, within):
    """Wait for a fault that begins at rest."""
    end = rig.clock.now() + within
    while rig.state.healthy:
        assert rig.clock.now() < end, rig.state
        rig.clock.sleep(0.01)


def test_idle_means_no_control_and_no_set_points(rig):
    said = rig.sent(5.0)
    assert SET_POINT not in said
    assert CONFIGURE not in said
    assert rig.primary == FREE
    assert rig.state.healthy
    assert rig.state.settled


@pytest.mark.parametrize("before", ["task", *in_soak("boot")])
def test_a_pilot_reaches_50_degrees_again_and_again_and_the_state_follows(before, request):
    rig = request.getfixturevalue("rig" if before == "boot" else "released")
    for n in range(4):
        rig.point(-50.0 if n % 2 else 50.0)
        for _ in range(200):
            rig.clock.sleep(0.01)
            assert rig.state.healthy, rig.state
            assert rig.state.angle == pytest.approx(rig.far_end.angle(), abs=math.radians(4))
        assert rig.true_deg == pytest.approx(-50.0 if n % 2 else 50.0, abs=1.0)
        assert rig.state.settled
    rig.actuator.command(0.2)
    rig.settle()
    assert rig.far_end.angle() == pytest.approx(0.2, abs=math.radians(0.1))


@pytest.mark.soak
def test_a_burst_of_a_pilot_is_no_fault_and_moves_the_gimbal(rig):
    for n in range(50):
        rig.point(-50.0 if n % 10 < 5 else 50.0)
        rig.clock.sleep(0.2)
        assert rig.state.healthy, rig.state
    rig.clock.sleep(2.0)
    assert rig.true_deg == pytest.approx(-50.0 if 49 % 10 < 5 else 50.0, abs=1.0)


def test_an_order_in_the_middle_of_a_pilots_turn_takes_over_without_a_jump(released):
    released.point(-60.0)
    released.clock.sleep(0.6)
    speed = released.state.rate
    assert speed > 0.5
    released.actuator.command(0.0)
    rates = []
    while not released.state.settled:
        released.clock.sleep(0.01)
        rates.append(released.state.rate)
        assert released.state.healthy
    assert released.primary == PAYLOAD
    assert released.far_end.angle() == pytest.approx(0.0, abs=math.radians(0.1))
    assert max(rates) <= max(speed, *rates[:5]) + 0.1  # it brakes from there on


@pytest.mark.parametrize(("held", "most"), [(True, 0.01), (False, 0.02)])
def test_taking_control_delays_the_first_set_point_by_one_poll(rig, held, most):
    """Where the autopilot answers at once."""
    if held:
        rig.actuator.take_control()
    rig.clock.sleep(1.0)
    begin = rig.clock.now()
    rig.actuator.command(0.5)
    while abs(rig.far_end.autopilot._aim) < 1e-6:
        rig.clock.sleep(0.01)
    assert rig.clock.now() - begin <= most + 0.01 + 1e-9  # and one quantum until the autopilot has it


def test_control_is_held_at_rest_for_as_long_as_a_task_lasts(rig):
    rig.actuator.take_control()
    rig.clock.sleep(15.0)
    assert rig.primary == PAYLOAD
    assert SET_POINT in rig.sent(0.2)


def test_a_rival_in_control_is_no_fault_while_idle_and_stays_until_an_order(released):
    released.configure(ITSELF)
    released.clock.sleep(10.0)
    assert released.primary == GROUND
    assert released.state.healthy
    released.actuator.command(-0.3)
    released.settle()
    assert released.primary == PAYLOAD
    assert released.far_end.angle() == pytest.approx(-0.3, abs=math.radians(0.1))


def lose_control(rig):
    """A pilot takes control in mid-move; the task ends."""
    rig.actuator.command(1.5)
    rig.clock.sleep(0.5)
    rig.configure(ITSELF)
    assert rig.detect(within=0.5) <= 0.5
    assert rig.state.fault.startswith("component 190 of system 255 has taken control of the gimbal")
    rig.actuator.release_control()


def test_a_pilot_who_takes_control_in_a_task_keeps_it_until_the_next_order(rig):
    lose_control(rig)
    assert not {SET_POINT, CONFIGURE} & set(rig.sent(5.0))
    with pytest.raises(ActuatorFault):
        rig.actuator.command(0.0)
    rig.actuator.rearm()
    rig.clock.sleep(5.0)
    assert rig.primary == GROUND
    rig.actuator.command(0.0)
    rig.settle()
    assert rig.primary == PAYLOAD


def test_home_takes_control_back(rig):
    lose_control(rig)
    rig.clock.sleep(2.0)
    rig.actuator.home()
    rig.clock.sleep(1.0)
    rig.actuator.rearm()
    rig.settle()
    assert rig.primary == PAYLOAD


def test_a_pilot_whose_status_is_lost_is_noticed_by_the_next_question(rig):
    rig.actuator.command(0.5)
    rig.settle()
    rig.far_end.autopilot.primary = rig.far_end.autopilot._said_primary = GROUND
    noticed(rig, within=1.2)
    assert "component 190 of system 255 has taken control" in rig.state.fault


def test_an_autopilot_that_reboots_in_a_task_has_forgotten_us_and_is_not_asked_again_before_an_order(rig):
    rig.actuator.command(1.0)
    rig.settle()
    rig.far_end.autopilot.restart(rig.clock.now() - 0.9)  # soon enough for the gimbal to notice nothing
    noticed(rig, within=0.5)
    assert "component 1 of system 1, has restarted: control is lost" in rig.state.fault
    rig.actuator.release_control()
    rig.clock.sleep(5.0)
    assert rig.primary == FREE
    rig.configure(ITSELF)
    rig.clock.sleep(5.0)
    assert rig.primary == GROUND
    rig.actuator.home()
    rig.clock.sleep(1.0)
    rig.actuator.rearm()
    assert rig.primary == PAYLOAD


@pytest.mark.parametrize("up", [2.0, *in_soak(10.0)])
def test_an_autopilot_that_reboots_while_idle_is_no_fault_and_obeys_the_next_order(released, up):
    """Until it looks for its gimbal again, 10 s after it was switched on, the gimbal misses it."""
    released.clock.sleep(up)
    released.far_end.autopilot.restart(released.clock.now())
    released.clock.sleep(8.0)
    assert released.state.fault == "the gimbal reports a failure: no data from its manager"
    released.clock.sleep(4.0)
    assert released.state.healthy, released.state
    assert released.primary == FREE
    released.actuator.command(-0.2)
    released.settle()
    assert released.primary == PAYLOAD


def test_what_was_known_of_control_is_forgotten_after_a_long_silence(rig):
    """A reboot whose clock has caught up with the old one."""
    rig.actuator.command(0.2)
    rig.settle()
    autopilot = rig.far_end.autopilot
    autopilot._up = rig.clock.now() + 4.0
    autopilot.primary = autopilot._said_primary = FREE
    rig.clock.sleep(4.5)
    assert rig.actuator._actuator._driver._peer.primary != PAYLOAD
    assert not rig.state.healthy


def test_a_stop_while_idle_brakes_what_a_pilot_turns_and_takes_no_control(released):
    released.point(-90.0)
    released.clock.sleep(0.7)
    here = released.far_end.angle()
    released.actuator.stop()
    released.clock.sleep(2.0)
    stands = released.far_end.angle()
    assert here < stands < here + math.radians(45)
    assert released.primary == FREE
    assert SET_POINT not in released.sent(1.0)
    assert released.far_end.angle() == pytest.approx(stands, abs=math.radians(0.1))
    with pytest.raises(ActuatorFault, match="re-arm"):
        released.actuator.command(0.0)
    released.point(20.0)  # the pilot may, after that
    released.clock.sleep(3.0)
    assert released.true_deg == pytest.approx(20.0, abs=1.0)
    assert released.state.healthy


def test_a_stop_of_a_gimbal_that_reports_its_rate_in_degrees_does_not_turn_it_to_the_end_of_its_travel(released):
    receive = released.far_end.port.receive

    def in_degrees():
        arrived = receive()
        for each in arrived:
            if each.packet.name == "GIMBAL_DEVICE_ATTITUDE_STATUS":
                each.packet.message.angular_velocity_z *= math.degrees(1)
        return arrived

    released.far_end.port.receive = in_degrees
    released.point(-90.0)
    released.clock.sleep(0.7)
    here = released.far_end.angle()
    released.actuator.stop()
    released.clock.sleep(2.0)
    assert here < released.far_end.angle() < here + math.radians(45)


def test_a_stop_brakes_nothing_that_a_pilot_has_begun_while_the_payload_was_held_up(released):
    """The end of the old braking may be the short way round by now, and beyond the travel."""
    held_up = [False]
    released.cancel()
    released.clock.every(QUANTUM, lambda: held_up[0] or released.actuator.poll(released.clock.now()))
    released.point(-150)
    released.clock.sleep(0.9)
    released.actuator.stop()
    released.clock.sleep(0.05)
    held_up[0] = True
    released.clock.sleep(0.5)
    released.point(60)
    released.clock.sleep(3.0)
    held_up[0] = False
    released.clock.sleep(3.0)
    assert released.true_deg == pytest.approx(60, abs=1)


def test_a_halt_while_idle_leaves_a_pilots_turn_alone(released):
    released.point(-90.0)
    released.clock.sleep(0.7)
    released.actuator.halt()
    assert SET_POINT not in released.sent(3.0)
    assert released.true_deg == pytest.approx(-90.0, abs=1.0)


def test_a_stop_before_control_is_given_drops_the_order(rig):
    rig.actuator.command(1.0)
    rig.actuator.stop()
    rig.clock.sleep(3.0)
    assert rig.far_end.angle() == pytest.approx(0.0, abs=math.radians(0.1))
    assert rig.state.healthy


def test_a_gimbal_that_falls_silent_while_idle_is_told_and_is_well_again_by_itself(released):
    released.far_end.afflict(Fault.SILENT)
    noticed(released, within=0.7)
    assert released.state.fault.startswith("no attitude received from the gimbal")
    released.clock.sleep(3.0)
    released.far_end.afflict(Fault.SILENT, on=False)
    released.clock.sleep(0.5)
    assert released.state.healthy
    released.actuator.command(0.0)
    released.settle()


def test_an_autopilot_that_falls_silent_is_named(rig):
    rig.actuator.command(1.5)
    rig.clock.sleep(0.5)
    rig.far_end.autopilot._up = math.inf
    rig.device.mute = True  # its reports come by way of the autopilot
    assert rig.detect(within=0.6) <= 0.6
    assert rig.state.fault.startswith("no data from the autopilot")


@pytest.mark.parametrize("later", [0.0, 1.2, 1.21, *in_soak(1.19, 1.22, 1.24, 1.4)])
def test_home_about_when_the_autopilot_is_thawed_goes_on_from_where_the_gimbal_stands(rig, later):
    """The set-points of the time when it was frozen never arrived."""
    rig.actuator.command(1.5)
    rig.clock.sleep(0.5)
    rig.far_end.autopilot._up = rig.clock.now() + 1.5
    rig.device.mute = True
    rig.detect(within=0.6)
    begin = rig.clock.now()
    rig.clock.sleep(min(later, 1.2))
    if later >= 1.2:
        rig.device.mute = False
        rig.clock.sleep(later - 1.2)
    rig.actuator.home()
    rig.clock.sleep(max(begin + 1.2 - rig.clock.now(), 0.0))
    rig.device.mute = False
    rig.clock.sleep(3.0)
    rig.actuator.rearm()
    rig.actuator.command(0.3)
    rig.settle()


def test_as_a_manager_of_a_bare_gimbal_it_holds_it_all_the_time():
    rig = Bench("manager", autopilot=False)
    rig.actuator.command(0.3)
    rig.settle()
    rig.actuator.release_control()
    assert "GIMBAL_DEVICE_SET_ATTITUDE" in rig.sent(0.5)
    assert rig.state.healthy
    assert rig.state.settled


class FrozenFarEnd(GimbalFarEnd):
    """Gimbal and autopilot in one process that may be frozen: later it makes up for the time, and then reads on."""

    lived, frozen = 0.0, False

    def advance(self, now):
        if self.frozen:
            return
        waiting, behind = self.port.sent, now - self.lived > 0.02
        self.lived = min(self.lived + 0.1, now)
        self.port.sent = [] if behind else waiting
        super().advance(self.lived)
        self.port.sent = waiting if behind else self.port.sent


def test_a_process_that_is_thawed_in_mid_move_and_brought_home_at_once_is_not_said_to_lag(monkeypatch):
    """The reports of the time when it was frozen come one after another, the first of them of a gimbal that turns."""
    monkeypatch.setattr("gimbal_rig.GimbalFarEnd", FrozenFarEnd)
    rig = Bench("client")
    rig.actuator.command(1.5)
    rig.clock.sleep(0.6)
    rig.far_end.frozen = True
    rig.detect(within=0.6)
    rig.far_end.frozen = False
    stood = rig.far_end.angle()
    rig.actuator.home()
    rig.clock.sleep(1.0)
    rig.actuator.rearm()
    assert rig.far_end.angle() == pytest.approx(stood, abs=math.radians(8))
    rig.actuator.command(0.3)
    rig.settle()


def test_a_goal_that_is_given_while_reports_come_again_is_reached(monkeypatch):
    monkeypatch.setattr("gimbal_rig.GimbalFarEnd", FrozenFarEnd)
    rig = Bench("client")
    rig.actuator.command(0.5)
    rig.settle()
    rig.far_end.frozen = True
    noticed(rig, within=0.7)
    rig.far_end.frozen = False
    while not rig.actuator.state().healthy:
        rig.clock.sleep(0.01)
        with suppress(ActuatorFault):
            rig.actuator.rearm()
    rig.actuator.command(0.3)
    rig.settle()
    assert rig.far_end.angle() == pytest.approx(0.3, abs=math.radians(0.2))


@pytest.mark.parametrize("stopped", [True, False])
def test_a_bare_gimbal_that_was_without_power_is_not_turned_back_to_where_it_was(stopped):
    """Somebody may have turned it by hand meanwhile, and still have the hand there."""
    rig = Bench("manager", autopilot=False)
    rig.clock.sleep(1.0)
    rig.actuator.command(0.8)
    rig.settle()
    if stopped:
        rig.actuator.stop()
    rig.clock.sleep(1.0)
    wire, rig.far_end.port.send = rig.far_end.port, lambda message: None
    receive, wire.receive = wire.receive, lambda: receive() and []
    rig.clock.sleep(4.0)
    rig.device.angle = -0.4
    rig.device.restart()
    del wire.send, wire.receive
    for _ in range(300):
        rig.clock.sleep(QUANTUM)
        assert rig.far_end.angle() == pytest.approx(-0.4, abs=math.radians(0.5))
    assert rig.state.angle == pytest.approx(-0.4, abs=math.radians(0.5))


def test_a_bare_gimbal_that_still_speaks_is_held_also_while_its_attitudes_are_missing():
    """Its heartbeats tell that it has power, and it gives up a manager that is silent for a second."""
    rig = Bench("manager", autopilot=False)
    rig.clock.sleep(1.0)
    rig.actuator.command(0.8)
    rig.settle()
    receive = rig.far_end.port.receive
    rig.far_end.port.receive = lambda: [each for each in receive() if each.packet.name == "HEARTBEAT"]
    for _ in range(8):
        rig.clock.sleep(1.0)
        assert "GIMBAL_DEVICE_SET_ATTITUDE" in rig.sent(0.5)
