"""The driver of a DroneCAN servo and what it is told: positions that cannot be, none at all, gears, gimbals."""

import math

import pytest

from can_servo_bench import SERVO, Rig
from examples import in_soak, rows_in_soak
from ross_payload.errors import ActuatorFault
from ross_protocols.dronecan.gimbal_messages import GimbalStatus
from ross_protocols.dronecan.messages import NodeStatus, Status
from ross_protocols.dronecan.node_messages import Decoder, Encoder
from ross_sim.clock import QUANTUM

MODEL = {"feedback": "model"}
GIMBAL = {"command": "gimbal"}


# ------------------------------------------------------------------------------------------ what the servo says


class Liar:
    """Puts other positions into the reports of the servo."""

    def __init__(self, port, position):
        self._port, self._position = port, position
        self.lies = False

    def receive(self):
        heard, ear, mouth = [], Decoder(0), Encoder(SERVO)
        for frame in self._port.receive():
            received = ear.feed(frame)
            if received and isinstance(received.message, Status | GimbalStatus) and self.lies:
                heard += mouth.broadcast(Status(1, self._position))
            elif (received and isinstance(received.message, NodeStatus)) or not self.lies:
                heard.append(frame)
        return heard

    def send(self, frame):
        self._port.send(frame)

    def close(self):
        self._port.close()


@pytest.mark.parametrize(
    ("position", "words"),
    [
        (math.nan, "reports no position"),
        (math.inf, "reports no position"),
        (65504.0, "reports 3.7531e+06 deg, which is outside its travel"),
        (-4.5, "outside its travel"),
    ],
)
@pytest.mark.parametrize("moving", [True, *in_soak(False)])
def test_an_absurd_position_is_one_line_and_no_motion(position, words, moving):
    wires = []
    rig = Rig(wrap=lambda port: wires.append(Liar(port, position)) or wires[0])
    if moving:
        rig.go(150, 0.8)
    here, wires[0].lies = rig.true_deg, True
    rig.clock.sleep(0.1)
    assert words in rig.state.fault
    assert "\n" not in rig.state.fault
    rig.clock.sleep(3.0)
    assert abs(rig.true_deg - here) < 60  # braking
    assert rig.node.shaft.rate == 0.0
    assert math.isfinite(rig.state.angle)
    with pytest.raises(ActuatorFault):
        rig.go(10)
    rig.actuator.home()
    rig.clock.sleep(0.1)
    assert rig.node.shaft.rate == 0.0
    assert all(math.isfinite(value) for value in rig.values())


def test_a_servo_that_sends_no_status_says_what_to_configure():
    rig = Rig()
    rig.node._next_report = math.inf
    rig.clock.sleep(3.0)
    fault = "node 50 is online but sends no Status of actuator 1; set feedback = 'model' if it never does"
    assert rig.state.fault == fault
    with pytest.raises(ActuatorFault, match="is online but sends no Status"):
        rig.go(10)


def test_a_servo_with_another_actuator_id_is_not_taken_for_ours():
    rig = Rig(actuator_id=2)
    rig.node._options = rig.options.model_copy(update={"actuator_id": 3})
    rig.clock.sleep(3.0)
    assert "sends no Status of actuator 2" in rig.state.fault
    assert not rig.state.settled


def test_a_servo_that_only_beats_is_turned_by_a_model_with_a_slow_watchdog():
    rig = Rig(guard={"watchdog_s": 2.5}, **MODEL)
    rig.node._next_report = math.inf
    rig.actuator.home()
    rig.clock.sleep(3.0)
    rig.go(90, 4.0)
    assert rig.state.settled
    assert rig.true_deg == pytest.approx(90, abs=0.25)
    rig.node.silent = True
    rig.go(0, 3.0)
    assert "no report for 2.5" in rig.state.fault


def test_a_model_stays_unknown_when_its_homing_is_cut_off():
    rig = Rig(**MODEL)
    rig.clock.sleep(2.0)
    rig.actuator.home()
    rig.clock.sleep(0.1)
    rig.node.restart()
    rig.clock.sleep(4.0)
    assert not rig.state.homed
    assert "restarted" in rig.state.fault


# ------------------------------------------------------------------------------------------ gimbals and gears


def test_a_gimbal_is_turned_beyond_half_a_turn_and_back():
    rig = Rig(**GIMBAL)
    for goal in (190, -190, 0):
        rig.go(goal, 6.0)
        assert rig.state.settled
        assert rig.true_deg == pytest.approx(goal, abs=0.25)
        assert math.degrees(rig.state.angle) == pytest.approx(goal, abs=0.25)


def test_a_gimbal_that_is_opened_again_beyond_half_a_turn_is_where_it_was():
    """Else it would go on in the same direction, beyond its limits."""
    rig = Rig(**GIMBAL)
    rig.go(195, 6.0)
    rig.actuator.__exit__(None, None, None)
    rig.clock.sleep(1.0)
    rig.actuator.__enter__()
    rig.clock.sleep(0.2)
    assert math.degrees(rig.state.angle) == pytest.approx(195, abs=0.25)
    rig.go(50, 4.0)
    assert rig.true_deg == pytest.approx(50, abs=0.25)


def test_a_gimbal_that_was_turned_by_hand_while_it_was_closed_is_inside_its_travel():
    """The nearest turn to where it was would be 370 degrees, a fault until the payload is restarted."""
    rig = Rig(**GIMBAL)
    rig.go(195, 6.0)
    rig.actuator.__exit__(None, None, None)
    rig.far_end.port.receive()
    rig.actuator.__enter__()
    rig.far_end.port.receive = lambda: Encoder(SERVO).broadcast(GimbalStatus(0, math.radians(10)))
    rig.clock.sleep(QUANTUM)
    assert "outside its travel" not in rig.state.fault
    assert math.degrees(rig.state.angle) == pytest.approx(10, abs=0.25)


def test_a_gimbal_that_once_reports_no_attitude_is_on_the_same_turn_afterwards():
    rig = Rig(**GIMBAL)
    rig.go(195, 6.0)
    rig.say(SERVO, GimbalStatus(0, math.nan))
    rig.clock.sleep(0.1)
    assert math.degrees(rig.state.angle) == pytest.approx(195, abs=0.25)


def test_a_gimbal_that_hangs_upside_down_turns_the_other_way():
    rig = Rig(gear_ratio=-1, zero_position_deg=30, **GIMBAL)
    rig.go(40, 3.0)
    assert math.degrees(rig.values()[-1]) == pytest.approx(-10, abs=0.1)
    assert rig.true_deg == pytest.approx(40, abs=0.25)


@pytest.mark.parametrize(
    ("gear", "command"),
    [
        (-5.0, "unitless"),
        *rows_in_soak((5.0, "position"), (-5.0, "position"), (5.0, "unitless")),
    ],
)
def test_a_gear_makes_the_servo_turn_many_times(gear, command):
    rig = Rig(gear_ratio=gear, command=command, max_speed_deg_s=60)  # 300 deg/s of the servo
    for goal in (200, -200, 33):
        rig.go(goal, 9.0)
        assert rig.state.settled, rig.state
        tolerance = math.degrees(rig.options.resolution)
        assert rig.true_deg == pytest.approx(goal, abs=2 * tolerance)
        assert math.degrees(rig.node.shaft.angle) == pytest.approx(goal * gear, abs=2 * tolerance * abs(gear))
