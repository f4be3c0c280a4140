"""What a study of calibrations writes down, and the table of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ross_payload.interfaces import Real
from ross_sim.study.rows.tables import Table, grouped

WANTED = (1.0, 1.0, 0.3)  # errors of spacing [mm], offset [deg] and gain [dB] that are small enough
HEADER = (
    "",
    "calibrated",
    "spacing: median, 95 %, largest [mm]",
    "offset [deg]",
    "gain [dB]",
    "roll-off [Hz]",
    "polarity and swap right",
    "all within 1 mm, 1 deg, 0.3 dB",
    "errors over their sigmas (rms)",
    "direct",
)
ABOUT = "Absolute errors: median, 95th percentile, largest."


@dataclass(frozen=True, slots=True)
class CalibrationRow:
    """One calibration and what became of it; errors are measured minus true."""

    setting: str
    sound: str  # noise or talker
    draw: int
    seed: int
    spacing_mm: float  # true
    spacing_error_mm: float | None  # None: it was refused
    spacing_sigma_mm: float | None
    offset_deg: float  # true
    offset_error_deg: float | None
    offset_sigma_deg: float | None
    gain_db: float  # true, microphone 2 over 1
    gain_error_db: float | None
    gain_sigma_db: float | None
    roll_off_hz: float  # true, microphone 2 above 1
    roll_off_error_hz: float | None
    roll_off_sigma_hz: float | None
    polarity_right: bool
    swap_right: bool
    direct: float | None
    turn_s: float  # simulated
    refused: str  # why, in words; empty: calibrated


def calibrations(rows: Sequence[CalibrationRow]) -> Table:
    """One line for every setting and sound.

    >>> calibrations([]).rows
    ()
    """
    lines = []
    for (setting, sound), group in grouped(rows, lambda row: (row.setting, row.sound)).items():
        lines.append((f"{setting}, {sound}", *_cells(group)))
    return Table("Calibrations", HEADER, tuple(lines), ABOUT)


def _cells(rows: Sequence[CalibrationRow]) -> tuple[str, ...]:
    done = [row for row in rows if not row.refused]
    errors = (_values(done, lambda r: r.spacing_error_mm), _values(done, lambda r: r.offset_error_deg),
              _values(done, lambda r: r.gain_error_db), _values(done, lambda r: r.roll_off_error_hz))  # fmt: skip
    sigmas = (_values(done, lambda r: r.spacing_sigma_mm), _values(done, lambda r: r.offset_sigma_deg),
              _values(done, lambda r: r.gain_sigma_db), _values(done, lambda r: r.roll_off_sigma_hz))  # fmt: skip
    right = sum(row.polarity_right and row.swap_right for row in done)
    within = np.all([np.abs(each) <= most for each, most in zip(errors, WANTED, strict=False)], axis=0)
    normal = [np.sqrt(np.mean((e / s) ** 2)) if len(e) else np.nan for e, s in zip(errors, sigmas, strict=True)]
    direct = _values(done, lambda r: r.direct)
    return (
        f"{len(done)}/{len(rows)}",
        *(_spread(each) for each in errors),
        f"{right}/{len(done)}",
        f"{np.count_nonzero(within)}/{len(done)}",
        ", ".join(f"{value:.1f}" for value in normal),
        f"{np.median(direct):.2f}" if len(direct) else "-",
    )


def _values(rows: Sequence[CalibrationRow], of: Callable[[CalibrationRow], float | None]) -> Real:
    return np.array([value for row in rows if (value := of(row)) is not None])


def _spread(errors: Real) -> str:
    if not len(errors):
        return "-"
    size = np.abs(errors)
    return f"{np.median(size):.2f}, {np.quantile(size, 0.95):.2f}, {size.max():.2f}"
