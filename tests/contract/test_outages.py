"""An outage of the wire, in both directions: what is led by set-points comes to rest, and is not led on afterwards."""

from __future__ import annotations

import math

import pytest

from examples import in_soak, rows_in_soak
from rigs import ACCELERATION, SWING, rig_of
from ross_sim.clock import QUANTUM
from ross_sim.devices import servo_node

pytestmark = pytest.mark.lockstep

LED = ("mavlink_gimbal", "dronecan_servo", "dronecan_servo:model", "vehicle_yaw:offboard")  # by set-points
LED_TOO = ("mavlink_gimbal:manager", "dronecan_servo:gimbal", "vehicle_yaw")
WATCHDOG = 0.5  # of the guard [s]


@pytest.mark.parametrize(
    ("stopped", "outage", "rate"),
    [
        (-0.05, 0.7, 0.8),
        (0.2, 0.25, None),
        (0.35, 0.7, None),
        (0.3, 0.3, 0.8),  # in the moment in which it is heard again, at one of two reports
        (0.31, 0.31, 0.8),
        *rows_in_soak((-0.05, 0.7, None), (0.35, 0.42, None), (0.35, 3.0, None), (-0.05, 3.0, 0.8)),
    ],
)
@pytest.mark.parametrize("led", [*LED, *in_soak(*LED_TOO)])
def test_a_stop_around_an_outage_of_the_wire_is_not_made_up_for_when_it_is_over(
    led: str, stopped: float, outage: float, rate: float | None
) -> None:
    """What got no set-points has come to rest at the last one: the plan to brake has gone on without it."""
    if led == "dronecan_servo:model" and outage < WATCHDOG and stopped < 0.3:
        return  # nobody has noticed by then, and it tells no position
    if led.startswith("dronecan_servo") and stopped == outage:
        return  # a set-point goes out before its report comes
    rig = rig_of(led).open()
    rig.actuator.command(rig.upper, rate)
    rig.clock.sleep(0.8 + min(stopped, 0.0))
    if stopped < 0.0:
        rig.actuator.stop()
        rig.clock.sleep(-stopped)
    rig.wire.severed = True
    if stopped > 0.0:
        rig.clock.sleep(stopped - QUANTUM)
        before = rig.far_end.angle()
        rig.clock.sleep(QUANTUM)
        rig.actuator.stop()
    if stopped != outage:
        rig.clock.sleep(outage - max(stopped, 0.0) - QUANTUM)
        before = rig.far_end.angle()
        rig.clock.sleep(QUANTUM)
    here = rig.far_end.angle()
    speed = abs(here - before) / QUANTUM
    rig.wire.severed = False
    rig.clock.sleep(3.0)
    allowed = speed**2 / (2 * ACCELERATION) + 0.1 * (speed + ACCELERATION * 0.05) + rig.late * speed + SWING
    assert abs(rig.far_end.angle() - here) <= allowed
    rig.actuator.__exit__(None, None, None)


@pytest.mark.parametrize(
    ("led", "stopped", "outage"),
    [
        ("mavlink_gimbal", -0.05, 0.7),
        ("mavlink_gimbal", 0.2, 0.35),
        ("dronecan_servo", -0.05, 0.2),
        ("dronecan_servo", 0.02, 0.25),
        *rows_in_soak(("mavlink_gimbal", 0.3, 0.35), ("mavlink_gimbal", 0.35, 3.0), ("dronecan_servo", 0.35, 3.0)),
        *rows_in_soak(("mavlink_gimbal:manager", 0.2, 0.35), ("dronecan_servo:gimbal", 0.02, 0.25)),
        *rows_in_soak(("vehicle_yaw", 0.2, 0.35), ("vehicle_yaw:offboard", 0.2, 0.35)),
    ],
)
def test_a_stop_in_an_outage_of_set_points_alone_is_one_too(led: str, stopped: float, outage: float) -> None:
    """The reports go on, and tell that it rests far behind its plan to brake, which must not lead it on afterwards."""
    rig = rig_of(led).open()
    rig.actuator.command(rig.upper)
    rig.clock.sleep(0.8 + min(stopped, 0.0))
    if stopped < 0.0:
        rig.actuator.stop()
        rig.clock.sleep(-stopped)
    rig.wire.one_way = True
    if stopped > 0.0:
        rig.clock.sleep(stopped)
        rig.actuator.stop()
    rig.clock.sleep(outage - max(stopped, 0.0) - QUANTUM)
    before = rig.far_end.angle()
    rig.clock.sleep(QUANTUM)
    here = rig.far_end.angle()
    speed = abs(here - before) / QUANTUM
    rig.wire.one_way = False
    rig.clock.sleep(3.0)
    assert abs(rig.far_end.angle() - here) <= speed**2 / (2 * ACCELERATION) + rig.late * speed + math.radians(4)
    assert rig.state.settled or "does not follow" in rig.state.fault
    rig.actuator.__exit__(None, None, None)


@pytest.mark.parametrize("led", ["mavlink_gimbal", "dronecan_servo", *in_soak(*LED_TOO)])
def test_closing_after_an_outage_of_set_points_alone_leads_nothing_on(led: str) -> None:
    rig = rig_of(led).open()
    rig.actuator.command(rig.upper)
    rig.clock.sleep(0.8)
    rig.wire.one_way = True
    rig.clock.sleep(0.4)
    rig.wire.one_way = False
    here = rig.far_end.angle()
    rig.actuator.__exit__(None, None, None)
    rig.clock.sleep(3.0)
    assert rig.far_end.angle() - here < math.radians(15)


@pytest.mark.parametrize("stopped", [0.05, 0.38])
@pytest.mark.parametrize("led", ["dronecan_servo", *in_soak("dronecan_servo:gimbal")])
def test_a_servo_that_is_to_brake_gets_no_set_points_before_it_is_heard_again(
    led: str, stopped: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They would lead it on at its own speed until its first report, also while it says no more than that it lives."""
    monkeypatch.setattr(servo_node, "REPORT", 0.1)
    rig = rig_of(led).open()
    rig.actuator.command(rig.upper)
    rig.clock.sleep(0.83)
    rig.wire.severed = True
    rig.clock.sleep(stopped)
    rig.actuator.stop()
    rig.clock.sleep(0.4 - stopped)
    here = rig.far_end.angle()
    rig.wire.severed = False
    rig.clock.sleep(0.09)
    assert rig.far_end.angle() == pytest.approx(here, abs=SWING)
    rig.clock.sleep(3.0)
    assert rig.far_end.angle() == pytest.approx(here, abs=SWING)
    rig.actuator.__exit__(None, None, None)


@pytest.mark.parametrize(("stopped", "held_up"), [(0.05, 0.35), *rows_in_soak((0.05, 0.2), (0.3, 0.35), (0.12, 0.1))])
@pytest.mark.parametrize("led", ["dronecan_servo", "dronecan_servo:model", *in_soak("dronecan_servo:gimbal")])
def test_a_servo_stopped_in_an_outage_in_which_the_payload_was_held_up_is_not_led_on(
    led: str, stopped: float, held_up: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After the pause it rests at its last set-point, as far as is known; it may not have got it."""
    monkeypatch.setattr(servo_node, "REPORT", 0.1)
    rig = rig_of(led).open()
    rig.actuator.command(rig.upper)
    rig.clock.sleep(0.83)
    rig.wire.severed = True
    begin, pause = rig.clock.now(), lambda: rig.pause(0.2)
    for time, do in sorted([(stopped, rig.actuator.stop), (held_up, pause)], key=lambda row: row[0]):
        rig.clock.sleep(max(begin + time - rig.clock.now(), 0.0))
        do()
    rig.clock.sleep(begin + 0.65 - rig.clock.now())
    here = rig.far_end.angle()
    rig.wire.severed = False
    for _ in range(300):
        rig.clock.sleep(QUANTUM)
        assert rig.far_end.angle() == pytest.approx(here, abs=SWING)
    rig.actuator.__exit__(None, None, None)


@pytest.mark.parametrize("led", ["mavlink_gimbal", "dronecan_servo", "vehicle_yaw:offboard"])
def test_a_stop_in_an_outage_in_which_the_plan_has_come_to_its_end_is_one_too(led: str) -> None:
    rig = rig_of(led).open()
    rig.actuator.command(0.5)
    rig.clock.sleep(0.64)
    rig.wire.severed = True
    rig.clock.sleep(0.4)
    rig.actuator.stop()
    rig.clock.sleep(0.02)
    here = rig.far_end.angle()
    assert here < 0.5 - math.radians(4)
    rig.wire.severed = False
    rig.clock.sleep(3.0)
    assert rig.far_end.angle() == pytest.approx(here, abs=math.radians(2))
    rig.actuator.__exit__(None, None, None)


@pytest.mark.parametrize("outage", [3.0, 1.1])  # the plan to brake, by the guard, is over by then, or is not
@pytest.mark.parametrize("led", ["mavlink_gimbal", "mavlink_gimbal:manager"])
def test_a_gimbal_that_got_no_set_points_gets_none_before_it_is_heard_again(led: str, outage: float) -> None:
    rig = rig_of(led).open()
    rig.actuator.command(rig.upper)
    rig.clock.sleep(0.8)
    rig.wire.severed = rig.wire.cut = True
    rig.clock.sleep(outage)
    here = rig.far_end.angle()
    rig.wire.severed = False
    rig.clock.sleep(0.5)
    assert rig.far_end.angle() == pytest.approx(here, abs=SWING)
    rig.wire.cut = False
    rig.clock.sleep(1.0)
    assert rig.far_end.angle() == pytest.approx(here, abs=SWING)
    rig.actuator.__exit__(None, None, None)


@pytest.mark.parametrize("led", ["mavlink_gimbal", "mavlink_gimbal:manager", "dronecan_servo", "dronecan_servo:model"])
def test_what_rests_at_its_goal_is_held_there_also_while_nothing_is_heard_of_it(
    led: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A gimbal device gives up a manager that is silent for a second, and a servo may let go."""
    rig = rig_of(led).open()
    rig.actuator.command(0.5)
    rig.settle(within=5.0)
    send, sent = rig.wire.send, []
    monkeypatch.setattr(rig.wire, "send", lambda frame: (sent.append(rig.clock.now()), send(frame)))
    rig.wire.cut = True
    rig.clock.sleep(0.5)
    for _ in range(10):
        before = len(sent)
        rig.clock.sleep(0.2)
        assert len(sent) > before
    rig.actuator.__exit__(None, None, None)


@pytest.mark.parametrize("led", [*LED, *in_soak(*LED_TOO)])
def test_a_turn_that_an_outage_of_the_wire_has_ended_does_not_go_on_when_it_is_over(led: str) -> None:
    rig = rig_of(led).open()
    rig.actuator.command(rig.upper)
    rig.clock.sleep(0.8)
    rig.wire.severed = True
    rig.clock.sleep(0.7)
    assert not rig.state.healthy
    here = rig.far_end.angle()
    rig.wire.severed = False
    rig.clock.sleep(3.0)
    assert rig.far_end.angle() - here <= SWING + math.radians(2)
    assert not rig.state.healthy
    rig.actuator.__exit__(None, None, None)
