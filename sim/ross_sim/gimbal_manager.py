"""A simulated gimbal manager: what an ArduPilot with MNT1_TYPE 6 does with gimbal commands."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from ross_protocols import gimbal, vehicle
from ross_protocols.codec import Packet
from ross_protocols.dialect import common
from ross_protocols.gimbal import Address
from ross_protocols.pairs import clockwise
from ross_protocols.vehicle import VehicleAttitude
from ross_sim.gimbal_device import EARLY, Servo

HEARTBEAT, ATTITUDE, SET_ATTITUDE = 0, 30, 284  # message ids
PERIODS = {HEARTBEAT: 1.0, ATTITUDE: 0.04, SET_ATTITUDE: 0.02}  # [s]
ADJUSTABLE = (gimbal.MANAGER_STATUS, gimbal.DEVICE_ATTITUDE, ATTITUDE)
DEVICE_ID = 1  # of its first gimbal, whatever its component id is
SILENT = 1.0  # [s] after which a device is not healthy and its attitude not passed on


class ArduPilot:
    """Component 1: streams set-points to the device and obeys anybody; who is in control is recorded only."""

    def __init__(self, address: Address, device: Address, servo: Servo, yaw: Callable[[float], float]) -> None:
        self.address = address
        self.primary: Address = (0, 0)
        self._device = device
        self._servo = servo
        self._yaw = yaw
        self._aim = 0.0  # counter-clockwise [rad]
        self._lock = False  # from north
        self._running = 0.0  # a rate [rad/s] that nobody has stopped
        self._heard: tuple[float, Any] | None = None  # when [s], the device's attitude
        self._told = False  # the device has told what it is
        self._asked = -math.inf
        self._periods = dict(PERIODS)
        self._due: dict[int, float] = {}
        self._then = 0.0

    def hear(self, packet: Packet, now: float) -> list[Any]:
        """Obey, and remember what the device says."""
        message = packet.message
        if (packet.system_id, packet.component_id) == self._device:
            self._told = self._told or packet.name == "GIMBAL_DEVICE_INFORMATION"
            if packet.name == "GIMBAL_DEVICE_ATTITUDE_STATUS":
                self._heard = now, message
        if (getattr(message, "target_system", 0), getattr(message, "target_component", 0)) != self.address:
            return []
        if packet.name == "GIMBAL_MANAGER_SET_PITCHYAW":
            self._point(message, math.degrees(message.pitch), math.degrees(message.yaw))
        elif packet.name == "COMMAND_LONG":
            return self._command(packet, now)
        return []

    def live(self, now: float) -> list[Any]:
        """Return what is due at ``now`` [s]."""
        self._aim += self._running * (now - self._then)
        self._then = now
        said = []
        if not self._told and now - self._asked >= 1.0:
            self._asked = now
            said.append(gimbal.request(self._device, gimbal.DEVICE_INFORMATION))
        for number, period in self._periods.items():
            if now >= self._due.get(number, now) - EARLY:
                self._due[number] = now + period
                said += self._message(number, now)
        return said

    def take_control(self, whom: Address) -> None:
        """Let somebody else configure the gimbal."""
        self.primary = whom

    def _point(self, message: Any, pitch: float, yaw: float) -> None:
        """Take a pitch and a yaw [deg, clockwise], or rates; angles with finite rates are ignored, as measured."""
        rates = message.pitch_rate, message.yaw_rate
        if all(map(math.isfinite, rates)):
            if not (math.isfinite(pitch) and math.isfinite(yaw)):
                self._running = -message.yaw_rate
            return
        if math.isfinite(pitch) and math.isfinite(yaw) and message.gimbal_device_id in (0, DEVICE_ID):
            aim = clockwise(math.radians(yaw))
            self._running, self._lock = 0.0, bool(message.flags & gimbal.YAW_LOCK)
            self._aim = aim if self._lock else self._within(aim)

    def _within(self, aim: float) -> float:
        """Clamp to the travel, on the turn that is nearest to the last aim inside it."""
        turns = (aim, aim - 2 * math.pi, aim + 2 * math.pi)
        inside = [turn for turn in turns if self._servo.lower <= turn <= self._servo.upper]
        return min(inside or [min(max(aim, self._servo.lower), self._servo.upper)], key=lambda t: abs(t - self._aim))

    def _command(self, packet: Packet, now: float) -> list[Any]:
        message = packet.message
        sender = packet.system_id, packet.component_id
        answers: list[Any] = []
        if message.command == gimbal.CONFIGURE:
            self._configure(message.param1, sender)
        elif message.command == gimbal.REQUEST_MESSAGE:
            answers = self._message(int(message.param1), now)
        elif message.command == gimbal.MESSAGE_INTERVAL and int(message.param1) in ADJUSTABLE:
            self._periods[int(message.param1)] = message.param2 / 1e6
        accepted = common.MAV_RESULT_ACCEPTED
        whom = {"target_system": sender[0], "target_component": sender[1]}
        return [common.MAVLink_command_ack_message(message.command, accepted, **whom), *answers]

    def _configure(self, primary: float, sender: Address) -> None:
        if primary == gimbal.ITSELF:
            self.primary = sender
        elif primary == gimbal.NOBODY and self.primary == sender:
            self.primary = 0, 0

    def _message(self, number: int, now: float) -> list[Any]:
        boot = round(now * 1e3)
        travel = (0.0, 0.0, 0.0, 0.0, -self._servo.upper, -self._servo.lower)
        match number:
            case 0:
                kind, maker = common.MAV_TYPE_QUADROTOR, common.MAV_AUTOPILOT_ARDUPILOTMEGA
                return [common.MAVLink_heartbeat_message(kind, maker, 1, 0, common.MAV_STATE_STANDBY, 3)]
            case 30:
                rate = (self._yaw(now) - self._yaw(now - 0.01)) / 0.01
                return [vehicle.attitude(VehicleAttitude(now, self._yaw(now), 0.0, 0.0, rate))]
            case gimbal.MANAGER_INFORMATION:
                return [common.MAVLink_gimbal_manager_information_message(boot, 0, DEVICE_ID, *travel)]
            case gimbal.MANAGER_STATUS:
                return [common.MAVLink_gimbal_manager_status_message(boot, 12, DEVICE_ID, *self.primary, 0, 0)]
        return self._gimbal_message(number, boot, now)

    def _gimbal_message(self, number: int, boot: int, now: float) -> list[Any]:
        if number == SET_ATTITUDE and self._told:
            said = gimbal.point_device(self._device, self._aim)
            said.flags = 4 | 8 | gimbal.YAW_LOCK if self._lock else 0
            return [said]
        if number == gimbal.DEVICE_ATTITUDE and self._heard and now - self._heard[0] <= SILENT:
            q, flags = self._heard[1].q, self._heard[1].flags
            rates = (math.nan,) * 3
            said = common.MAVLink_gimbal_device_attitude_status_message(
                0, 0, boot, flags, q, *rates, self._heard[1].failure_flags, gimbal_device_id=DEVICE_ID
            )
            return [said]
        return []
