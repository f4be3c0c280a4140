"""What the study of listening from above writes down, and the table of it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ross_sim.study.rows.intervals import mean_cell, rate_cell
from ross_sim.study.rows.tables import Table, grouped

HEADER = (
    "height, who walks, talkers over rotors",
    "all right",
    "talkers found",
    "azimuth error [deg]",
    "elevation error [deg]",
    "all right, height not told",
    "K 2 and 3: SI-SDR in [dB]",
    "out [dB]",
    "one talker: out [dB]",
)
ABOUT = "Rates and means with their 95 % intervals; errors are medians over the talkers found."


@dataclass(frozen=True, slots=True)
class AboveRow:
    """One scene explored, or one target of it separated."""

    height_m: float  # of the array above the mouths
    walk_m_s: float  # how fast everybody walks; 0: they stand
    ratio_db: float | None  # all talkers over the rotors at microphone 1; None: rotors off
    rotors: str  # recorded or synthetic
    ground: float  # reflection coefficient
    k: int
    layout: int
    seed: int
    told: bool  # whether the explorer knows the height
    target: int | None = None  # None: explored
    k_found: int | None = None
    within: int | None = None  # talkers within 10 degrees of where they are in the end
    azimuth_errors_deg: tuple[float, ...] = ()  # of those
    elevation_errors_deg: tuple[float, ...] = ()  # of those
    si_sdr_in_db: float | None = None
    si_sdr_out_db: float | None = None
    separator: str = ""  # empty: explored

    @property
    def right(self) -> bool:
        """K is right and everybody is near."""
        return self.k_found == self.k == self.within


def above(rows: Sequence[AboveRow]) -> Table:
    """One line for every height, walk and ratio; where there are several rotors, grounds, seeds or separators, of each.

    >>> above([]).rows
    ()
    """
    lines = []
    separators = [name for name in dict.fromkeys(row.separator for row in rows) if name] or [""]
    for (height, walk, ratio, *setup), group in grouped(rows, lambda row: (*_place(row), *_setup(row))).items():
        who = "all stand" if not walk else f"all walk at {walk:g} m/s"
        noise = "rotors off" if ratio is None else f"{ratio:g} dB"
        for separator in separators:
            told = _told([*setup, separator], [*zip(*map(_setup, rows), strict=True), separators])
            mine = [row for row in group if row.separator in ("", separator)]
            lines.append((", ".join([f"{height:g} m", who, noise, *told]), *_cells(mine)))
    return Table("Listening from above", HEADER, tuple(lines), ABOUT)


def _place(row: AboveRow) -> tuple[float, float, float | None]:
    return row.height_m, row.walk_m_s, row.ratio_db


def _setup(row: AboveRow) -> tuple[str, float, int]:
    return row.rotors, row.ground, row.seed


def _told(setup: Sequence[object], every: Sequence[Sequence[object]]) -> list[str]:
    """Those values of a setup in which the rows differ, in words."""
    words = ("{} rotors", "ground {:g}", "seed {}", "{}")
    return [word.format(own) for word, own, values in zip(words, setup, every, strict=True) if len(set(values)) > 1]


def _cells(rows: Sequence[AboveRow]) -> tuple[str, ...]:
    explored, parted = [row for row in rows if row.target is None], [row for row in rows if row.target is not None]
    told, untold = ([row for row in explored if row.told is told] for told in (True, False))
    several, alone = ([row for row in parted if (row.k > 1) is more] for more in (True, False))
    return (
        rate_cell(sum(row.right for row in told), len(told)),
        rate_cell(sum(row.within or 0 for row in told), sum(row.k for row in told)),
        _median(error for row in told for error in row.azimuth_errors_deg),
        _median(error for row in told for error in row.elevation_errors_deg),
        rate_cell(sum(row.right for row in untold), len(untold)),
        mean_cell(_values(row.si_sdr_in_db for row in several)),
        mean_cell(_values(row.si_sdr_out_db for row in several)),
        mean_cell(_values(row.si_sdr_out_db for row in alone)),
    )


def _values(values: Iterable[float | None]) -> list[float]:
    return [value for value in values if value is not None]


def _median(values: Iterable[float]) -> str:
    every = list(values)
    return f"{np.median(every):.1f}" if every else "-"
