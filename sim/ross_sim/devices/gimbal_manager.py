"""A simulated gimbal manager: what an ArduPilot (4.8-dev, MNT1_TYPE 6) does with gimbal commands."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import cycle
from typing import Any

from ross_protocols.mavlink import gimbal_messages, vehicle
from ross_protocols.mavlink.codec import Packet
from ross_protocols.mavlink.component_id import NOBODY, ComponentId
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.field_converters import clockwise
from ross_protocols.mavlink.vehicle import VehicleAttitude
from ross_sim.devices.gimbal_device import EARLY, STAMP_LAGS, Servo

HEARTBEAT, ATTITUDE, SET_ATTITUDE, VEHICLE_STATE = 0, 30, 284, 286  # message ids
PITCH_YAW = 1000  # command, in degrees
HANDLED = (PITCH_YAW, gimbal_messages.CONFIGURE)  # commands of gimbal managers alone
SHORTEST = 0.01  # of the periods that it can be asked for [s]
FAILED = common.MAV_RESULT_FAILED
PERIODS = {HEARTBEAT: 1.0, ATTITUDE: 0.04, SET_ATTITUDE: 0.02, VEHICLE_STATE: 0.02}  # [s]
ADJUSTABLE = (gimbal_messages.DEVICE_ATTITUDE, ATTITUDE)
STATUS_PERIOD = 30.0  # [s] between two manager statuses that nobody asked for and nothing caused
DEVICE_ID = 1  # of its first gimbal, whatever its component id is
BOOTING = 1.0  # [s] of a restart
SEARCHING = 10.0  # [s] after it was switched on does it look for a device
TO_NEUTRAL = common.GIMBAL_DEVICE_FLAGS_RETRACT | common.GIMBAL_DEVICE_FLAGS_NEUTRAL
RELAYED = 4 | 8 | gimbal_messages.VEHICLE_FRAME  # the flags of the attitude that it passes on, whatever its frame
SILENT = 1.0  # [s] after which a device is not healthy and its attitude not passed on


@dataclass(frozen=True, slots=True)
class _Order:
    """COMMAND_LONG or COMMAND_INT."""

    number: int
    values: tuple[float, ...]  # params 1 to 4
    flags: int
    gimbal_device_id: int

    @classmethod
    def of(cls, message: Any) -> _Order:
        long = message.get_type() == "COMMAND_LONG"
        flags, device = (message.param5, message.param7) if long else (message.x, message.z)
        values = message.param1, message.param2, message.param3, message.param4
        return cls(message.command, values, _whole(flags), _whole(device))


class ArduPilot:
    """Component 1: streams set-points to the device and obeys anybody; who is in control is recorded only.

    As ArduCopter 4.8-dev does: it says who is in control when that changes and when it is asked, not in a stream; it
    does not tell who the device is (512/283 fails); a restart forgets who was in control and what was asked for. It
    passes on the attitude of the device, and not what ails it.

    Parameters
    ----------
    address, device
        Whose it is, and of the device.
    servo
        Of the device.
    yaw
        Of the vehicle [rad] at a time [s], counter-clockwise from north.
    up
        For how long it was on at time 0 [s].
    """

    def __init__(
        self,
        address: ComponentId,
        device: ComponentId,
        servo: Servo,
        yaw: Callable[[float], float],
        *,
        up: float = SEARCHING,
    ) -> None:
        self.address = address
        self.primary: ComponentId = NOBODY
        self._said_primary: ComponentId = NOBODY
        self._status_due = STATUS_PERIOD
        self._boot, self._up = -up, 0.0  # when it was switched on, from when it hears and speaks [s]
        self._lags = cycle(STAMP_LAGS)
        self._device = device
        self._servo = servo
        self._yaw = yaw
        self._aim = 0.0  # counter-clockwise [rad]
        self._lock = False  # from north
        self._running = 0.0  # a rate [rad/s] that nobody has stopped
        self._attitude: tuple[float, Any] | None = None  # when [s], the device's attitude
        self._information: Any = None  # what the device is
        self._asked = -math.inf
        self._periods = dict(PERIODS)
        self._due: dict[int, float] = {}
        self._then = 0.0

    def on_packet(self, packet: Packet, now: float) -> list[Any]:
        """Obey, and remember what the device says."""
        message = packet.message
        if now < self._up:
            return []
        if packet.sender == self._device:
            if packet.name == "GIMBAL_DEVICE_INFORMATION":
                self._information = message
            if packet.name == "GIMBAL_DEVICE_ATTITUDE_STATUS":
                self._attitude = now, message
        if (getattr(message, "target_system", 0), getattr(message, "target_component", 0)) != self.address:
            return []
        if packet.name == "GIMBAL_MANAGER_SET_PITCHYAW":
            self._point(message, (message.pitch, message.yaw), (message.pitch_rate, message.yaw_rate))
        elif packet.name == "GIMBAL_MANAGER_SET_ATTITUDE":
            yaw, pitch, _ = vehicle.euler(message.q)
            self._point(message, (pitch, yaw), (message.angular_velocity_y, message.angular_velocity_z))
        elif packet.name in ("COMMAND_LONG", "COMMAND_INT"):
            return self._command(packet, now)
        return []

    def live(self, now: float) -> list[Any]:
        """Return what is due at ``now`` [s]."""
        if now < self._up:
            return []
        self._aim += self._running * (now - self._then)
        self._then = now
        said = []
        if self.primary != self._said_primary or now >= self._status_due - EARLY:
            self._said_primary, self._status_due = self.primary, now + STATUS_PERIOD
            said += self._message(gimbal_messages.MANAGER_STATUS, now)
        searches = now - self._boot >= SEARCHING - EARLY
        if self._information is None and searches and now - self._asked >= 1.0:
            self._asked = now
            said.append(gimbal_messages.request(self._device, gimbal_messages.DEVICE_INFORMATION))
        for number, period in self._periods.items():
            if now >= self._due.get(number, now) - EARLY:
                self._due[number] = now + period
                said += self._message(number, now)
        return said

    def take_control(self, whom: ComponentId) -> None:
        """Let somebody else configure the gimbal."""
        self.primary = whom

    def restart(self, now: float) -> None:
        """Boot at ``now`` [s], deaf and mute for a while.

        It forgets who was in control, what was asked for and where to point.
        """
        self._up = now + BOOTING
        self.primary = self._said_primary = NOBODY
        self._boot, self._information, self._attitude, self._asked = now, None, None, -math.inf
        self._aim, self._lock, self._running = 0.0, False, 0.0
        self._periods, self._due = dict(PERIODS), {}

    def _point(self, message: Any, angles: tuple[float, float], rates: tuple[float, float]) -> bool:
        """Take pitch and yaw [rad, clockwise], or their rates [rad/s]; neither when both are told, as measured."""
        if message.gimbal_device_id not in (0, DEVICE_ID):
            return False
        if message.flags & TO_NEUTRAL:
            self._running, self._lock, self._aim = 0.0, False, 0.0
            return True
        angled, rated = all(map(math.isfinite, angles)), all(map(math.isfinite, rates))
        if angled and not rated:
            self._running, self._lock = 0.0, bool(message.flags & gimbal_messages.YAW_LOCK)
            aim = clockwise(angles[1])
            self._aim = aim if self._lock else self._within(aim)
        elif rated and not angled:
            self._running = clockwise(rates[1])
        return angled or rated

    def _within(self, aim: float) -> float:
        """Clamp to the travel, on the turn that is nearest to the last aim inside it."""
        turns = (aim, aim - 2 * math.pi, aim + 2 * math.pi)
        inside = [turn for turn in turns if self._servo.lower <= turn <= self._servo.upper]
        return min(inside or [min(max(aim, self._servo.lower), self._servo.upper)], key=lambda t: abs(t - self._aim))

    def _command(self, packet: Packet, now: float) -> list[Any]:
        order = _Order.of(packet.message)
        sender = packet.sender
        result, answers = common.MAV_RESULT_ACCEPTED, list[Any]()
        if order.number == PITCH_YAW:
            pitch, yaw, *rates = map(math.radians, order.values[:4])
            result = FAILED if not self._point(order, (pitch, yaw), (rates[0], rates[1])) else result
        elif order.number == gimbal_messages.CONFIGURE:
            result = FAILED if not self._configure(order, sender) else result
        elif order.number == gimbal_messages.REQUEST_MESSAGE:
            answers = self._message(_whole(order.values[0]), now)
            result = result if answers else FAILED
        elif order.number == gimbal_messages.MESSAGE_INTERVAL and order.values[0] in ADJUSTABLE:
            self._set_interval(int(order.values[0]), order.values[1])
        elif order.number != gimbal_messages.MESSAGE_INTERVAL:
            result = common.MAV_RESULT_UNSUPPORTED
        whom = {"target_system": sender[0], "target_component": sender[1]}
        return [common.MAVLink_command_ack_message(order.number, result, **whom), *answers]

    def _set_interval(self, number: int, microseconds: float) -> None:
        self._due.pop(number, None)
        if microseconds > 0:
            self._periods[number] = max(microseconds / 1e6, SHORTEST)
        else:
            self._periods.pop(number, None)

    def _configure(self, order: _Order, sender: ComponentId) -> bool:
        """Record who is in control; tell whether that could be."""
        system, component = order.values[:2]
        if order.gimbal_device_id not in (0, DEVICE_ID) or not (-3 <= system <= 255 and -3 <= component <= 255):
            return False
        if system == gimbal_messages.ITSELF:
            self.primary = sender
        elif system == gimbal_messages.NOBODY and self.primary == sender:
            self.primary = NOBODY
        elif min(system, component) >= 0:  # a negative one of the two leaves control as it is
            self.primary = ComponentId(int(system), int(component))
        return True

    def _message(self, number: int, now: float) -> list[Any]:
        boot = max(round((now - self._boot) * 1e3), 0)
        travel = (0.0, 0.0, 0.0, 0.0, -self._servo.upper, -self._servo.lower)
        match number:
            case 0:
                kind, maker = common.MAV_TYPE_QUADROTOR, common.MAV_AUTOPILOT_ARDUPILOTMEGA
                return [common.MAVLink_heartbeat_message(kind, maker, 1, 0, common.MAV_STATE_STANDBY, 3)]
            case 30:
                rate = (self._yaw(now) - self._yaw(now - 0.01)) / 0.01
                return [vehicle.attitude(VehicleAttitude(boot / 1e3, self._yaw(now), 0.0, 0.0, rate))]
            case gimbal_messages.MANAGER_INFORMATION:
                return [common.MAVLink_gimbal_manager_information_message(boot, 0, DEVICE_ID, *travel)]
            case gimbal_messages.MANAGER_STATUS:
                return [common.MAVLink_gimbal_manager_status_message(boot, 12, DEVICE_ID, *self.primary, 0, 0)]
        return self._gimbal_message(number, boot, now)

    def _gimbal_message(self, number: int, boot: int, now: float) -> list[Any]:
        if number == SET_ATTITUDE and self._information is not None:
            said = gimbal_messages.point_device(self._device, self._aim)
            said.flags = 4 | 8 | gimbal_messages.YAW_LOCK if self._lock else 0
            return [said]
        if number == VEHICLE_STATE and self._information is not None:
            yaw, rate = self._yaw(now), (self._yaw(now) - self._yaw(now - 0.01)) / 0.01
            state = common.MAVLink_autopilot_state_for_gimbal_device_message(
                *self._device,
                boot * 1000,
                vehicle.quaternion(clockwise(yaw), 0.0, 0.0),
                0,
                0.0,
                0.0,
                0.0,
                0,
                clockwise(rate),
                0,
                1,
            )
            return [state]
        if number == gimbal_messages.DEVICE_ATTITUDE and self._attitude and now - self._attitude[0] <= SILENT:
            seen, lag = self._attitude[1], round(next(self._lags) * 1e3)
            said = common.MAVLink_gimbal_device_attitude_status_message(
                0, 0, max(boot - lag, 0), RELAYED, seen.q, *(math.nan,) * 3, 0, 0, 0, DEVICE_ID
            )
            return [said]
        return []


def _whole(number: float) -> int:
    return int(number) if math.isfinite(number) else 0
