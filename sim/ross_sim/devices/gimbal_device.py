"""A simulated gimbal device: a servo loop behind MAVLink gimbal protocol v2."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from itertools import cycle
from typing import Any

from numpy.random import Generator

from ross_payload.angles import wrap
from ross_protocols.mavlink import gimbal_messages
from ross_protocols.mavlink.codec import Packet
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.field_converters import clockwise
from ross_protocols.mavlink.vehicle import euler, quaternion

STEP = 0.002  # of the servo loop [s]
COASTING = 3.0  # friction of a motor without torque [rad/s^2]
TREMBLE = math.radians(3)  # of a sensor that is broken, standard deviation [rad]
GLIDE = 0.02  # in which a new set-point is approached, so that a stream of them makes no noise, at least [s]
LONGEST_GLIDE = 0.1  # between two set-points of a stream that is slower [s]
STAMP_LAGS = (0.003, 0.001, 0.004, 0.002)  # by which its attitude is older than its report, in turn [s]
EARLY = 1e-9  # [s], of rounding


@dataclass(frozen=True, slots=True)
class Servo:
    """How a device moves about its yaw axis; angles counter-clockwise from the nose [rad]."""

    lower: float
    upper: float
    max_speed: float  # [rad/s]
    max_acceleration: float  # [rad/s^2]
    resolution: float = math.radians(0.02)  # of its encoder [rad]
    bandwidth: float = 60.0  # of its loop, critically damped [rad/s]


class Device:
    """Component 154: follows set-points as well as its motor can, and tells where its encoder says it is.

    `stuck`, `limp`, `mute`, `trembling` and `failures` may be set while it lives; `restart` makes it boot.

    Parameters
    ----------
    now, up
        When its life begins [s], and for how long it has been on by then [s].
    """

    def __init__(
        self,
        address: ComponentId,
        servo: Servo,
        vehicle: Callable[[float], float],
        *,
        earth: bool,
        now: float = 0.0,
        up: float = 0.0,
    ) -> None:
        self.address = address
        self.servo = servo
        self.angle = 0.0  # true [rad]
        self.bumps = 0
        self.stuck = False
        self.limp = False  # without torque
        self.mute = False
        self.trembling: Generator | None = None  # makes the noise of a broken sensor
        self.failures = 0
        self._vehicle = vehicle
        self._earth = earth
        self._rate = 0.0
        self._goal, self._from, self._since = 0.0, 0.0, -math.inf  # set-point, the one before, when it came
        self._glide = GLIDE  # in which it is approached [s]
        self._gaps = deque([0.0] * 4, maxlen=4)  # between set-points that differ, of a stream [s]
        self._locked: float | None = None  # set-point from north [rad]
        self._now, self._boot, self._lags = now, now - up, cycle(STAMP_LAGS)
        self._managed = -math.inf
        self._due = {0: 0.0, gimbal_messages.DEVICE_ATTITUDE: 0.0}
        self._periods = {0: 1.0, gimbal_messages.DEVICE_ATTITUDE: 0.1}

    def restart(self) -> None:
        """Boot: forget set-points and requests, stand still; its clock begins again."""
        self._boot, self._rate, self._locked = self._now, 0.0, None
        self._goal = self._from = self.angle
        self._periods[gimbal_messages.DEVICE_ATTITUDE] = 0.1

    def on_packet(self, packet: Packet, now: float) -> list[Any]:
        """Obey set-points and requests."""
        message = packet.message
        if (getattr(message, "target_system", 0), getattr(message, "target_component", 0)) != self.address:
            return []
        if packet.name == "GIMBAL_DEVICE_SET_ATTITUDE":
            self._point(message, now)
        elif packet.name == "COMMAND_LONG":
            return self._command(packet, now)
        return []

    def live(self, now: float) -> list[Any]:
        """Return the heartbeat and the attitude when they are due."""
        ready = [] if self.mute else [number for number, due in self._due.items() if now >= due - EARLY]
        for number in ready:
            self._due[number] = now + self._periods[number]
        return [self._attitude(now) if number else self._heartbeat() for number in ready]

    def move(self, now: float) -> None:
        """Let the servo loop run until ``now`` [s]."""
        if self._locked is not None:
            self._aim(self._locked - self._vehicle(now))
        if self._rests():
            self._now = now
        for _ in range(round((now - self._now) / STEP)):
            self._now += STEP
            self._turn()
        self._now = now

    def _rests(self) -> bool:
        """Whether friction holds the axis near its set-point."""
        near = abs(self._goal - self._encoder()) <= self.servo.resolution
        return self._rate == 0.0 and near and self._now - self._since >= self._glide

    def _turn(self) -> None:
        """One step: a critically damped loop on the encoder, its acceleration and speed limited, stops at both ends."""
        servo, share = self.servo, self._share()
        aim = self._from + share * (self._goal - self._from)
        lead = (self._goal - self._from) / self._glide if share < 1.0 else 0.0
        error = aim - self._encoder()
        if self.limp and not self.stuck:
            self._advance(math.copysign(max(abs(self._rate) - COASTING * STEP, 0.0), self._rate))
            return
        if self.stuck or (
            lead == 0.0 and abs(error) <= servo.resolution and abs(self._rate) < servo.resolution / GLIDE
        ):
            self._rate = 0.0  # friction
            return
        braking = math.sqrt(1.5 * servo.max_acceleration * abs(error))  # so fast it can still stop there
        speed = lead + math.copysign(min(servo.bandwidth / 2 * abs(error), braking), error)
        wanted = 2 * servo.bandwidth * (speed - self._rate)
        push = min(max(wanted, -servo.max_acceleration), servo.max_acceleration)
        self._advance(min(max(self._rate + push * STEP, -servo.max_speed), servo.max_speed))

    def _advance(self, rate: float) -> None:
        servo, self._rate = self.servo, rate
        self.angle += rate * STEP
        if not servo.lower <= self.angle <= servo.upper:
            self.angle = min(max(self.angle, servo.lower), servo.upper)
            self._rate, self.bumps = 0.0, self.bumps + 1

    def _encoder(self, moved: float = 0.0) -> float:
        """Return what the encoder shows, or showed when it had ``moved`` less far [rad]."""
        return round((self.angle - moved) / self.servo.resolution) * self.servo.resolution

    def _point(self, message: Any, now: float) -> None:
        self._managed = now
        yaw = euler(message.q)[0]
        if not math.isfinite(yaw):
            return
        earth = gimbal_messages.in_earth_frame(message.flags)
        self._locked = clockwise(yaw) if earth else None
        self._aim(clockwise(yaw) - (self._vehicle(now) if earth else 0.0))

    def _aim(self, angle: float) -> None:
        """Take a set-point: the nearest of its turns inside the travel; where none is, the stop that is nearest to it.

        As ArduPilot does with a servo (`AP_Mount_Servo::closest_limit`).
        """
        servo, before = self.servo, self._goal
        near = before + wrap(angle - before)
        inside = [turn for turn in (near, near - math.tau, near + math.tau) if servo.lower <= turn <= servo.upper]
        goal = inside[0] if inside else min(servo.lower, servo.upper, key=lambda stop: abs(wrap(angle - stop)))
        if goal == before:
            return  # repeated, as managers do
        self._from += self._share() * (before - self._from)
        gap = self._now - self._since
        self._gaps.append(gap if gap <= LONGEST_GLIDE + EARLY else 0.0)
        # One long gap is that of a set-point which came again; two are those of a manager that repeats each.
        self._goal, self._since, self._glide = goal, self._now, max(GLIDE, sorted(self._gaps)[-2])

    def _share(self) -> float:
        """Return how far it is on the way from the set-point before to the last one, 0 to 1."""
        return min((self._now - self._since) / self._glide, 1.0)

    def _command(self, packet: Packet, now: float) -> list[Any]:
        message, number = packet.message, packet.message.param1
        answers = []
        if message.command == gimbal_messages.REQUEST_MESSAGE and number == gimbal_messages.DEVICE_INFORMATION:
            answers = [self._information(now)]
        elif (
            message.command == gimbal_messages.MESSAGE_INTERVAL
            and number == gimbal_messages.DEVICE_ATTITUDE
            and message.param2 > 0
        ):
            self._periods[gimbal_messages.DEVICE_ATTITUDE] = max(message.param2 / 1e6, GLIDE)
            self._due[gimbal_messages.DEVICE_ATTITUDE] = now
        else:
            return [_acknowledged(packet, common.MAV_RESULT_UNSUPPORTED)]
        return [_acknowledged(packet, common.MAV_RESULT_ACCEPTED), *answers]

    def _information(self, now: float) -> Any:
        lower, upper = self.servo.lower, self.servo.upper
        return common.MAVLink_gimbal_device_information_message(
            self._clock(now), b"ROSS", b"simulated", b"", 1, 1, 1, 0, 0, 0.0, 0.0, 0.0, 0.0, -upper, -lower
        )

    def _attitude(self, now: float) -> Any:
        """Return its attitude of a few milliseconds ago, stamped with the time when it was so."""
        lag = next(self._lags)
        then, angle = now - lag, self._encoder(self._rate * lag)
        base = self._vehicle(then) if self._earth else 0.0
        turn = (self._vehicle(then + STEP) - base) / STEP if self._earth else 0.0
        flags = (
            4
            | 8
            | (gimbal_messages.YAW_LOCK | gimbal_messages.EARTH_FRAME if self._earth else gimbal_messages.VEHICLE_FRAME)
        )
        unmanaged = gimbal_messages.NO_MANAGER if now - self._managed > 1.0 else 0
        noise = 0.0 if self.trembling is None else self.trembling.normal(0.0, TREMBLE)
        q = quaternion(clockwise(angle + base + noise), 0.0, 0.0)
        rates = (0.0, 0.0, -(self._rate + turn))
        return common.MAVLink_gimbal_device_attitude_status_message(
            0, 0, self._clock(then), flags, q, *rates, self.failures | unmanaged
        )

    def _heartbeat(self) -> Any:
        kind, maker = common.MAV_TYPE_GIMBAL, common.MAV_AUTOPILOT_INVALID
        return common.MAVLink_heartbeat_message(kind, maker, 0, 0, common.MAV_STATE_ACTIVE, 3)

    def _clock(self, now: float) -> int:
        return max(round((now - self._boot) * 1e3), 0)


def _acknowledged(packet: Packet, result: int) -> Any:
    sender = {"target_system": packet.system_id, "target_component": packet.component_id}
    return common.MAVLink_command_ack_message(packet.message.command, result, **sender)
