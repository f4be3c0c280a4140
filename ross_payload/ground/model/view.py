"""What is known of a payload, as sections of plain JSON: the one picture that page, terminal and logs draw.

Angles are degrees here, clockwise as on a compass: from north when ``earth``, else from the zero of the mount. Times
are seconds on the listener's clock. What is not known is null. Sections change apart: a listener sends those that did.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from ross_payload.ground.model.health import condition
from ross_payload.ground.model.payload_state import PayloadState, elapsed
from ross_payload.ground.model.stream_rows import stream_row
from ross_protocols.mavlink.dialect import ross
from ross_protocols.mavlink.field_converters import compass
from ross_protocols.mavlink.values import Alignment, CandidateState, Information, Separation, Source, Status

Section = dict[str, Any] | list[Any]
MOST_TEXTS = 100
ROTATION_S = 1.0  # that one rotation takes
CHECKS = 2  # candidates that are visited
EXPECTED_FROM = "EXP_LEAD_IN", "EXP_UNIT", "EXP_MIN_ROT", "EXP_MAX_ROT", "XPL_CHECK", "XPL_RUN"


def word(enum: str, number: int | None) -> str | None:
    """Return the short word of an entry of the dialect's enumeration.

    >>> word("ROSS_STATE", 6), word("ROSS_STATE", 99), word("ROSS_STATE", None)
    ('run', '99', None)
    """
    if number is None:
        return None
    entry = ross.enums[enum].get(int(number))
    return str(number) if entry is None else entry.name.removeprefix(f"{enum}_").lower()


def meaning(enum: str, number: int) -> str:
    """Return what an entry means, in the dialect's words; empty: unknown."""
    entry = ross.enums[enum].get(int(number))
    return "" if entry is None else str(entry.description)


def view(known: PayloadState, settings: Mapping[str, float] | None = None) -> dict[str, Section]:
    """Return every section; ``settings`` are the payload's parameters, as far as they are known."""
    return {name: draw(known, settings or {}) for name, draw in SECTIONS.items()}


def picked(value: Any, *names: str) -> dict[str, Any]:
    """Return attributes of a value that are shown as they are."""
    return {name: getattr(value, name) for name in names}


def standing(known: PayloadState, settings: Mapping[str, float]) -> Section:
    """Who it is, what it does, and since when it was not heard of."""
    status, beat, mirror = known.status, known.heartbeat, dict(known.mirrors)
    state = known.state
    return {
        "who": str(known.who),
        "system": known.who.system,
        "component": known.who.component,
        "last": known.last,
        "boots": known.boots,
        "twin": known.twin,
        "tunnelled": known.tunnelled,
        "mirrors_only": status is None and bool(mirror),
        "state": word("ROSS_STATE", state),
        "state_meaning": "" if state is None else meaning("ROSS_STATE", state),
        "outcome": word("ROSS_OUTCOME", status.outcome) if status else None,
        "health": beat.health.name.lower() if beat and hasattr(beat.health, "name") else None,
        "version": known.information.software_version if known.information else None,
        "dialect": known.information.dialect_version if known.information else None,
        "actuator": known.information.actuator if known.information else None,
        "streaming": status.streaming if status else None,
        "recording": status.recording if status else None,
        "flaws": list(known.flaws),
    }


def pointing(known: PayloadState, settings: Mapping[str, float]) -> Section:
    """Where the axis points and may point; ``limits`` are headings, clockwise from the first to the second."""
    status, mirror = known.status, dict(known.mirrors)
    if status is None:
        return {"earth": False, "heading": mirror.get("ross_head"), "goal": None, "limits": None, "present": False}
    return picked(status, "earth", "settled", "homed", "fault", "open_loop") | {
        "heading": _compass(status.heading),
        "goal": _compass(status.heading_goal),
        "joint": _degrees(status.joint),
        "joint_rate": _degrees(status.joint_rate),
        "mount_yaw": _compass(status.mount_yaw),
        "limits": _limits(known.information, status),
        "present": status.actuator_present,
    }


def mission(known: PayloadState, settings: Mapping[str, float]) -> Section:
    """The mission strip."""
    status, mirror = known.status, dict(known.mirrors)
    if status is None:
        k = mirror.get("ross_k")
        return {"k": None if k is None else int(k), "score": mirror.get("ross_score"), "target": None}
    mine = [group for group in known.separations if group.target]
    shown = "rotation", "rotation_max", "k", "target", "target_found", "score", "criterion", "certain", "noise_measured"
    current = _current(known)
    return picked(status, *shown) | {
        "time": status.mission_time,
        "elapsed": elapsed(known),
        "expected": expected(settings),
        "si_sdr": mine[0].si_sdr if mine else None,
        "si_sdri": mine[0].si_sdri if mine else None,
        "gain": None if current is None else current.gain,
    }


def sources(known: PayloadState, settings: Mapping[str, float]) -> Section:
    """One entry per source of the latest estimate, with its trail [(s, deg)]."""
    if not known.sources and known.status is None:
        return _mirrored(known)
    trails = {(trail.estimate, trail.source): trail.points for trail in known.trails}
    target = known.status.target if known.status else None
    return [
        {
            **source_row(source),
            "target": source.target or source.source == target,
            "announced": known.announced,
            "trail": [[at, compass(azimuth)] for at, azimuth in trails.get((source.estimate, source.source), ())],
        }
        for source in known.sources
    ]


def source_row(source: Source) -> dict[str, Any]:
    """Return one source of an estimate."""
    return picked(source, "source", "confidence", "weight", "score", "resolved", "target", "final", "earth") | {
        "azimuth": compass(source.azimuth),
        "mirror": _compass(source.mirror),
        "sigma": math.degrees(source.sigma),
        "elevation": None if source.elevation is None else math.degrees(source.elevation),
        "tracked": source.tracked,
        "rate": _degrees(source.rate or 0.0) if source.tracked else None,
        "age": source.age or 0.0 if source.tracked else None,
    }


def _mirrored(known: PayloadState) -> Section:
    """Sources of which nothing is known but where they are."""
    nothing = dict.fromkeys(("mirror", "sigma", "elevation", "confidence", "weight", "score", "rate", "age"))
    flags: dict[str, Any] = {"resolved": True, "target": False, "final": False, "earth": False, "tracked": False}
    flags["announced"] = len(known.azimuths)
    return [
        {"source": index, "azimuth": azimuth % 360.0, **nothing, **flags, "trail": []}
        for index, azimuth in enumerate(known.azimuths)
    ]


def plan(known: PayloadState, settings: Mapping[str, float]) -> Section:
    """Alignment candidates in order of travel; ``current`` is the one turned to or stayed at."""
    current = _current(known)
    return {
        "current": None if current is None else current.candidate,
        "candidates": [candidate_row(each) for each in known.alignments],
    }


def candidate_row(candidate: Alignment) -> dict[str, Any]:
    """Return one alignment candidate of a plan."""
    return picked(candidate, "candidate", "source", "gain") | {
        "heading": compass(candidate.heading),
        "joint": _degrees(candidate.joint),
        "isolation_us": candidate.isolation * 1e6,
        "aliased": list(candidate.aliased),
        "rule": word("ROSS_ALIGNMENT_RULE", candidate.rule),
        "rule_meaning": meaning("ROSS_ALIGNMENT_RULE", candidate.rule),
        "state": word("ROSS_CANDIDATE_STATE", candidate.state),
    }


def densities(known: PayloadState, settings: Mapping[str, float]) -> Section:
    """ITD density of every orientation, 0 to 1 at equal steps from ``first_us`` to ``last_us``."""
    return [
        {
            "rotation": each.rotation,
            "heading": compass(each.heading),
            "first_us": each.first * 1e6,
            "last_us": each.last * 1e6,
            "density": [round(share, 3) for share in each.density],
        }
        for each in known.densities
    ]


def isolation(known: PayloadState, settings: Mapping[str, float]) -> Section:
    """Isolation of every source over half a turn, 0 to 1 of ``maximum_us``; headings are not wrapped, clockwise."""
    return [
        {
            "source": each.source,
            "first": _degrees(each.first),
            "last": _degrees(each.last),
            "maximum_us": each.maximum * 1e6,
            "isolation": [round(share, 3) for share in each.isolation],
        }
        for each in known.isolations
    ]


def groups(known: PayloadState, settings: Mapping[str, float]) -> Section:
    """The latest separation, one entry per group."""
    return [group_row(each) for each in known.separations]


def group_row(group: Separation) -> dict[str, Any]:
    """Return one group of a separation."""
    return picked(group, "group", "method", "score", "criterion", "si_sdr", "si_sdri", "accepted", "target") | {
        "phase": word("ROSS_SEPARATION_PHASE", group.phase),
        "members": list(group.members),
        "heading": _compass(group.heading),
    }


def streams(known: PayloadState, settings: Mapping[str, float]) -> Section:
    """Live listening, one entry per stream, also those that have ended."""
    return [stream_row(each) for each in known.streams]


def history(known: PayloadState, settings: Mapping[str, float]) -> Section:
    """K, score and state over time, oldest first."""
    return [
        picked(each, "at", "k", "score", "criterion")
        | {"time": each.mission_time, "state": word("ROSS_STATE", each.state), "heading": _compass(each.heading)}
        for each in known.history
    ]


def events(known: PayloadState, settings: Mapping[str, float]) -> Section:
    """Texts, oldest first; severity as in MAV_SEVERITY."""
    return [picked(each, "at", "severity", "text") for each in known.texts[-MOST_TEXTS:]]


SECTIONS: dict[str, Callable[[PayloadState, Mapping[str, float]], Section]] = {
    "standing": standing,
    "pointing": pointing,
    "mission": mission,
    "sources": sources,
    "plan": plan,
    "densities": densities,
    "isolation": isolation,
    "groups": groups,
    "streams": streams,
    "history": history,
    "events": events,
    "health": lambda known, settings: condition(known),
}


def _current(known: PayloadState) -> Alignment | None:
    wanted = (CandidateState.TURNING, CandidateState.ACCEPTED)
    return next((each for state in wanted for each in known.alignments if each.state == state), None)


def _limits(information: Information | None, status: Status) -> list[float] | None:
    """Headings at the ends of the travel; None: it turns all round, or nobody knows."""
    if information is None or status.heading is None or status.joint is None:
        return None
    if information.joint_lower is None or information.joint_upper is None:
        return None
    if information.joint_upper - information.joint_lower >= 2 * math.pi:
        return None
    zero = status.heading - status.joint
    return [compass(zero + information.joint_upper), compass(zero + information.joint_lower)]


def _compass(angle: float | None) -> float | None:
    return None if angle is None else compass(angle)


def _degrees(angle: float | None) -> float | None:
    """Clockwise, not wrapped."""
    return None if angle is None else 0.0 - math.degrees(angle)


def expected(settings: Mapping[str, float]) -> float | None:
    """Return about how long a mission takes [s], when the explorer is certain half-way; None: not all is known.

    >>> expected(dict(zip(EXPECTED_FROM, (2.0, 3.0, 4.0, 12.0, 3.0, 30.0))))
    74.0
    >>> expected({"EXP_UNIT": 3.0}) is None
    True
    """
    if not all(name in settings for name in EXPECTED_FROM):
        return None
    lead_in, unit, least, most, check, run = (settings[name] for name in EXPECTED_FROM)
    return lead_in + (least + most) / 2 * (unit + ROTATION_S) + CHECKS * (check + 2 * ROTATION_S) + run
