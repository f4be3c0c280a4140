"""Talkers who move: one mission each, and the table of how well they are followed and what that costs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ross_payload.interfaces import Real
from ross_sim.study.rows.tables import Table, grouped

HEADER = (
    "",
    "missions",
    "walker, rms [deg]",
    "median",
    "up to 5 deg",
    "others",
    "within 15 deg",
    "error / sigma",
    "turns",
    "new explorations",
    "lost [dB]",
    "median",
)
WANTED_DEG = 5.0  # root mean square of a walker's azimuth


@dataclass(frozen=True, slots=True)
class MovingRow:
    """One mission, and the same with known azimuths."""

    setting: str
    speed_deg_s: float
    seed: int
    k: int
    start: str  # azimuths are true, or explored
    walker: str  # name
    walker_is_target: bool
    walker_rms_deg: float  # of the azimuth while it walks
    others_rms_deg: float
    normalised: float  # root mean square of the walker's errors over their sigmas
    followed: float  # share of the time in which the walker's error is below 15 deg
    turns: int  # while listening
    explorations: int  # new ones while somebody walks
    si_sdr_db: float | None  # mean over the periods while somebody walks; None: not measured
    known_si_sdr_db: float | None  # the same with known azimuths

    @property
    def lost_db(self) -> float:
        """What is lost against known azimuths; not a number where that was not measured."""
        if self.si_sdr_db is None or self.known_si_sdr_db is None:
            return math.nan
        return self.known_si_sdr_db - self.si_sdr_db


def moving(rows: Sequence[MovingRow]) -> Table:
    """A line for every start, room and speed."""
    lines = []
    for (start, setting, speed), group in grouped(rows, lambda row: (row.start, row.setting, row.speed_deg_s)).items():
        errors, lost = np.array([row.walker_rms_deg for row in group]), np.array([row.lost_db for row in group])
        cells = (
            f"{len(group)}",
            f"{rms(errors):.1f}",
            f"{np.median(errors):.1f}",
            f"{int((errors <= WANTED_DEG).sum())}",
            f"{rms(np.array([row.others_rms_deg for row in group])):.1f}",
            f"{100 * np.mean([row.followed for row in group]):.0f} %",
            f"{rms(np.array([row.normalised for row in group])):.2f}",
            f"{np.mean([row.turns for row in group]):.1f}",
            f"{sum(row.explorations for row in group)}",
            *("-" if np.isnan(lost).all() else f"{value:.1f}" for value in (np.mean(lost), np.median(lost))),
        )
        lines.append((f"{'explored, ' if start == 'explored' else ''}{setting}, {speed:g} deg/s", *cells))
    about = "Azimuths are those of the tracks while somebody walks; lost: against a tracker that is told the truth."
    return Table("Talkers who move", HEADER, tuple(lines), about)


def rms(values: Real) -> float:
    """Root mean square; not a number of nothing."""
    return float(np.sqrt(np.mean(np.asarray(values, dtype=float) ** 2))) if len(values) else math.nan
