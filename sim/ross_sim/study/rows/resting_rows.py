"""Talkers who rest: what the tracker said of one scene, and the table of how often that was wrong."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ross_sim.study.rows.intervals import rate_cell
from ross_sim.study.rows.tables import Table, grouped
from ross_sim.study.scenes.room_settings import SETTINGS

HEADER = ("", "false moves", "share of the time", "farthest [deg]")


@dataclass(frozen=True, slots=True)
class RestingRow:
    """One scene in which nobody moves."""

    setting: str
    k: int
    seed: int
    explored: bool  # azimuths and directness are those of an exploration; else azimuths alone are told
    moved_at_s: float | None  # when the tracker first said that somebody has moved
    share: float  # of the corrections after which somebody was said to have moved
    worst_deg: float  # farthest that such a track was from where its talker rested


def resting(rows: Sequence[RestingRow]) -> Table:
    """Scenes in which somebody was said to have moved, by what is known at the start, room and K."""
    lines = []
    for explored, part in grouped(rows, lambda row: row.explored).items():
        start = "explored" if explored else "told"
        for (setting, k), group in grouped(part, lambda row: (row.setting, row.k)).items():
            lines.append((f"{start}, {setting}, K = {k}", *_cells(group)))
        true = [row for row in part if len(SETTINGS[row.setting].size) == 3]
        if true:
            lines.append((f"{start}, true rooms", *_cells(true)))
        lines.append((f"{start}, all", *_cells(part)))
    about = "Scenes in which the tracker said that somebody has moved, where nobody did; 95 % intervals."
    return Table("Talkers at rest", HEADER, tuple(lines), about)


def _cells(rows: Sequence[RestingRow]) -> tuple[str, ...]:
    wrong = sum(row.moved_at_s is not None for row in rows)
    share, worst = np.mean([row.share for row in rows]), max(row.worst_deg for row in rows)
    return rate_cell(wrong, len(rows)), f"{share:.2f}", f"{worst:.0f}"
