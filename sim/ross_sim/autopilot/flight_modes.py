"""What steers the yaw of a simulated multicopter: the flight mode, the pilot's stick, and who has told it to turn.

ArduCopter as in `autoyaw.cpp` and PX4 as in `navigator_main.cpp` and `FlightTaskAuto`, as far as the yaw goes; the
position is held without fail. Angles are counter-clockwise from north [rad].
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ross_payload.angles import wrap
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.field_converters import clockwise
from ross_protocols.mavlink.vehicle_control import (
    CONDITION_YAW,
    DO_REPOSITION,
    GUIDED,
    HOLD,
    LOITER,
    OFFBOARD,
    POSITION,
    UNCHANGED,
)  # fmt: skip
from ross_sim.autopilot.yaw_dynamics import STEP, YawDynamics

CENTRE, TRAVEL = 1500.0, 400.0  # of a stick [us]
DEAD_ZONE = 20.0  # (RC4_DZ, MAN_DEADZONE) [us]
PILOT_RATE = math.radians(90)  # of a full deflection (PILOT_Y_RATE, MPC_MAN_Y_MAX) [rad/s]
OVERRIDE = 0.3 * TRAVEL  # at which a stick takes a PX4 out of its automatic modes (COM_RC_STICK_OV) [us]
PROOF_S, LOSS_S = 1.0, 1.0  # of set-points before Offboard is granted, and without them until it ends (COM_OF_LOSS_T)
ACCEPTED, FAILED = common.MAV_RESULT_ACCEPTED, common.MAV_RESULT_FAILED
UNSUPPORTED, DENIED = common.MAV_RESULT_UNSUPPORTED, common.MAV_RESULT_DENIED
CHANGE_MODE = common.MAV_DO_REPOSITION_FLAGS_CHANGE_MODE


@dataclass(slots=True)
class Copter:
    """ArduCopter: GUIDED has a heading of its own, every other mode here has the pilot's rate.

    CONDITION_YAW is accepted in any mode; who enters GUIDED holds what yaw there is. While it is held nobody keeps the
    heading from which an absolute turn counts: only a relative one begins at the true yaw (``AutoYaw::set_fixed_yaw``).
    """

    body: YawDynamics
    mode: int = GUIDED
    stick: float = CENTRE  # [us]
    ignores_stick: bool = False  # in GUIDED (GUID_OPTIONS, bit 2)
    turns: bool = False  # a CONDITION_YAW steers the yaw; else it is held, or is the pilot's
    by_pilot: bool = False  # since the last turn in GUIDED the stick has been moved
    _heading: float = 0.0  # that the turn has come to, unwrapped [rad]
    _left: float = 0.0  # of the turn [rad]
    _speed: float = 0.0  # [rad/s]

    def enter(self, mode: int, now: float) -> bool:
        """Change the flight mode: a turn ends."""
        self.mode, self.turns, self.by_pilot = mode, False, False
        return True

    def command(self, message: Any, now: float) -> int:
        """Obey CONDITION_YAW; return MAV_RESULT."""
        if message.command != CONDITION_YAW:
            return int(UNSUPPORTED)
        angle, speed, direction, relative = message.param1, message.param2, message.param3, message.param4
        if not (0.0 <= angle <= 360.0 and relative in (0.0, 1.0)):
            return int(FAILED)
        if relative:
            if not (self.turns or self.by_pilot):
                self._heading = self.body.yaw
            self._left = -math.radians(angle) * (1.0 if direction >= 0 else -1.0)
        else:
            self._left = wrap(clockwise(math.radians(angle)) - self._heading)
            if direction < 0 and self._left < 0:  # counter-clockwise is positive here
                self._left += 2 * math.pi
            elif direction > 0 and self._left > 0:
                self._left -= 2 * math.pi
        most = self.body.airframe.max_speed
        self._speed = min(most, math.radians(speed)) if speed > 0 else most
        self.turns, self.by_pilot = True, False
        return int(ACCEPTED)

    def on_set_point(self, message: Any, now: float) -> None:
        """Ignore positions."""

    def step(self, now: float) -> None:
        """Let the vehicle live for one step of the controller."""
        pilot = pilot_rate(self.stick)
        if self.mode == GUIDED:
            if pilot and not self.ignores_stick:
                self.turns, self.by_pilot = False, True
            if self.turns:
                part = min(max(self._left, -self._speed * STEP), self._speed * STEP)
                self._left -= part
                self._heading += part
                self.body.follow_heading(self._heading, math.inf)
                return
            pilot = 0.0 if self.ignores_stick else pilot
            self._heading = self.body.target if self.by_pilot else self._heading
        self.body.follow_rate(pilot)


@dataclass(slots=True)
class Px4:
    """PX4: Hold has the heading of the last DO_REPOSITION, Offboard that of the stream, Position the pilot's rate."""

    body: YawDynamics
    mode: int = HOLD
    stick: float = CENTRE  # [us]
    ignores_stick: bool = False  # in Hold and Offboard (COM_RC_OVERRIDE = 0)
    turns: bool = False
    altitude: float = 100.0  # that it holds, above the sea [m]
    _heading: float = 0.0
    _proof: tuple[float, float] = (-math.inf, -math.inf)  # since when, and when last, set-points came [s]

    def enter(self, mode: int, now: float) -> bool:
        """Change the flight mode; Offboard is denied without a second of set-points."""
        if mode == OFFBOARD and not (now - self._proof[0] >= PROOF_S and now - self._proof[1] <= LOSS_S):
            return False
        if mode != self.mode:
            self._heading, self.turns = self.body.yaw, False
        self.mode = mode
        return True

    def command(self, message: Any, now: float) -> int:
        """Obey a DO_REPOSITION that changes the yaw alone; return MAV_RESULT.

        The navigator does, and the commander, who has no mode to change, answers that it does not know it.
        """
        if message.command != DO_REPOSITION:
            return int(UNSUPPORTED)
        if message.get_type() != "COMMAND_INT" or (message.x, message.y) != (UNCHANGED, UNCHANGED):
            return int(DENIED)
        if self.mode == HOLD and math.isfinite(message.param4):
            self._heading, self.turns = clockwise(message.param4), True
            self.altitude = message.z if math.isfinite(message.z) else self.altitude
        return int(ACCEPTED if int(message.param2) & CHANGE_MODE else UNSUPPORTED)

    def on_set_point(self, message: Any, now: float) -> None:
        """Take a set-point of the stream."""
        begin, last = self._proof
        self._proof = (begin if now - last <= LOSS_S else now, now)
        if self.mode == OFFBOARD:
            self._heading, self.turns = clockwise(message.yaw), True

    def step(self, now: float) -> None:
        """Let the vehicle live for one step of the controller."""
        deflected = abs(self.stick - CENTRE) >= OVERRIDE and not self.ignores_stick
        lost = self.mode == OFFBOARD and now - self._proof[1] > LOSS_S
        if self.mode in (HOLD, OFFBOARD) and (deflected or lost):
            self.enter(POSITION, now)
        if self.mode in (HOLD, OFFBOARD):
            if not self.turns:
                self._heading = self.body.target
            self.body.follow_heading(self._heading, math.inf)
        else:
            self.body.follow_rate(pilot_rate(self.stick))


def pilot_rate(pulse: float) -> float:
    """Return the yaw rate [rad/s] that a stick asks for, counter-clockwise.

    >>> pilot_rate(1510.0), round(math.degrees(pilot_rate(1900.0)))
    (0.0, -90)
    """
    deflection = pulse - CENTRE
    return 0.0 if abs(deflection) <= DEAD_ZONE else -deflection / TRAVEL * PILOT_RATE


OTHER_MODE = {True: LOITER, False: POSITION}  # which a pilot chooses to fly by hand: of ArduCopter, of PX4
