"""One task of a study as a pure function: lay out talkers, explore, align, separate, score.

Everything random is seeded by the study's seed and the task: a task gives the same rows alone, in any order, and in
any process. An exploration is shared by all separators and targets.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from threadpoolctl import threadpool_limits

from ross_payload import __version__, plugins
from ross_payload.alignment.paper_rules import paper_plan
from ross_payload.alignment.plan import Turn, plan
from ross_payload.angles import difference
from ross_payload.dsp.steering import tdoa
from ross_payload.errors import RossError
from ross_payload.events import AlignmentCandidate, Estimate, SourceEstimate
from ross_payload.interfaces import Observation, Real, Separator, TurningExplorer
from ross_payload.localization.joint import Joint
from ross_sim.study.rows import result_rows
from ross_sim.study.rows.exploration_ends import STOP, stopped
from ross_sim.study.runs.exploration_course import Course, course_of
from ross_sim.study.runs.scoring import Belief, Separated, columns, scored, separations, tools_of
from ross_sim.study.runs.study_design import Study, Task, explorer_named
from ross_sim.study.runs.talker_placement import Source, TalkerPlacement, placed
from ross_sim.study.scenes.exploration import NEAR_DEG, matched
from ross_sim.study.scenes.mixtures import Mixture, record
from ross_sim.study.scenes.room_settings import SPACING, SPEED_OF_SOUND

PLANS = {"best": plan, "paper": paper_plan}
ANYWHERE = 1  # the noise at a start heading is another than at the alignments


@dataclass(frozen=True, slots=True, eq=False)
class _Case:
    """What the rows of a task share, and the rows so far."""

    study: Study
    task: Task
    stage: TalkerPlacement
    tools: Mapping[str, Separator]
    rows: list[result_rows.Separation] = field(default_factory=list)
    explorations: list[result_rows.Exploration] = field(default_factory=list)
    timings: list[result_rows.Timing] = field(default_factory=list)

    def timed(self, step: str, seconds: float, cpu: float) -> None:
        """Write down the CPU time of a step."""
        self.timings.append(
            result_rows.Timing(self.task.id, self.task.setting, self.task.k, step, seconds, round(cpu, 6))
        )

    def blank(self, target: int, how: str) -> result_rows.Separation:
        """A row about a target with nothing measured yet."""
        task, azimuth = self.task, result_rows.degrees(float(self.stage.azimuths[target]))
        row = result_rows.Separation(
            task.id, task.setting, task.k, task.layout, self.study.seed, __version__,
            how, target, self.stage.names[target], azimuth, explorer=task.explorer, unit_s=task.unit,
            turning_deg_s=task.rate,
        )  # fmt: skip
        if how == result_rows.ALIGNED:
            return row
        return replace(row, start=task.start, start_heading_deg=result_rows.degrees(self.study.start(task.start)))

    def record(self, target: int, heading: float, *seed: int) -> Mixture:
        """What is heard for T_run at a heading [rad]."""
        here, rng = self.stage, np.random.default_rng([self.study.seed, self.task.layout, *seed])
        return record(here.clips, here.azimuths, target, heading, here.setting, rng=rng, rate=self.study.rate_hz)

    def separations(self, recording: Mixture, belief: Belief) -> Iterator[Separated]:
        """What every separator makes of a recording."""
        for separated in separations(self.study, self.tools, recording, belief):
            self.timed(separated.separator, self.study.run_s, separated.cpu)
            yield separated

    def scored(
        self, row: result_rows.Separation, recording: Mixture, separated: Separated, source: int, heading: float
    ) -> result_rows.Separation:
        """Complete a row with what a separator made of a recording."""
        return scored(row, recording, separated, source=source, heading=heading, azimuths=self.stage.azimuths)


@dataclass(frozen=True, slots=True)
class Failure:
    """A task that could not be done."""

    task: str
    reason: str


def attempt(task: Task, study: Study, source: Source) -> result_rows.Result | Failure:
    """Measure one task; one that fails does not take the others with it."""
    try:
        return perform(task, study, source)
    except RossError as error:
        return Failure(task.id, str(error))
    except Exception as error:
        return Failure(task.id, repr(error))


def perform(task: Task, study: Study, source: Source) -> result_rows.Result:
    """Measure one task, on one numeric thread."""
    began, tools = time.process_time(), tools_of(study)
    with threadpool_limits(1):
        case = _Case(study, task, placed(study, source, task), tools)
        if task.explorer is not None:
            _explored(case, _explorer(study, task.explorer))
        elif task.target is not None:
            _aligned(case, task.target)
        else:
            _unaligned(case)
    case.timed("task", 0.0, time.process_time() - began)
    return result_rows.Result(task.id, tuple(case.rows), tuple(case.explorations), tuple(case.timings))


def _explorer(study: Study, name: str) -> TurningExplorer:
    """Make an explorer, checked; one of ours that is told K must be itself."""
    if study.tell_k:
        told: TurningExplorer = plugins.load("ross_payload.explorers", name).make(SPACING, SPEED_OF_SOUND)
        return told
    return explorer_named(name)


def _aligned(case: _Case, target: int) -> None:
    """Separate one target at its own alignment, with true azimuths; the open is told from reverberation."""
    truth = [SourceEstimate(float(azimuth), 0.0, 1.0, True) for azimuth in case.stage.azimuths]
    known = Estimate(tuple(truth), directness=float(case.stage.setting.t60 == 0))
    row, candidate = case.blank(target, result_rows.ALIGNED), _candidates(case.study, known, 0.0, 0.0).get(target)
    if candidate is None:
        case.rows.extend(_missed(case.study, row, oracles=True))
        return
    row, recording = replace(row, rule=candidate.rule), case.record(target, candidate.heading, target)
    for separated in case.separations(recording, Belief(recording.tau)):
        case.rows.append(case.scored(row, recording, separated, target, candidate.heading))


def _unaligned(case: _Case) -> None:
    """Separate every target at a start heading, with true azimuths."""
    heading = case.study.start(case.task.start)
    recording = case.record(0, heading, case.task.start, ANYWHERE)
    for separated in case.separations(recording, Belief(recording.tau)):
        for target in range(case.task.k):
            aimed, row = replace(recording, target=target), case.blank(target, result_rows.UNALIGNED)
            case.rows.append(case.scored(row, aimed, separated, target, heading))


def _explored(case: _Case, explorer: TurningExplorer) -> None:
    """Explore once; separate after every schedule."""
    course = course_of(case.study, case.task, case.stage)
    estimates = list(_estimates(case, explorer, course))
    headings = course.headings
    for r, estimate in enumerate(estimates):
        case.explorations.append(_exploration(case, r, course, estimate))
    found: dict[int, list[result_rows.Separation]] = {}
    for schedule in case.study.rotations if case.tools else ():
        r = stopped([estimate.certain for estimate in estimates]) if schedule == STOP else int(schedule)
        r = min(r, len(estimates) - 1)
        if r not in found:
            found[r] = list(_end_to_end(case, estimates[r], r, float(headings[r])))
        case.rows.extend(replace(row, schedule=str(schedule)) for row in found[r])


def _estimates(case: _Case, explorer: TurningExplorer, course: Course) -> Iterator[Estimate]:
    """What the explorer believes after every orientation; nobody tells the noise, nor K unless the study does."""
    study, task = case.study, case.task
    observations: list[Observation] = []
    heard = course.observed_by(explorer)
    began = time.process_time()
    for observation in heard:
        observations.append(observation)
        if study.tell_k and isinstance(explorer, Joint):
            yield explorer.place(observations, task.k)
        else:
            yield explorer.estimate(observations)
    case.timed(explorer.name, float(task.unit or 0.0) * len(course.times), time.process_time() - began)


def _exploration(case: _Case, r: int, course: Course, estimate: Estimate) -> result_rows.Exploration:
    task, errors = case.task, matched(case.stage.azimuths, estimate)[0]
    return result_rows.Exploration(
        task.id, task.setting, task.k, task.layout, case.study.seed, __version__,
        task.start, result_rows.degrees(case.study.start(task.start)), str(task.explorer), float(task.unit or 0.0),
        r, result_rows.degrees(float(course.headings[r])), case.stage.names,
        azimuths_true_deg=tuple(result_rows.degrees(float(azimuth)) for azimuth in case.stage.azimuths),
        azimuths_deg=tuple(result_rows.degrees(source.azimuth) for source in estimate.sources),
        sigmas_deg=tuple(result_rows.degrees(source.sigma) for source in estimate.sources),
        confidences=tuple(round(source.confidence, 4) for source in estimate.sources),
        errors_deg=tuple(round(float(error), 6) for error in errors),
        k_estimated=estimate.k, all_found=bool(errors.max() <= NEAR_DEG),
        certain=estimate.certain, directness=result_rows.number(estimate.directness),
        turning_deg_s=task.rate, time_s=round(float(course.times[r]), 2),
    )  # fmt: skip


def _end_to_end(case: _Case, estimate: Estimate, rotations: int, heading: float) -> Iterator[result_rows.Separation]:
    """Align with estimated azimuths and separate every target that is found; the missed ones count as 0 dB."""
    joint = heading - case.study.start(case.task.start)
    candidates = _candidates(case.study, estimate, heading, joint)
    owners = owners_of(case.stage.azimuths, estimate)
    for target, owner in enumerate(owners):
        row = replace(
            case.blank(target, result_rows.ESTIMATED), rotations=rotations, k_estimated=estimate.k,
            all_found=None not in owners, directness=result_rows.number(estimate.directness),
        )  # fmt: skip
        candidate = None if owner is None else candidates.get(owner)
        if owner is None or candidate is None:
            yield from _missed(case.study, row, oracles=False)
            continue
        row = replace(row, azimuth_deg=result_rows.degrees(estimate.sources[owner].azimuth), rule=candidate.rule)
        recording = case.record(target, candidate.heading, target)
        belief = Belief(_tau(estimate, candidate.heading), true=False)
        for separated in case.separations(recording, belief):
            yield case.scored(row, recording, separated, owner, candidate.heading)


def owners_of(azimuths: Real, estimate: Estimate) -> list[int | None]:
    """Which estimated source is in the place of every talker (k,): the nearest within 10 deg, or None."""
    apart = np.rad2deg(np.abs(difference(azimuths[:, None], estimate.azimuths)))
    return [int(row.argmin()) if row.min(initial=np.inf) <= NEAR_DEG else None for row in apart]


def _candidates(study: Study, estimate: Estimate, heading: float, joint: float) -> dict[int, AlignmentCandidate]:
    """Where to turn for every source, as the mission plans it."""
    limit = float(np.deg2rad(study.limit_deg))
    turn = Turn(heading - joint, joint, -limit, limit)
    planned = PLANS[study.rules](estimate.sources, turn, SPACING / SPEED_OF_SOUND, estimate.directness)
    return {candidate.source: candidate for candidate in planned.candidates}


def _tau(estimate: Estimate, heading: float) -> Real:
    return tdoa(estimate.azimuths, heading, SPACING, SPEED_OF_SOUND, estimate.elevations)


def _missed(study: Study, row: result_rows.Separation, *, oracles: bool) -> Iterator[result_rows.Separation]:
    """A row of 0 dB for every separator that would have been asked."""
    for name, noise in columns(study, oracles=oracles):
        yield replace(row, separator=name, noise=noise, missed=True)
