"""What an autopilot tells of its mode, its arming and the pilot's yaw stick, and the messages that yaw a multicopter.

On the wire yaw is clockwise from north; here it is counter-clockwise. What each autopilot does with a message was read
in its source (ArduCopter 4.6 `autoyaw.cpp`, PX4 `navigator_main.cpp`):

- ArduCopter accepts CONDITION_YAW in every mode and obeys it where the autopilot steers the yaw: in GUIDED, not in
  LOITER, whose yaw is the stick's alone. Relative by 0 it holds the yaw that it has come to.
- PX4 knows no CONDITION_YAW outside of missions. In Hold it turns to the yaw of DO_REPOSITION [rad]; in Offboard it
  follows SET_POSITION_TARGET_LOCAL_NED, a stream that may not pause for half a second.
- An armed PX4 on the ground takes off when its set-point is above it: in Hold by about 0.3 m, where it asks for a climb
  of 0.3 m/s (`FlightTaskAuto::update`), in Offboard by anything (`MulticopterPositionControl::Run`). An ArduCopter on
  the ground obeys no CONDITION_YAW.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.field_converters import clockwise
from ross_protocols.mavlink.vehicle import VehicleAttitude, euler

ARDUPILOT, PX4 = common.MAV_AUTOPILOT_ARDUPILOTMEGA, common.MAV_AUTOPILOT_PX4
HEARTBEAT, ATTITUDE, LOCAL_POSITION, GLOBAL_POSITION = 0, 30, 32, 33  # message ids
RC_CHANNELS, MANUAL_CONTROL, EXTENDED_SYS_STATE, CURRENT_MODE = 65, 69, 245, 436
CONDITION_YAW, DO_REPOSITION = common.MAV_CMD_CONDITION_YAW, common.MAV_CMD_DO_REPOSITION
MULTICOPTERS = frozenset(
    (
        common.MAV_TYPE_QUADROTOR,
        common.MAV_TYPE_COAXIAL,
        common.MAV_TYPE_HELICOPTER,
        common.MAV_TYPE_HEXAROTOR,
        common.MAV_TYPE_OCTOROTOR,
        common.MAV_TYPE_TRICOPTER,
        common.MAV_TYPE_DODECAROTOR,
        common.MAV_TYPE_DECAROTOR,
    )
)
ARMED = common.MAV_MODE_FLAG_SAFETY_ARMED
GUIDED, LOITER = 4, 5  # ArduCopter
POSITION, HOLD, OFFBOARD = 3 << 16, 4 << 16 | 3 << 24, 6 << 16  # PX4: main mode, and sub-mode of the automatic one
PX4_AUTO = 4  # main mode of PX4: a sub-mode tells which
IN_AIR = common.MAV_LANDED_STATE_IN_AIR
NO_PULSE = (0, 65535)  # of RC_CHANNELS: a channel that the receiver does not have
UNCHANGED = 2**31 - 1  # as x and y of COMMAND_INT: the vehicle stays where it is
YAW_AND_POSITION = 0x9F8  # POSITION_TARGET_TYPEMASK: velocity, acceleration and yaw rate are ignored
COPTER_MODES = {
    0: "STABILIZE", 1: "ACRO", 2: "ALT_HOLD", 3: "AUTO", 4: "GUIDED", 5: "LOITER", 6: "RTL", 7: "CIRCLE", 9: "LAND",
    11: "DRIFT", 13: "SPORT", 15: "AUTOTUNE", 16: "POSHOLD", 17: "BRAKE", 18: "THROW", 20: "GUIDED_NOGPS",
    21: "SMART_RTL", 22: "FLOWHOLD", 23: "FOLLOW", 24: "ZIGZAG",
}  # fmt: skip
PX4_MODES = {1: "Manual", 2: "Altitude", 3: "Position", 4: "Auto", 5: "Acro", 6: "Offboard", 7: "Stabilized"}
PX4_AUTO_MODES = {2: "Takeoff", 3: "Hold", 4: "Mission", 5: "Return", 6: "Land", 8: "Follow", 9: "Precision Land"}


@dataclass(frozen=True, slots=True)
class FlightStatus:
    """HEARTBEAT of an autopilot."""

    autopilot: int  # MAV_AUTOPILOT
    multicopter: bool
    armed: bool
    mode: int  # in the autopilot's own numbers


def flight_status(message: Any) -> FlightStatus | None:
    """Return what a heartbeat tells; None: another message."""
    if message.get_type() != "HEARTBEAT":
        return None
    armed = bool(message.base_mode & ARMED)
    return FlightStatus(message.autopilot, message.type in MULTICOPTERS, armed, message.custom_mode)


def landed_state(message: Any) -> int | None:
    """Return MAV_LANDED_STATE of EXTENDED_SYS_STATE; None: another message."""
    return int(message.landed_state) if message.get_type() == "EXTENDED_SYS_STATE" else None


def mode_name(autopilot: int, mode: int) -> str:
    """Return the name of a flight mode.

    >>> mode_name(ARDUPILOT, GUIDED), mode_name(PX4, HOLD), mode_name(PX4, OFFBOARD), mode_name(ARDUPILOT, 99)
    ('GUIDED', 'Hold', 'Offboard', 'mode 99')
    """
    if autopilot == ARDUPILOT:
        return COPTER_MODES.get(mode, f"mode {mode}")
    main, sub = mode >> 16 & 0xFF, mode >> 24
    named = PX4_AUTO_MODES.get(sub) if main == PX4_AUTO else None
    return named or PX4_MODES.get(main, f"mode {mode}")


def yaw_stick(message: Any, channel: int, centre: float) -> float | None:
    """Return how far RC_CHANNELS or MANUAL_CONTROL tells that the yaw stick is from its centre [us]; None: not told.

    A full deflection, 1000 of MANUAL_CONTROL, is 500 us. NaN: the receiver does not have the channel.
    """
    if message.get_type() == "MANUAL_CONTROL":
        return math.nan if abs(message.r) > 1000 else message.r / 2
    if message.get_type() != "RC_CHANNELS":
        return None
    pulse = getattr(message, f"chan{channel}_raw")
    return math.nan if pulse in NO_PULSE or channel > message.chancount else pulse - centre


def attitude_quaternion(message: Any) -> VehicleAttitude | None:
    """Return what ATTITUDE_QUATERNION of a vehicle that is nearly level tells; None: another message, or no number."""
    if message.get_type() != "ATTITUDE_QUATERNION":
        return None
    yaw, pitch, roll = euler((message.q1, message.q2, message.q3, message.q4))
    about = message.pitchspeed * math.sin(roll) + message.yawspeed * math.cos(roll)
    value = VehicleAttitude(message.time_boot_ms / 1e3, clockwise(yaw), pitch, roll, -about / math.cos(pitch))
    return value if all(map(math.isfinite, (value.yaw, value.yaw_rate))) else None


def turn_to(whom: ComponentId, yaw: float, speed: float) -> Any:
    """Return the CONDITION_YAW that turns an ArduCopter to a yaw [rad] the shorter way, at ``speed`` [rad/s].

    >>> turn_to(ComponentId(1, 1), math.pi / 2, 0.5).param1
    270.0
    """
    target = math.degrees(clockwise(yaw)) % 360.0
    values = (target, math.degrees(speed), 0.0, 0.0, 0.0, 0.0, 0.0)
    return common.MAVLink_command_long_message(*whom, CONDITION_YAW, 0, *values)


def hold_yaw(whom: ComponentId) -> Any:
    """Return the CONDITION_YAW that ends a turn of an ArduCopter: relative by 0, from where its turn has come to."""
    return common.MAVLink_command_long_message(*whom, CONDITION_YAW, 0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0)


def reposition(whom: ComponentId, yaw: float, altitude: float) -> Any:
    """Return the DO_REPOSITION that turns a PX4 in Hold to a yaw [rad], at an altitude [m] above the sea.

    It stays where it is, and in its mode. Without an altitude PX4 would take its momentary one with every command, and
    wander up and down.
    """
    values = (-1.0, 0.0, 0.0, clockwise(yaw))  # the usual speed, no change of mode, no radius
    frame = common.MAV_FRAME_GLOBAL
    return common.MAVLink_command_int_message(
        *whom, frame, DO_REPOSITION, 0, 0, *values, UNCHANGED, UNCHANGED, altitude
    )


def position_target(whom: ComponentId, boot: float, position: tuple[float, float, float], yaw: float) -> Any:
    """Return the SET_POSITION_TARGET_LOCAL_NED for a place, north, east and down [m], and a yaw [rad].

    ``boot`` is the time [s] of who sends it.
    """
    still = (0.0,) * 6
    return common.MAVLink_set_position_target_local_ned_message(
        round(boot * 1e3) % 2**32,
        *whom,
        common.MAV_FRAME_LOCAL_NED,
        YAW_AND_POSITION,
        *position,
        *still,
        clockwise(yaw),
        0.0,
    )


def interval(whom: ComponentId, message_id: int, hertz: float) -> Any:
    """Return the command that asks for a message at a rate."""
    values = (float(message_id), 1e6 / hertz, 0.0, 0.0, 0.0, 0.0, 0.0)
    return common.MAVLink_command_long_message(*whom, common.MAV_CMD_SET_MESSAGE_INTERVAL, 0, *values)


def result_name(result: int) -> str:
    """Return MAV_RESULT in words.

    >>> result_name(2)
    'DENIED'
    """
    found = common.enums["MAV_RESULT"].get(result)
    return found.name.removeprefix("MAV_RESULT_") if found is not None else f"result {result}"
