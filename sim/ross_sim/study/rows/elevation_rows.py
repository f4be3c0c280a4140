"""Talkers below the array: one exploration each, and the table of how well they are found and separated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ross_sim.study.rows.intervals import mean_cell, rate_cell
from ross_sim.study.rows.tables import Table, grouped
from ross_sim.study.scenes.exploration import NEAR_DEG

HEADER = (
    "",
    "K right",
    "all right",
    "error [deg]",
    "elevation within 10 deg",
    "its error [deg]",
    "SI-SDRi [dB], true places",
    "estimated",
    "estimated azimuths alone",
)


@dataclass(frozen=True, slots=True)
class ElevationRow:
    """One layout, explored; errors are those of the talkers where all are found, else there are none."""

    field: str  # level or above
    k: int
    layout: int
    seed: int
    rotations: int
    k_estimated: int
    azimuth_errors_deg: tuple[float, ...]
    elevation_errors_deg: tuple[float, ...]  # an elevation that is not told counts as 0
    true_db: tuple[float, ...]  # SI-SDRi of every talker by the true places, where it was separated
    estimated_db: tuple[float, ...]  # by the estimated ones
    azimuths_db: tuple[float, ...]  # by the estimated azimuths alone


def below(rows: Sequence[ElevationRow]) -> Table:
    """A line for every number of rotations and field."""
    lines = []
    several = len({row.rotations for row in rows}) > 1
    for (rotations, field), group in grouped(rows, lambda row: (row.rotations, row.field)).items():
        name = {"level": "as high as the array", "above": "below"}[field]
        azimuth = np.array([error for row in group for error in row.azimuth_errors_deg])
        elevation = np.array([error for row in group for error in row.elevation_errors_deg])
        cells = (
            rate_cell(sum(row.k_estimated == row.k for row in group), len(group)),
            rate_cell(sum(bool(row.azimuth_errors_deg) for row in group), len(group)),
            f"{azimuth.mean():.2f}" if azimuth.size else "-",
            rate_cell(int((elevation <= NEAR_DEG).sum()), elevation.size),
            f"{elevation.mean():.2f}" if elevation.size else "-",
            *(
                mean_cell([gain for row in group for gain in getattr(row, name)], 2)
                for name in ("true_db", "estimated_db", "azimuths_db")
            ),
        )
        lines.append((f"{name}, {rotations} rotations" if several else name, *cells))
    about = f"All right: K is right and every azimuth is within {NEAR_DEG:g} deg; errors are those of these scenes."
    return Table("Below the array", HEADER, tuple(lines), about)
