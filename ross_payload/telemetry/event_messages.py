"""What the mission says, as telemetry values: pure functions from events to messages."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ross_payload import events
from ross_payload.angles import difference, wrap
from ross_payload.health import AudioHealth
from ross_payload.mission_state import RESTING, MissionState, chosen
from ross_payload.telemetry.snapshot import Snapshot
from ross_protocols.mavlink import values
from ross_protocols.mavlink.field_converters import compass

ONE_AXIS = np.radians(1.0)  # headings within this of each other are one axis
MOVED = np.radians(1.0)  # that a tracked source must have moved to be told at once
AZIMUTHS = 1  # id of the array of them

RULES = {rule.name.lower(): rule for rule in values.Rule}
MEASURING = (events.State.LEAD_IN, events.State.NOISE)  # the noise, for what comes later


@dataclass(frozen=True, slots=True)
class Stamp:
    """When and in which frame something was found out."""

    time_usec: int
    earth: bool


def health(state: events.State | None) -> values.Health:
    """Return the health of a component whose mission is in a state; None: it has not spoken yet."""
    if state is None:
        return values.Health.BOOT
    if state is events.State.FAULT:
        return values.Health.CRITICAL
    if state in MEASURING:
        return values.Health.CALIBRATING
    return values.Health.STANDBY if state in RESTING else values.Health.ACTIVE


def status(mission: MissionState, snapshot: Snapshot) -> values.Status:
    """Return the mission at a glance."""
    return values.Status(
        time_usec=snapshot.time_usec,
        mission_time=snapshot.mission_time,
        state=int(mission.state or events.State.IDLE),
        earth=snapshot.earth,
        outcome=None if mission.outcome is None else int(mission.outcome),
        heading=snapshot.heading,
        heading_goal=mission.goal,
        joint=snapshot.joint,
        joint_rate=snapshot.joint_rate,
        mount_yaw=snapshot.mount_yaw,
        score=mission.score,
        criterion=snapshot.criterion,
        rotation=mission.rotation,
        rotation_max=snapshot.rotation_max,
        k=None if mission.estimate is None else mission.estimate.k,
        target=mission.target,
        noise_measured=mission.noise_measured,
        certain=mission.estimate is not None and mission.estimate.certain,
        target_found=mission.target_found,
        time_unix=snapshot.unix,
        streaming=snapshot.streaming,
        recording=snapshot.recording,
        actuator_present=snapshot.present,
        settled=snapshot.settled,
        homed=snapshot.homed,
        fault=bool(snapshot.fault),
        open_loop=snapshot.open_loop,
    )


def sources(
    estimate: events.Estimate, number: int, stamp: Stamp, axis: float | None, final: bool
) -> list[values.Source]:
    """Return one value per source.

    ``axis`` [rad] is the only axis heard at so far, or None: a source at azimuth a that is not told from its mirror
    image may be at 2 axis - a instead.
    """
    return [
        values.Source(
            time_usec=stamp.time_usec,
            estimate=number,
            source=index,
            count=estimate.k,
            azimuth=source.azimuth,
            sigma=source.sigma,
            confidence=source.confidence,
            weight=source.weight,
            earth=stamp.earth,
            resolved=source.resolved,
            mirror=None if source.resolved or axis is None else wrap(2 * axis - source.azimuth),
            elevation=source.elevation,
            final=final,
        )
        for index, source in enumerate(estimate.sources)
    ]


def tracked(known: list[values.Source], event: events.SourcesTracked, stamp: Stamp) -> list[values.Source]:
    """Return the sources of the latest estimate where they are by now; the rest of what is known of them stays."""
    return [
        replace(
            source,
            time_usec=stamp.time_usec,
            azimuth=now.azimuth,
            mirror=None,
            sigma=now.sigma,
            confidence=now.confidence,
            weight=now.weight,
            resolved=now.resolved,
            elevation=now.elevation,
            earth=stamp.earth,
            tracked=True,
            rate=rate,
            age=age,
        )
        for source, now, rate, age in zip(known, event.estimate.sources, event.rates, event.ages, strict=False)
    ]


def reconsidered(known: list[values.Source], event: events.SourcesReconsidered, stamp: Stamp) -> list[values.Source]:
    """Return the sources of the latest estimate, each as sure as it is by now; the rest of what is known stays."""
    return [
        replace(source, time_usec=stamp.time_usec, confidence=now.confidence)
        for source, now in zip(known, event.estimate.sources, strict=False)
    ]


def moved(before: Sequence[values.Source], now: Sequence[values.Source]) -> bool:
    """Tell whether a source is elsewhere than before, or begins to be tracked."""
    apart = len(before) != len(now) or any(
        abs(difference(old.azimuth, new.azimuth)) > MOVED or old.tracked != new.tracked
        for old, new in zip(before, now, strict=False)
    )
    return bool(apart)


def common_axis(headings: Sequence[float]) -> float | None:
    """Return the axis [rad] that all headings [rad] share, modulo pi, or None.

    >>> common_axis([0.5, 0.5 + np.pi])
    0.5
    >>> common_axis([0.5, 0.8]) is None
    True
    """
    if not headings:
        return None
    apart = np.abs(difference(2 * np.asarray(headings), 2 * headings[0])) / 2
    return headings[0] if np.all(apart < ONE_AXIS) else None


def alignments(planned: events.AlignmentPlanned, number: int, stamp: Stamp) -> list[values.Alignment]:
    """Return one value per candidate, none of them tried yet."""
    return [
        values.Alignment(
            time_usec=stamp.time_usec,
            plan=number,
            candidate=index,
            count=len(planned.candidates),
            source=candidate.source,
            heading=candidate.heading,
            joint=candidate.joint,
            isolation=candidate.isolation,
            aliased=tuple(sorted(candidate.aliased)),
            rule=RULES.get(candidate.rule, values.Rule.UNKNOWN),
            state=values.CandidateState.PLANNED,
            earth=stamp.earth,
            gain=candidate.gain_db,
        )
        for index, candidate in enumerate(planned.candidates)
    ]


def separations(
    event: events.Checked | events.Separated, mission: MissionState, stamp: Stamp, criterion: float | None
) -> list[values.Separation]:
    """Return one value per separated group; without a score where nobody is enrolled."""
    checked = isinstance(event, events.Checked)
    heading = event.candidate.heading if isinstance(event, events.Checked) else event.heading
    return [
        values.Separation(
            time_usec=stamp.time_usec,
            separation=mission.separations,
            group=index,
            count=len(event.groups),
            phase=values.Phase.CHECK if checked else values.Phase.RUN,
            members=tuple(sorted(group.members)),
            method=event.method,
            earth=stamp.earth,
            heading=heading,
            score=group.value if mission.sought else None,
            criterion=criterion,
            si_sdr=group.si_sdr,
            si_sdri=group.si_sdri,
            accepted=group.accepted,
            target=index == chosen(event),
        )
        for index, group in enumerate(event.groups)
    ]


def verdict(checked: events.Checked) -> values.CandidateState:
    """Return what a check makes of its candidate: accepted when the target's group holds the isolated source."""
    if checked.accepted is None or checked.candidate.source not in checked.groups[checked.accepted].members:
        return values.CandidateState.REJECTED
    return values.CandidateState.ACCEPTED


def scored(
    known: list[values.Source], groups: tuple[events.GroupScore, ...], target: int | None
) -> list[values.Source]:
    """Return the sources with what a separation tells: the scores of those with a group of their own, the target."""
    scores = {group.members[0]: group.value for group in groups if len(group.members) == 1}
    return [
        replace(source, score=scores.get(source.source, source.score), target=source.source == target)
        for source in known
    ]


def densities(event: events.OrientationHeard, number: int, stamp: Stamp) -> list[values.Density]:
    """Return the curve of one orientation of exploration ``number``; none when nothing was heard."""
    if len(event.grid) < 2 or not event.density.max() > 0:
        return []
    return [
        values.Density(
            time_usec=stamp.time_usec,
            exploration=number,
            rotation=event.index,
            heading=event.heading,
            earth=stamp.earth,
            first=float(event.grid[0]),
            last=float(event.grid[-1]),
            density=shares(event.density, float(event.density.max())),
        )
    ]


def isolations(planned: events.AlignmentPlanned, number: int, stamp: Stamp) -> list[values.Isolation]:
    """Return one curve per source over the headings of a plan; none when nothing can be isolated."""
    if len(planned.headings) < 2 or not planned.isolation.max(initial=0.0) > 0:
        return []
    maximum = float(planned.isolation.max())
    return [
        values.Isolation(
            time_usec=stamp.time_usec,
            plan=number,
            source=source,
            earth=stamp.earth,
            first=float(planned.headings[0]),
            last=float(planned.headings[-1]),
            maximum=maximum,
            isolation=shares(curve, maximum),
        )
        for source, curve in enumerate(planned.isolation)
    ]


def shares(curve: events.Real, maximum: float, points: int = values.CURVE_POINTS) -> tuple[float, ...]:
    """Return a curve, (n,), at ``points`` equal steps from its first to its last point, as shares of ``maximum``.

    >>> shares(np.array([0.0, 2.0, 1.0]), 4.0, points=5)
    (0.0, 0.25, 0.5, 0.375, 0.25)
    """
    places = np.linspace(0, len(curve) - 1, points)
    return tuple((np.interp(places, np.arange(len(curve)), curve) / maximum).tolist())


def named(
    status: values.Status, sources: Sequence[values.Source], health: AudioHealth | None, time: float
) -> list[values.Named]:
    """Return the numbers that are known, for ground stations without our dialect; ``time`` is since boot [s].

    Angles are degrees, clockwise from 0 to 360, as on a compass: people read them.
    """
    heading = None if status.heading is None else compass(status.heading)
    target = next((compass(source.azimuth) for source in sources if source.target), None)
    numbers = {
        "ross_state": float(status.state),
        "ross_k": None if status.k is None else float(status.k),
        "ross_head": heading,
        "ross_tgt": target,
        "ross_score": status.score,
        "ross_level": None if health is None else max(health.level_db),
    }
    return [values.Named(time, name, number) for name, number in numbers.items() if number is not None]


def azimuths(time_usec: int, sources: Sequence[values.Source]) -> values.Array:
    """Return K and then the azimuth of every source."""
    return values.Array(time_usec, "ross_az", AZIMUTHS, (float(len(sources)), *(compass(s.azimuth) for s in sources)))
