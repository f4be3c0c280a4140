"""What is amiss with a gimbal, in words."""

from __future__ import annotations

import math

from ross_payload.actuators.mavlink_gimbal.feedback import GimbalFeedback
from ross_payload.actuators.mavlink_gimbal.options import Options
from ross_payload.actuators.requests import Motion
from ross_protocols import gimbal
from ross_protocols.gimbal import GimbalTravel

STALE = 0.45  # [s]: a report that is older proves nothing; less than guard.watchdog_s, which cannot say who is silent
LATE = STALE / 2  # [s] of a report on its way, which no link in order takes
LEASH, LATENESS = math.radians(10), 0.25  # how far a gimbal may be behind its set-point [rad], and this many [s] more
OVERDUE, ASTRAY = 3.0, math.radians(1)  # [s] after its time a gimbal may not be farther from its goal [rad]
UNMANAGED = 2.0  # [s] in which a device must notice that we manage it


def contradiction(seen: GimbalFeedback) -> str:
    """Say when reports cannot all be true: then nobody knows where the gimbal is."""
    if seen.twins:
        return "two gimbals have the same component id; change one of them, then home and rearm"
    if seen.trembles:
        return "the gimbal's attitude jumps: faulty sensor, or two gimbals with the same id; home and rearm"
    return ""


def straying(seen: GimbalFeedback, motion: Motion, now: float) -> str:
    """Say when a gimbal restarts in a move, lags behind it, or stands beside its goal."""
    if seen.time < motion.begin or now - seen.time > STALE or not (seen.steady or seen.restarted):
        return ""
    angle, rate = motion.at(seen.time)
    behind = abs(angle - seen.angle)
    astray = behind > ASTRAY and seen.time > motion.end + OVERDUE
    if seen.restarted and rate:
        return "the gimbal has restarted in the middle of a move; home and rearm"
    if astray or behind > LEASH + LATENESS * abs(rate):
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
    if now - seen.time <= STALE:
        return ""
    late = seen.arrived - seen.time
    if now - seen.arrived <= STALE and late > LATE:
        return f"the gimbal's reports come {late:.1f} s late: the link is overloaded"
    if seen.arrived == -math.inf:
        return "the gimbal has not reported its attitude yet"
    if manager is not None and manager <= seen.arrived + LATE:
        return f"no data from the autopilot or the gimbal for more than {STALE:g} s"
    return f"no attitude received from the gimbal for more than {STALE:g} s"


def failures(seen: GimbalFeedback, managed_for: float) -> str:
    """Say what the gimbal itself reports, ``managed_for`` [s] after we began to lead it."""
    flags = seen.failures & ~gimbal.NO_MANAGER if managed_for < UNMANAGED else seen.failures
    found = gimbal.failures(flags)
    return f"the gimbal reports a failure: {found}" if found else ""


def travel_trouble(travel: GimbalTravel | None, options: Options) -> str:
    """Say when a gimbal turns less far than the options ask for, or tells what cannot be."""
    if travel is None or (math.isnan(travel.lower) and math.isnan(travel.upper)):  # NaN: not known
        return ""
    lower, upper = math.degrees(travel.lower), math.degrees(travel.upper)
    if not lower < upper:
        return f"the limits of the gimbal: expected lower < upper, got {lower:.0f} to {upper:.0f} deg; not moving it"
    slack = options.resolution_deg
    if lower - slack <= options.lower_deg and options.upper_deg <= upper + slack:
        return ""
    wanted = f"{options.lower_deg:g} to {options.upper_deg:g}"
    return (
        f"the travel of the gimbal: expected at least {wanted} deg (actuator.options.lower_deg to upper_deg), "
        f"got {lower:.0f} to {upper:.0f}"
    )
