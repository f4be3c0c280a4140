"""Reports that come a few times a second, as over a radio or from a servo that is set so: they are no outages."""

from __future__ import annotations

import math
from collections import deque
from typing import Any

import numpy as np
import pytest

from examples import in_soak
from rigs import ACCELERATION, Rig, rig_of
from ross_payload.interfaces import Clock, Port
from ross_sim.clock import QUANTUM
from ross_sim.devices import servo_node
from ross_sim.devices.far_end import Fault

pytestmark = pytest.mark.lockstep

LED = ["mavlink_gimbal", "dronecan_servo", "vehicle_yaw", "vehicle_yaw:offboard"]
LED_TOO = in_soak("mavlink_gimbal:manager", "dronecan_servo:gimbal")
REPORTS = ("GIMBAL_DEVICE_ATTITUDE_STATUS", "ATTITUDE", "ATTITUDE_QUATERNION")


class SeldomReports:
    """A port over which one attitude comes in a while."""

    def __init__(self, port: Port, clock: Clock, period: float) -> None:
        self._port, self._clock, self._period = port, clock, period
        self._due = 0.0
        self.send, self.close = port.send, port.close

    def receive(self) -> list[Any]:
        return [frame for frame in self._port.receive() if self._passes(frame)]

    def _passes(self, frame: Any) -> bool:
        packet, now = getattr(frame, "packet", None), self._clock.now()
        if packet is None or packet.name not in REPORTS:
            return True
        passes = now >= self._due - QUANTUM / 2
        self._due = now + self._period if passes else self._due
        return passes


def rig_that_reports_every(period: float, led: str, monkeypatch: pytest.MonkeyPatch) -> Rig:
    monkeypatch.setattr(servo_node, "REPORT", period)
    rig = rig_of(led).open()
    rig.wire.plug(SeldomReports(rig.far_end.port, rig.clock, period))
    rig.clock.sleep(3.0)
    return rig


def angles_over(rig: Rig, quanta: int) -> list[float]:
    """Let time pass; where it truly is after every quantum [rad]."""
    angles = []
    for _ in range(quanta):
        rig.clock.sleep(QUANTUM)
        angles.append(rig.far_end.angle())
    return angles


def turned_back(angles: list[float]) -> float:
    """How far it turned back from the farthest angle before [rad]."""
    return float(np.max(np.maximum.accumulate(angles) - angles))


def braking(angles: list[float]) -> float:
    """The greatest deceleration within 50 ms [rad/s^2]."""
    speeds = np.diff(angles) / QUANTUM
    return float(max(speeds[:-5] - speeds[5:]) / (5 * QUANTUM))


@pytest.mark.parametrize("period", [0.2, *in_soak(0.33)])
@pytest.mark.parametrize("led", [*LED, *LED_TOO])
def test_what_does_not_follow_is_found(led: str, period: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """No report begins its turn again and again where it is."""
    rig = rig_that_reports_every(period, led, monkeypatch)
    rig.actuator.command(rig.upper)
    rig.clock.sleep(0.3)
    rig.far_end.afflict(Fault.STALL if led.startswith("vehicle") else Fault.STUCK, on=True)
    rig.clock.sleep(3.0)
    assert "does not follow" in rig.state.fault


@pytest.mark.parametrize("led", ["mavlink_gimbal", *in_soak("mavlink_gimbal:manager")])
def test_what_does_not_follow_is_found_through_outages_as_well(led: str) -> None:
    rig = rig_of(led).open()
    rig.actuator.command(rig.upper)
    rig.clock.sleep(0.3)
    rig.far_end.afflict(Fault.STUCK, on=True)
    for _ in range(6):
        for rig.wire.severed, duration in ((True, 0.2), (False, 0.3)):
            rig.clock.sleep(duration)
    assert "does not follow" in rig.state.fault


@pytest.mark.parametrize("period", [0.2, *in_soak(0.33)])
@pytest.mark.parametrize("led", [*LED, *LED_TOO])
def test_a_turn_takes_no_longer(led: str, period: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """A vehicle that lags by a third of a second is not behind its plan."""
    times = []
    for each in (0.02, period):
        rig = rig_that_reports_every(each, led, monkeypatch)
        rig.actuator.command(rig.upper - 0.1)
        times.append(rig.settle(within=8.0))
    assert times[1] <= times[0] + 2 * period


@pytest.mark.parametrize("period", [0.2, *in_soak(0.33)])
@pytest.mark.parametrize("led", [*LED, *LED_TOO])
def test_what_is_stopped_settles_and_stays_settled(led: str, period: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """No report begins its stop again and again where it is."""
    rig = rig_that_reports_every(period, led, monkeypatch)
    rig.actuator.command(rig.upper)
    rig.clock.sleep(0.8)
    rig.actuator.stop()
    rig.settle(within=2.0)
    for _ in range(200):
        rig.clock.sleep(QUANTUM)
        assert rig.state.settled


@pytest.mark.parametrize("led", ["mavlink_gimbal", *in_soak("mavlink_gimbal:manager")])
def test_a_gimbal_that_is_stopped_while_it_catches_up_goes_no_farther_than_its_plan(
    led: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is faster than its plan then, and would brake from there for longer."""
    rig = rig_that_reports_every(0.4, led, monkeypatch)
    rig.clock.sleep(0.2)  # a report comes while it catches up
    rig.actuator.command(rig.upper)
    for rig.wire.severed, duration in ((False, 0.1), (True, 0.3), (False, 0.1)):
        rig.clock.sleep(duration)
    rig.actuator.stop()
    rig.clock.sleep(3.0)
    assert rig.far_end.angle() <= 1.2 * ACCELERATION * 0.5**2  # to the stop half of it


@pytest.mark.parametrize("begin", [0.94, *in_soak(0.98, 1.14)])
@pytest.mark.parametrize("led", ["mavlink_gimbal", *in_soak("mavlink_gimbal:manager")])
def test_a_gimbal_that_brakes_while_it_is_not_heard_is_led_no_farther(
    led: str, begin: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It has got its set-points: to brake from where its report was, at the speed of then, would lead on beyond."""
    rig = rig_that_reports_every(0.2, led, monkeypatch)
    rig.actuator.command(2.0)
    angles = []
    for rig.wire.cut, duration in ((False, begin), (True, 0.3), (False, 3.0)):
        angles += angles_over(rig, round(duration / QUANTUM))
    assert "for more than 0.45 s" in rig.state.fault
    assert max(angles) <= 2.0
    assert turned_back(angles) <= math.radians(1)


@pytest.mark.parametrize("period", [0.2, *in_soak(0.33)])
@pytest.mark.parametrize("led", ["dronecan_servo", *in_soak("dronecan_servo:gimbal", "dronecan_servo:model")])
def test_a_servo_that_is_stopped_decelerates(led: str, period: float, monkeypatch: pytest.MonkeyPatch) -> None:
    rig = rig_that_reports_every(period, led, monkeypatch)
    rig.actuator.command(rig.upper)
    rig.clock.sleep(0.5)
    rig.actuator.stop()
    assert braking(angles_over(rig, 150)) <= 1.5 * ACCELERATION


class LateReports:
    """A port over which all comes a while later."""

    def __init__(self, port: Port, clock: Clock, late: float) -> None:
        self._port, self._clock, self._late = port, clock, late
        self._under_way: deque[tuple[float, Any]] = deque()
        self.send, self.close = port.send, port.close

    def receive(self) -> list[Any]:
        now = self._clock.now()
        self._under_way.extend((now + self._late, frame) for frame in self._port.receive())
        come = [frame for due, frame in self._under_way if due <= now + QUANTUM / 2]
        for _ in come:
            self._under_way.popleft()
        return come


@pytest.mark.parametrize("period", [0.16, 0.33, *in_soak(0.2)])
@pytest.mark.parametrize("led", ["dronecan_servo", *in_soak("dronecan_servo:gimbal")])
def test_a_servo_that_reports_late_is_not_turned_back_by_a_stop(
    led: str, period: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It reports where it was, on the way that it was told to go."""
    monkeypatch.setattr(servo_node, "REPORT", period)
    rig = rig_of(led).open()
    rig.wire.plug(LateReports(rig.far_end.port, rig.clock, 0.15))
    rig.clock.sleep(3.0)
    rig.actuator.command(rig.upper)
    rig.clock.sleep(0.8)
    rig.actuator.stop()
    assert turned_back(angles_over(rig, 250)) <= math.radians(1)
    assert rig.state.healthy


@pytest.mark.parametrize("period", [0.33, *in_soak(0.4)])
def test_a_servo_without_a_position_is_not_let_go_when_it_is_stopped(
    period: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    rig = rig_that_reports_every(period, "dronecan_servo:model", monkeypatch)
    for _ in range(6):  # stops at different times between two reports
        rig.actuator.command(rig.upper)
        rig.clock.sleep(0.83)
        rig.actuator.stop()
        rig.clock.sleep(1.51)
        assert rig.state.healthy, rig.state.fault
        assert rig.state.homed
        rig.actuator.rearm()
        rig.actuator.command(0.0)
        rig.clock.sleep(4.0)


@pytest.mark.parametrize("begun", [0.3, *in_soak(0.2, 0.4)])
@pytest.mark.parametrize(
    "led", ["mavlink_gimbal:manager", "dronecan_servo", *in_soak("mavlink_gimbal", "dronecan_servo:gimbal")]
)
def test_what_reports_late_is_not_turned_back_by_a_stop_soon_after_the_turn_began(led: str, begun: float) -> None:
    """By its reports it is far behind its plan and slow, as what gets no set-points."""
    rig = rig_of(led)
    rig.wire.plug(LateReports(rig.far_end.port, rig.clock, 0.2))
    rig.open().clock.sleep(3.0)
    rig.actuator.command(rig.upper)
    rig.clock.sleep(begun)
    rig.actuator.stop()
    assert turned_back(angles_over(rig, 250)) <= math.radians(1)


class WrongRates:
    """A port over which a gimbal reports no rate, or one in the wrong sense, and obeys a while later."""

    def __init__(self, port: Port, clock: Clock, factor: float, late: float = 0.1) -> None:
        self._port, self._clock, self._factor, self._late = port, clock, factor, late
        self._under_way: deque[tuple[float, Any]] = deque()
        self.close = port.close

    def send(self, frame: Any) -> None:
        self._under_way.append((self._clock.now() + self._late, frame))

    def receive(self) -> list[Any]:
        while self._under_way and self._under_way[0][0] <= self._clock.now() + QUANTUM / 2:
            self._port.send(self._under_way.popleft()[1])
        arrived = self._port.receive()
        for frame in arrived:
            if frame.packet.name in REPORTS[:1]:
                frame.packet.message.angular_velocity_z *= self._factor
        return arrived


@pytest.mark.parametrize("factor", [0.0, -1.0])
@pytest.mark.parametrize("led", ["mavlink_gimbal", *in_soak("mavlink_gimbal:manager")])
def test_a_gimbal_that_reports_no_rate_or_a_wrong_one_decelerates_on_a_stop(led: str, factor: float) -> None:
    """It lags, and by its rate it does not turn."""
    rig = rig_of(led).open()
    rig.wire.plug(WrongRates(rig.far_end.port, rig.clock, factor))
    rig.clock.sleep(1.0)
    rig.actuator.command(rig.upper)
    rig.clock.sleep(1.2)
    rig.actuator.stop()
    angles = angles_over(rig, 300)
    assert braking(angles) <= 1.3 * ACCELERATION
    assert rig.state.settled, rig.state.fault
