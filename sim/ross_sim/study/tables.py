"""The tables of a study, from its rows: as Markdown, and for the terminal."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from rich.markup import escape
from rich.table import Table as Screen

from ross_payload.terminal_tables import with_whole_words
from ross_sim.study.exploration import NEAR_DEG
from ross_sim.study.result_rows import ALIGNED, ESTIMATED, UNALIGNED, Exploration, Separation
from ross_sim.study.study_case import stopped
from ross_sim.study.study_design import STOP, Study

Row = TypeVar("Row")
Key = TypeVar("Key", bound=Hashable)


@dataclass(frozen=True, slots=True)
class Table:
    """A table in words."""

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    about: str = ""

    def markdown(self) -> str:
        """Write it as Markdown."""
        return f"## {self.title}\n\n{self.about}\n\n{self.body()}\n"

    def body(self) -> str:
        """Write the cells alone as Markdown."""
        lines = [self.header, tuple("---" if i == 0 else "---:" for i in range(len(self.header))), *self.rows]
        return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)

    def screen(self) -> Screen:
        """Lay it out for a terminal."""
        table = Screen(title=self.title, title_justify="left", caption=self.about or None, caption_justify="left")
        for index, name in enumerate(self.header):
            table.add_column(escape(name), justify="left" if index == 0 else "right")
        for cells in self.rows:
            table.add_row(*map(escape, cells))
        return with_whole_words(table)


def tables(study: Study, separations: Sequence[Separation], explorations: Sequence[Exploration]) -> list[Table]:
    """Every table that the rows allow."""
    made = []
    if separations:
        made.append(gains(separations))
    if any(row.how == ESTIMATED for row in separations):
        made.append(losses(separations))
    if explorations:
        made.append(finds(study.rotations, explorations))
    return made


def grouped(rows: Iterable[Row], key: Callable[[Row], Key]) -> dict[Key, list[Row]]:
    """Rows by a key, in the order in which the keys appear."""
    found: dict[Key, list[Row]] = defaultdict(list)
    for row in rows:
        found[key(row)].append(row)
    return dict(found)


def mean(rows: Iterable[Separation]) -> float:
    """Mean SI-SDRi [dB]; not a number when there is no row."""
    values = [row.si_sdri_db for row in rows]
    return float(np.mean(values)) if values else float("nan")


def tool(row: Separation) -> str:
    """A separator and what it knows of the noise, as a column is called."""
    return row.separator if row.noise == "known" else f"{row.separator}, noise unknown"


def gains(rows: Sequence[Separation]) -> Table:
    """Mean SI-SDRi of every setting, K and separator: aligned / end to end, all found / end to end, all / unaligned."""
    names = tuple(grouped(rows, tool))
    lines = []
    for (setting, k), group in grouped(rows, lambda row: (row.setting, row.k)).items():
        by_name = grouped(group, tool)
        lines.append((f"{setting}, K = {k}", *(_gains(by_name.get(name, [])) for name in names)))
    about = (
        "dB: aligned with true azimuths / aligned with estimated azimuths where every talker was found / "
        "the same everywhere, a missed target counted as 0 dB / not aligned, at the start headings."
    )
    return Table("Mean SI-SDRi", ("", *names), tuple(lines), about)


def _gains(rows: Sequence[Separation]) -> str:
    by = grouped(rows, lambda row: row.how)
    estimated = by.get(ESTIMATED, [])
    parts = [by.get(ALIGNED, []), [row for row in estimated if row.all_found], estimated, by.get(UNALIGNED, [])]
    return " / ".join(f"{mean(part):.1f}" if part else "-" for part in parts)


def losses(rows: Sequence[Separation]) -> Table:
    """What estimating the azimuths costs, over the targets of scenes in which every talker was found."""
    true = {_scene(row): row.si_sdri_db for row in rows if row.how == ALIGNED}
    estimated = [row for row in rows if row.how == ESTIMATED and _scene(row) in true]
    names = tuple(grouped(estimated, tool))
    lines = []
    for label, group in grouped(estimated, lambda row: _effort(row.setting, row)).items():
        found = [row for row in group if row.all_found]
        shares = f"{np.mean([bool(row.all_found) for row in group]):.2f}"
        by_name = grouped(found, tool)
        cells = [[true[_scene(row)] - row.si_sdri_db for row in by_name.get(name, [])] for name in names]
        lines.append((label, shares, *(f"{np.mean(cell):.2f}" if cell else "-" for cell in cells)))
    about = "dB that are lost by estimated instead of true azimuths, over the scenes in which every talker was found."
    return Table("Loss end to end", ("", "all found", *names), tuple(lines), about)


def _scene(row: Separation) -> tuple[Hashable, ...]:
    return row.setting, row.k, row.layout, row.target, row.separator, row.noise


def _effort(setting: str, row: Separation) -> str:
    return f"{setting}, K = {row.k}, {row.explorer}, {row.unit_s:g} s, {row.schedule}"


def finds(schedules: Sequence[int | str], rows: Sequence[Exploration]) -> Table:
    """How well the explorer counts and places talkers after every schedule: a number of rotations, or ``stop``."""
    counts = sorted({row.k for row in rows})
    lines = []
    for label, group in grouped(rows, lambda row: (row.explorer, row.unit_s, row.setting, row.turning_deg_s)).items():
        explorer, unit, setting, rate = label
        explored = grouped(group, lambda row: row.task).values()
        turning = f"{rate:g} deg/s, " if rate else ""
        for schedule in schedules:
            ends = [row for task in explored for row in _after(task, schedule)]
            if ends:
                lines.append((f"{setting}, {explorer}, {unit:g} s, {turning}{schedule}", *_finds(ends, counts)))
    by_k = tuple(f"K = {k}" for k in counts)
    header = ("", "rotations", "K right", "all right", "recall", "error [deg]", *by_k)
    about = f"All right: K is right and every talker is within {NEAR_DEG:g} deg; the columns by K are shares all right."
    return Table("Finding the talkers", header, tuple(lines), about)


def _after(task: Sequence[Exploration], schedule: int | str) -> list[Exploration]:
    """The row of one exploration at which a schedule ends."""
    ordered = sorted(task, key=lambda row: row.rotations)
    end = stopped([row.certain for row in ordered]) if schedule == STOP else int(schedule)
    return [row for row in ordered if row.rotations == end]


def _finds(rows: Sequence[Exploration], counts: Sequence[int]) -> tuple[str, ...]:
    errors = np.concatenate([row.errors_deg for row in rows])
    near = errors <= NEAR_DEG
    right = [[row.right for row in rows if row.k == k] for k in counts]
    return (
        f"{np.mean([row.rotations for row in rows]):.1f}",
        f"{np.mean([row.k_estimated == row.k for row in rows]):.2f}",
        f"{np.mean([row.right for row in rows]):.2f}",
        f"{near.mean():.3f}",
        f"{errors[near].mean():.2f}" if near.any() else "-",
        *(f"{np.mean(part):.2f}" if part else "-" for part in right),
    )
