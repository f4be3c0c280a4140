"""What the study of talkers in noise writes down, and the table of it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from ross_sim.study.rows.intervals import mean_cell, rate_cell
from ross_sim.study.rows.tables import Table, grouped

HEADER = (
    "noise",
    "model",
    "ratio",
    "all right",
    "talkers found",
    "K 2 and 3: SI-SDR in [dB]",
    "out [dB]",
    "one talker: in [dB]",
    "out [dB]",
)
ABOUT = "Rates and means with their 95 % intervals."


@dataclass(frozen=True, slots=True)
class NoiseRow:
    """One scene at one ratio: explored, or one target of it separated."""

    noise: str
    model: str  # learnt: covariances; told: and the speeds of the rotors; white: without
    snr_db: float
    k: int
    layout: int
    seed: int
    target: int | None = None  # None: explored
    k_found: int | None = None
    within: int | None = None  # talkers found within 10 degrees
    si_sdr_in_db: float | None = None
    si_sdr_out_db: float | None = None

    @property
    def right(self) -> bool:
        """K is right and everybody is near."""
        return self.k_found == self.k == self.within


def noises(rows: Sequence[NoiseRow]) -> Table:
    """One line for every noise, model and ratio.

    >>> noises([]).rows
    ()
    """
    lines = []
    for (noise, model, snr), group in grouped(rows, lambda row: (row.noise, row.model, row.snr_db)).items():
        lines.append((noise, model, f"{snr:g} dB", *_cells(group)))
    return Table("In the noise of a vehicle", HEADER, tuple(lines), ABOUT)


def _cells(rows: Sequence[NoiseRow]) -> tuple[str, ...]:
    explored, parted = [row for row in rows if row.target is None], [row for row in rows if row.target is not None]
    several, alone = ([row for row in parted if (row.k > 1) is more] for more in (True, False))
    return (
        rate_cell(sum(row.right for row in explored), len(explored)),
        rate_cell(sum(row.within or 0 for row in explored), sum(row.k for row in explored)),
        *(
            mean_cell(_values(values))
            for group in (several, alone)
            for values in ([row.si_sdr_in_db for row in group], [row.si_sdr_out_db for row in group])
        ),
    )


def _values(values: Iterable[float | None]) -> list[float]:
    return [value for value in values if value is not None]
