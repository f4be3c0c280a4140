"""What a simulated mission is worth: found against true azimuths, and SI-SDR before and after."""

from __future__ import annotations

import math
import platform
from collections.abc import Sequence
from dataclasses import dataclass, field
from importlib.metadata import version
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from ross_payload.angles import difference, wrap
from ross_payload.dsp.metrics import si_sdr
from ross_payload.events import (
    AlignmentCandidate,
    AlignmentPlanned,
    Checked,
    Event,
    Finished,
    GroupScore,
    OrientationHeard,
    Separated,
    Slipped,
    SourceEstimate,
    SourcesEstimated,
    SourcesReconsidered,
)
from ross_payload.interfaces import Real, Result, Samples
from ross_sim.talkers.path import Path

PACKAGES = ("ross-payload", "numpy", "scipy", "pymavlink", "pyroomacoustics")


@dataclass(frozen=True, slots=True)
class Truth:
    """What the simulator knows and the payload does not."""

    names: tuple[str, ...]
    azimuths: Real  # [rad], (n_talkers,)
    elevations: Real  # [rad], (n_talkers,)
    images: Samples  # every talker alone at microphone 1, (n_talkers, n_samples)
    mixture: Samples  # at microphone 1, (n_samples,)
    target: str
    walks: tuple[Path, ...] = ()  # of every talker, mount frame; none when nobody moves
    yaw: float = 0.0  # of the mount frame in the frame of the azimuths [rad]

    def azimuths_at(self, time: float) -> Real:
        """Return the azimuth of every talker at a mission time [s], in (-pi, pi] [rad], (n_talkers,)."""
        if not self.walks:
            return self.azimuths
        return np.array([wrap(float(walk.place(time)[0]) + self.yaw) for walk in self.walks])


@dataclass(slots=True)
class EventLog:
    """The events of a mission, as they are needed afterwards."""

    events: list[Event] = field(default_factory=list)
    earth: bool = False  # its headings and azimuths count from north, not from the zero of the mount

    def last(self, kind: type[Event]) -> Any:
        """Return the last event of a kind, or None."""
        return next((event for event in reversed(self.events) if isinstance(event, kind)), None)

    def all(self, kind: type[Event]) -> list[Any]:
        """Return all events of a kind."""
        return [event for event in self.events if isinstance(event, kind)]

    def estimated_before(self, event: Event) -> SourcesEstimated | None:
        """Return the estimate that held when an event came: its sources are those that the event counts."""
        place = next(index for index, each in enumerate(self.events) if each is event)
        return next((each for each in reversed(self.events[:place]) if isinstance(each, SourcesEstimated)), None)


@dataclass(frozen=True, slots=True)
class GroupQuality:
    """One separated group against the truth."""

    names: tuple[str, ...]  # the true talkers in it
    score: float
    accepted: bool
    si_sdr: float | None  # [dB]
    si_sdri: float | None  # [dB]


def match(sources: Sequence[SourceEstimate], azimuths: Real) -> dict[int, int]:
    """Pair found sources with talkers so that the azimuth errors are least in sum: {source: talker}."""
    if not sources or not len(azimuths):
        return {}
    found = np.array([source.azimuth for source in sources])
    cost = np.abs(difference(found[:, None], azimuths[None]))
    return {int(i): int(k) for i, k in zip(*linear_sum_assignment(cost), strict=True)}


def qualities(event: Separated, estimated: SourcesEstimated | None, truth: Truth) -> list[GroupQuality]:
    """SI-SDR and its improvement of every group of one T_run, against the sum of the images of its talkers.

    ``estimated`` is the estimate whose sources the groups hold.
    """
    pairs = {} if estimated is None else match(estimated.estimate.sources, truth.azimuths_at(estimated.time))
    span = slice(event.start, event.start + event.voices.shape[1])
    return [
        _quality(group, voice, [pairs[m] for m in group.members if m in pairs], truth, span)
        for group, voice in zip(event.groups, event.voices, strict=True)
    ]


def _quality(group: GroupScore, voice: Real, talkers: list[int], truth: Truth, span: slice) -> GroupQuality:
    names = tuple(truth.names[k] for k in talkers)
    reference = truth.images[talkers, span].sum(axis=0, dtype=np.float64)
    if not talkers or not np.any(reference) or not np.any(voice):
        return GroupQuality(names, group.value, group.accepted, None, None)
    after = float(si_sdr(voice, reference))
    before = float(si_sdr(truth.mixture[span], reference))
    return GroupQuality(names, group.value, group.accepted, after, after - before)


def report(log: EventLog, truth: Truth, result: Result, configuration: dict[str, Any]) -> dict[str, Any]:
    """Everything worth keeping, as plain values: no paths, no timings, the same on every rerun."""
    estimated: SourcesEstimated | None = log.last(SourcesEstimated)
    sources, time = (_as_sure_as_now(log, estimated), estimated.time) if estimated else ((), 0.0)
    return {
        "outcome": result.outcome.name.lower(),
        "reason": result.reason,
        "target": truth.target,
        "frame": "earth" if log.earth else "mount",
        "k_true": len(truth.names),
        "k": len(sources),
        "rotations": estimated.rotations if estimated else 0,
        "informed": estimated.informed if estimated else False,
        "heard_from_s": _heard_from(log, configuration["payload"]["audio"]["rate_hz"]),
        "right_from_s": right_from(log, truth, configuration["payload"]["audio"]["rate_hz"]),
        "mission_s": _round(log.last(Finished).time if log.last(Finished) else None, 3),
        "restarts": max(sum(event.index == 0 for event in log.all(OrientationHeard)) - 1, 0),
        "sources": _sources(sources, truth, time),
        "missed": _missed(sources, truth, time),
        "slips_deg": [_round(math.degrees(event.shift), 2) for event in log.all(Slipped)],
        "alignment": _alignment(log),
        "checks": [_check(event) for event in log.all(Checked)],
        "groups": _groups(log, truth),
        "versions": {name: version(name) for name in PACKAGES} | {"python": platform.python_version()},
        "configuration": configuration,
    }


def _heard_from(log: EventLog, rate: int) -> float | None:
    separated: Separated | None = log.last(Separated)
    return None if separated is None else _round(separated.start / rate, 3)


def right_from(log: EventLog, truth: Truth, rate: int) -> float | None:
    """When the first T_run began whose target sounds more like the true one than like any other talker [s], or None.

    Likeness is the correlation with every talker's image at microphone 1, which the SI-SDR grows with.
    """
    if truth.target not in truth.names:
        return None
    for event in log.all(Separated):
        voice = np.asarray(event.voices[event.target], np.float64)
        images = truth.images[:, event.start : event.start + voice.size].astype(np.float64)
        alike = np.abs(images @ voice) / np.maximum(np.linalg.norm(images, axis=1), np.finfo(float).tiny)
        if alike.any() and truth.names[int(alike.argmax())] == truth.target:
            return _round(event.start / rate, 3)
    return None


def _as_sure_as_now(log: EventLog, estimated: SourcesEstimated) -> tuple[SourceEstimate, ...]:
    """The sources of the last estimate, with confidences by all that was heard."""
    again: SourcesReconsidered | None = log.last(SourcesReconsidered)
    told = again is not None and log.events.index(again) > log.events.index(estimated)
    return again.estimate.sources if again is not None and told else estimated.estimate.sources


def _sources(sources: Sequence[SourceEstimate], truth: Truth, time: float) -> list[dict[str, Any]]:
    azimuths = truth.azimuths_at(time)
    pairs = match(sources, azimuths)
    rows = []
    for index, source in enumerate(sources):
        talker = pairs.get(index)
        true = None if talker is None else float(azimuths[talker])
        error = None if true is None else math.degrees(wrap(source.azimuth - true))
        rows.append(
            {
                "name": None if talker is None else truth.names[talker],
                "azimuth_true_deg": None if true is None else _degrees(true),
                "azimuth_deg": _degrees(source.azimuth),
                "azimuth_error_deg": _round(error, 3),
                "sigma_deg": _degrees(source.sigma),
                "elevation_true_deg": None if talker is None else _degrees(float(truth.elevations[talker])),
                "elevation_deg": None if source.elevation is None else _degrees(source.elevation),
                "confidence": _round(source.confidence, 4),
                "front_back_resolved": source.resolved,
            }
        )
    return rows


def _missed(sources: Sequence[SourceEstimate], truth: Truth, time: float) -> list[dict[str, Any]]:
    azimuths = truth.azimuths_at(time)
    found = set(match(sources, azimuths).values())
    return [
        {"name": name, "azimuth_true_deg": _degrees(float(azimuths[k]))}
        for k, name in enumerate(truth.names)
        if k not in found
    ]


def _alignment(log: EventLog) -> dict[str, Any] | None:
    separated: Separated | None = log.last(Separated)
    checked: Checked | None = log.last(Checked)
    planned: AlignmentPlanned | None = log.last(AlignmentPlanned)
    if planned is None:
        return None
    used: AlignmentCandidate | None = checked.candidate if checked else None
    return {
        "used": None if used is None or separated is None else _candidate(used),
        "candidates": [_candidate(candidate) for candidate in planned.candidates],
    }


def _candidate(candidate: AlignmentCandidate) -> dict[str, Any]:
    return {
        "source": candidate.source,
        "heading_deg": _degrees(candidate.heading),
        "joint_deg": _degrees(candidate.joint),
        "isolation_us": _round(candidate.isolation * 1e6, 2),
        "rule": candidate.rule,
        "aliased": list(candidate.aliased),
    }


def _check(event: Checked) -> dict[str, Any]:
    return {
        "time_s": _round(event.time, 3),
        "candidate": event.candidate.source,
        "separator": event.method,
        "why": event.why,
        "scores": [{"sources": list(group.members), "score": _round(group.value, 3)} for group in event.groups],
        "accepted": event.accepted,
    }


def _groups(log: EventLog, truth: Truth) -> list[dict[str, Any]]:
    separated: Separated | None = log.last(Separated)
    if separated is None:
        return []
    found = qualities(separated, log.estimated_before(separated), truth)
    return [
        {
            "talkers": list(quality.names),
            "sources": list(group.members),
            "target": index == separated.target,
            "score": _round(quality.score, 3),
            "accepted": quality.accepted,
            "si_sdr_db": _round(quality.si_sdr, 2),
            "si_sdri_db": _round(quality.si_sdri, 2),
            "si_sdri_estimated_db": _round(group.si_sdri, 2),
            "separator": separated.method,
            "why": separated.why,
        }
        for index, (group, quality) in enumerate(zip(separated.groups, found, strict=True))
    ]


def orientations(log: EventLog) -> list[OrientationHeard]:
    """Return the orientations of the last exploration only."""
    heard: list[OrientationHeard] = []
    for event in log.all(OrientationHeard):
        heard = [event] if event.index == 0 else [*heard, event]
    return heard


def _degrees(angle: float) -> float:
    return round(math.degrees(angle), 3)


def _round(value: float | None, digits: int) -> float | None:
    return None if value is None or not math.isfinite(value) else round(float(value), digits)
