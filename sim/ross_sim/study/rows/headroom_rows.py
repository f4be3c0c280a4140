"""What a mission computes per second of sound, in every state that it is in: rows and their table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ross_sim.study.rows.tables import Table, grouped

WORDS = {
    "LEAD_IN": "before anything turns",
    "EXPLORE_TURN": "exploring, while it turns",
    "EXPLORE_LISTEN": "exploring, while it listens, and recalling voices at its end",
    "ALIGN_TURN": "turning to the alignment",
    "CHECK": "checking who is heard there",
    "RUN": "listening to the target",
}


@dataclass(frozen=True, slots=True)
class HeadroomRow:
    """One state of one mission."""

    scenario: str
    seed: int
    state: str
    audio_s: float
    cpu_s: float
    longest_s: float  # CPU time over one hop


def headroom(rows: Sequence[HeadroomRow]) -> Table:
    """CPU time per second of sound, and the longest single computation of all missions, by state.

    >>> headroom([HeadroomRow("demo", seed, "RUN", 10.0, 0.5 + seed, 0.3) for seed in (0, 1)]).rows
    (('listening to the target', '0.100', '0.30'), ('all of it', '0.100', '0.30'))
    """
    lines = [(WORDS[state], *_cells(group)) for state, group in grouped(rows, lambda row: row.state).items()]
    header = ("state", "seconds per second", "longest [s]")
    return Table("Headroom", header, (*lines, ("all of it", *_cells(rows))), "CPU time of the mission's threads.")


def _cells(rows: Sequence[HeadroomRow]) -> tuple[str, str]:
    share = sum(row.cpu_s for row in rows) / sum(row.audio_s for row in rows)
    return f"{share:.3f}", f"{max(row.longest_s for row in rows):.2f}"
