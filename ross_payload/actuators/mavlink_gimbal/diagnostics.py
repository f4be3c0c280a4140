"""What is amiss with a gimbal, in words."""

from __future__ import annotations

import math

from ross_payload.actuators.mavlink_gimbal.feedback import GimbalFeedback
from ross_payload.actuators.motion import Motion
from ross_protocols.mavlink import gimbal_messages

# [s]: a report that is older proves nothing; less than guard.watchdog_s, which cannot say who is silent
STALE_REPORT_S = 0.45
LATE_REPORT_S = STALE_REPORT_S / 2  # [s] of a report on its way, which no link in order takes
# how far a gimbal may be behind its set-point [rad], and this many [s] more
MAX_LAG_RAD, MAX_LAG_S = math.radians(10), 0.25
# [s] after its time a gimbal may not be farther from its goal [rad]
ARRIVAL_TIMEOUT_S, MAX_OFFSET_RAD = 3.0, math.radians(1)
MANAGED_TIMEOUT_S = 2.0  # [s] in which a device must notice that we manage it


def contradiction(seen: GimbalFeedback) -> str:
    """Say when reports cannot all be true: then nobody knows where the gimbal is."""
    if seen.duplicated:
        return "two gimbals have the same component id; change one of them, then home and rearm"
    if seen.jumps:
        return "the gimbal's attitude jumps: faulty sensor, or two gimbals with the same id; home and rearm"
    return ""


def lost_turn(seen: GimbalFeedback) -> str:
    """Say when it may be a whole turn from where it seems to be."""
    words = "the gimbal may have turned round while nothing was heard of it: point it ahead; or home, if it has not"
    return words if seen.unseen else ""


def following_error(seen: GimbalFeedback, motion: Motion, now: float) -> str:
    """Say when a gimbal restarts in a move, lags behind it, or stands beside its goal."""
    if seen.time < motion.begin or now - seen.time > STALE_REPORT_S or not (seen.steady or seen.restarted):
        return ""
    angle, rate = motion.at(seen.time)
    behind = abs(angle - seen.angle)
    astray = behind > MAX_OFFSET_RAD and seen.time > motion.end + ARRIVAL_TIMEOUT_S
    if seen.restarted and rate:
        return "the gimbal has restarted in the middle of a move; home and rearm"
    if astray or behind > MAX_LAG_RAD + MAX_LAG_S * abs(rate):
        where = f"{math.degrees(seen.angle):.1f} deg, not at {math.degrees(angle):.1f}"
        return f"the gimbal does not follow: it is at {where}; home and rearm"
    return ""


def silence(seen: GimbalFeedback, now: float, manager: float | None = None) -> str:
    """Say when its reports are missing, too old, or cannot be used.

    Whether somebody is silent is told by when reports arrive, whether the link is late by when they were made.

    Parameters
    ----------
    seen
        What the gimbal has reported.
    now
        The time [s].
    manager
        When the gimbal's manager was heard last [s]; None: it has none.
    """
    if seen.lost_vehicle:
        return "the gimbal reports its yaw from north, and no autopilot reports the attitude of the vehicle"
    if now - seen.time <= STALE_REPORT_S:
        return ""
    late = seen.arrived_at - seen.time
    if now - seen.arrived_at <= STALE_REPORT_S and late > LATE_REPORT_S:
        return f"the gimbal's reports come {late:.1f} s late: the link is overloaded"
    if seen.arrived_at == -math.inf:
        return "the gimbal has not reported its attitude yet"
    if manager is not None and manager <= seen.arrived_at + LATE_REPORT_S:
        return f"no data from the autopilot or the gimbal for more than {STALE_REPORT_S:g} s"
    return f"no attitude received from the gimbal for more than {STALE_REPORT_S:g} s"


def failures(seen: GimbalFeedback, managed_for: float) -> str:
    """Say what the gimbal itself reports, ``managed_for`` [s] after we began to lead it."""
    flags = seen.failures & ~gimbal_messages.NO_MANAGER if managed_for < MANAGED_TIMEOUT_S else seen.failures
    found = gimbal_messages.failures(flags)
    return f"the gimbal reports a failure: {found}" if found else ""
