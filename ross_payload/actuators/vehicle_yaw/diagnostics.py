"""What is amiss with a vehicle that yaws, in words."""

from __future__ import annotations

import math

from ross_payload.actuators.mavlink_gimbal.feedback import GimbalFeedback
from ross_payload.actuators.motion import Motion
from ross_protocols.mavlink.dialect import common

# [s]: an attitude that is older proves nothing; less than guard.watchdog_s, which cannot say who is silent
STALE_ATTITUDE_S = 0.45
LATE_ATTITUDE_S = STALE_ATTITUDE_S / 2  # [s] of an attitude on its way, which no link in order takes
# how far a vehicle may be behind its set-point [rad], and this many [s] more: autopilots shape what they are told
MAX_LAG_RAD, MAX_LAG_S = math.radians(10), 0.5
ARRIVAL_TIMEOUT_S = 3.0  # after its time a vehicle may not be farther from its goal than in wind
WELCOME = (common.MAV_RESULT_ACCEPTED, common.MAV_RESULT_IN_PROGRESS, common.MAV_RESULT_TEMPORARILY_REJECTED)


def contradiction(seen: GimbalFeedback) -> str:
    """Say when attitudes cannot all be true: then nobody knows where the vehicle points."""
    if seen.duplicated:
        return "two autopilots report as one: give one of them another system id, then home and rearm"
    if seen.jumps:
        return "the attitude of the vehicle jumps: a faulty compass, or two autopilots as one; home and rearm"
    return ""


def following_error(seen: GimbalFeedback, motion: Motion | None, resolution: float, now: float) -> str:
    """Say when a vehicle lags behind its set-points, or stays beside its goal: too weak, held, or turned by others."""
    if motion is None or seen.time < motion.begin or now - seen.time > STALE_ATTITUDE_S or not seen.steady:
        return ""
    angle, rate = motion.at(seen.time)
    behind = abs(angle - seen.angle)
    astray = behind > 2 * resolution and seen.time > motion.end + ARRIVAL_TIMEOUT_S
    if astray or behind > MAX_LAG_RAD + MAX_LAG_S * abs(rate):
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
