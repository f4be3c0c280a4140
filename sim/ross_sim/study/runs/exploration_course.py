"""How an array explores in a study: step by step, or without a pause; where it is when, and what is observed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from ross_payload.actuators.motion import Trapezoid
from ross_payload.config import Guard
from ross_payload.interfaces import Observation, Real, TurningExplorer
from ross_sim.clock import QUANTUM
from ross_sim.study.runs.study_design import Study, Task
from ross_sim.study.runs.talker_placement import TalkerPlacement
from ross_sim.study.scenes.exploration import observed, render
from ross_sim.study.scenes.turning_render import SETTLING_S, Turning, observed_turning, render_turning


@dataclass(frozen=True, slots=True, eq=False)
class Course:
    """One exploration."""

    headings: Real  # where the array is after every orientation, or every T_unit [rad], (n,)
    times: Real  # when that is, since the exploration began [s], (n,)
    observed_by: Callable[[TurningExplorer], Iterator[Observation]]  # renders it, and lets an explorer hear it


def course_of(study: Study, task: Task, stage: TalkerPlacement) -> Course:
    """How a task explores; who talks, where, and from where in their recordings on does not depend on that."""
    return _stepping(study, task, stage) if not task.rate else _turning(study, task, stage)


def _stepping(study: Study, task: Task, stage: TalkerPlacement) -> Course:
    """T_unit of rest at every heading; what is heard while it turns is not listened to."""
    unit, turns = float(task.unit or 0.0), np.arange(study.last + 1)
    headings = study.start(task.start) + study.step * turns
    times = unit * (turns + 1) + (step_duration(study.step) + SETTLING_S) * turns

    def observed_by(explorer: TurningExplorer) -> Iterator[Observation]:
        rng = random_of(study, task)
        heard = render(stage.speech, stage.azimuths, stage.setting, headings, rng, seconds=unit, rate=study.rate_hz)
        return observed(explorer, study.explorer_stft, heard, headings)

    return Course(headings, times, observed_by)


def _turning(study: Study, task: Task, stage: TalkerPlacement) -> Course:
    """To and fro without a pause, from rest on."""
    unit = float(task.unit or 0.0)
    times = unit * np.arange(1, study.periods(task.rate, unit) + 1)
    path = study.start(task.start) + Turning(float(np.deg2rad(task.rate))).headings(float(times[-1]))

    def observed_by(explorer: TurningExplorer) -> Iterator[Observation]:
        rng = random_of(study, task)
        heard = render_turning(stage.speech, stage.azimuths, stage.setting, path, rng, rate=study.rate_hz)
        return observed_turning(explorer, study.explorer_stft, heard, path, unit)

    return Course(path[np.round(times / QUANTUM).astype(int)], times, observed_by)


def random_of(study: Study, task: Task) -> np.random.Generator:
    """What an exploration draws with: the same however it explores."""
    return np.random.default_rng([study.seed, task.k, task.layout, task.start])


def step_duration(angle: float) -> float:
    """How long a turn by an angle [rad] takes from rest to rest, as fast as the guard allows by default [s].

    >>> round(step_duration(np.deg2rad(15.0)), 3)
    0.73
    """
    guard = Guard()
    speed, acceleration = math.radians(guard.max_speed_deg_s), math.radians(guard.max_acceleration_deg_s2)
    return Trapezoid(0.0, angle, speed, acceleration).duration
