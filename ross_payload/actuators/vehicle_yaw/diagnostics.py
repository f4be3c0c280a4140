"""What is amiss with a vehicle that yaws, in words."""

from __future__ import annotations

import math

from ross_payload.actuators.mavlink_gimbal.feedback import GimbalFeedback
from ross_payload.actuators.motion import Motion
from ross_protocols.mavlink import vehicle_control
from ross_protocols.mavlink.dialect import common

# [s]: an attitude that is older proves nothing; less than guard.watchdog_s, which cannot say who is silent
STALE_ATTITUDE_S = 0.45
LATE_ATTITUDE_S = STALE_ATTITUDE_S / 2  # [s] of an attitude on its way, which no link in order takes
# how far a vehicle may be behind its set-point [rad], and this many [s] more: autopilots shape what they are told
MAX_LAG_RAD, MAX_LAG_S = math.radians(10), 0.5
ARRIVAL_TIMEOUT_S = 3.0  # a vehicle may be off its goal at the end of its time, and in a gust
WELCOME = (common.MAV_RESULT_ACCEPTED, common.MAV_RESULT_IN_PROGRESS, common.MAV_RESULT_TEMPORARILY_REJECTED)


def refusal(command: int, result: int) -> str:
    """Say that an autopilot does not turn as it was told, by its answer.

    A PX4 turns, and answers all the same that a DO_REPOSITION is not supported which changes no flight mode.
    """
    if result in WELCOME or (command, result) == (vehicle_control.DO_REPOSITION, common.MAV_RESULT_UNSUPPORTED):
        return ""
    name = "CONDITION_YAW" if command == vehicle_control.CONDITION_YAW else "DO_REPOSITION"
    return f"the autopilot answers {name} with {vehicle_control.result_name(result)}; home and rearm"


def contradiction(seen: GimbalFeedback) -> str:
    """Say when attitudes cannot all be true: then nobody knows where the vehicle points."""
    if seen.duplicated:
        return "two autopilots report as one: give one of them another system id, then home and rearm"
    if seen.jumps:
        return "the attitude of the vehicle jumps: a faulty compass, or two autopilots as one; home and rearm"
    return ""


def following_error(seen: GimbalFeedback, motion: Motion, near: float, now: float) -> str:
    """Say when a vehicle lags behind its set-points, or stays beside its goal: too weak, held, or turned by others.

    Parameters
    ----------
    seen
        Where it points.
    motion
        Where it should.
    near
        When it was about where it should be last [s].
    now
        The time [s].
    """
    if seen.time < motion.begin or now - seen.time > STALE_ATTITUDE_S or not seen.steady:
        return ""
    angle, rate = motion.at(seen.time)
    lags = seen.time <= motion.end and abs(angle - seen.angle) > MAX_LAG_RAD + MAX_LAG_S * abs(rate)
    if lags or seen.time - max(near, motion.end) > ARRIVAL_TIMEOUT_S:
        where = f"{math.degrees(seen.angle):.1f} deg, not at {math.degrees(angle):.1f}"
        return f"the vehicle does not follow: its yaw is {where}; home and rearm"
    return ""


def silence(seen: GimbalFeedback, now: float) -> str:
    """Say when attitudes are missing or too old; whether the link is late is told by when they were made."""
    if now - seen.time <= STALE_ATTITUDE_S:
        return ""
    late = seen.arrived_at - seen.time
    if now - seen.arrived_at <= STALE_ATTITUDE_S and late > LATE_ATTITUDE_S:
        return f"the attitude comes {late:.1f} s late: the link is overloaded"
    if seen.arrived_at == -math.inf:
        return "the autopilot has not told the attitude of the vehicle yet"
    return f"no attitude received from the autopilot for more than {STALE_ATTITUDE_S:g} s"
