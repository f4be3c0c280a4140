"""What separating costs: one method on one mixture, and the tables of methods and of how costs grow."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from statistics import mean, median

from ross_payload.separation import auxiva
from ross_sim.study.rows.tables import Table, grouped

BASE = "gaussian"
BLIND = f"auxiva, blind, {auxiva.ITERATIONS} iterations"  # as the other libraries have it


@dataclass(frozen=True, slots=True)
class CostRow:
    """One method on one mixture, or one part of a growing task."""

    method: str
    setting: str
    k: int
    rate: int  # [Hz]
    duration_s: float  # of the mixture
    target: int
    seed: int
    growing: str | None  # what grows: K, room, rate or duration; None: methods are compared
    cpu_s_s: float  # CPU seconds per second of audio
    si_sdri_db: float | None = None  # of what is separated

    @property
    def mixture(self) -> tuple[str, int, int, float, int, int]:
        """What names the mixture."""
        return self.setting, self.k, self.rate, self.duration_s, self.target, self.seed


def costs(rows: Sequence[CostRow]) -> Table:
    """Every method; a ratio is the median of the ratios on each mixture.

    >>> case = "S1", 3, 24000, 10.0, 0, 0, None
    >>> both = [CostRow(BASE, *case, 0.02, 15.0), CostRow(BLIND, *case, 0.01, 5.0), CostRow("x", *case, 0.2, 7.0)]
    >>> costs(both).rows[-1]
    ('x', '0.2000', '10.0', '20.0', '7.0')
    """
    compared = [row for row in rows if row.growing is None]
    base = {name: {row.mixture: row.cpu_s_s for row in compared if row.method == name} for name in (BASE, BLIND)}
    rooms = list(grouped(compared, lambda row: row.setting))
    lines = []
    for method, group in grouped(compared, _method).items():
        ratios = [
            [row.cpu_s_s / other[row.mixture] for row in group if row.mixture in other] for other in base.values()
        ]
        gains = [[row.si_sdri_db or 0.0 for row in group if row.setting == room] for room in rooms]
        cells = (*(_cell(median, each) for each in ratios), *(_cell(mean, each) for each in gains))
        lines.append((method, f"{median(row.cpu_s_s for row in group):.4f}", *cells))
    header = ("", "CPU s/s", f"over {BASE}", "over auxiva, blind", *(f"SI-SDRi, {room} [dB]" for room in rooms))
    about = "Medians of CPU seconds per second of audio, of the ratios on each mixture, and mean SI-SDRi."
    return Table("Cost", header, tuple(lines), about)


def growth(rows: Sequence[CostRow]) -> Table:
    """What every part costs as one number of the task grows."""
    growing = [row for row in rows if row.growing is not None]
    methods = list(grouped(growing, _method))
    lines = []
    for label, group in grouped(growing, _label).items():
        by_method = grouped(group, lambda row: row.method)
        cells = (
            f"{median(row.cpu_s_s for row in by_method[name]):.4f}" if name in by_method else "-" for name in methods
        )
        lines.append((label, *cells))
    return Table("Growth", ("", *methods), tuple(lines), "CPU seconds per second of audio.")


def _cell(of: Callable[[Sequence[float]], float], values: Sequence[float]) -> str:
    return f"{of(values):.1f}" if values else "-"


def _method(row: CostRow) -> str:
    return row.method


def _label(row: CostRow) -> str:
    return {
        "K": f"K = {row.k}",
        "room": row.setting,
        "rate": f"{row.rate / 1000:g} kHz",
        "duration": f"{row.duration_s:g} s",
    }[row.growing or ""]
