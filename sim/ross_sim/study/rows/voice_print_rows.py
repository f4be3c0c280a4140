"""What voice prints say of separated voices, mixture by mixture, and the table of their errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ross_payload.config import Exploit
from ross_payload.interfaces import Real
from ross_sim.study.rows.tables import Table, grouped
from ross_sim.study.scenes.room_settings import SETTINGS

CRITERION = Exploit().criterion  # of missions, unless it is set [nat]
NEAR = -2.0  # strangers whose values are lower are only counted [nat]
DIGITS = 2  # of a value
REDRAWN = 1000  # times, for intervals
TOGETHER = "rooms together"
HEADER = ("", "targets, strangers", "equal error rate", "false rejects", "false accepts")


@dataclass(frozen=True, slots=True)
class VoicePrintRow:
    """The separated voices of one mixture against every print, after one duration."""

    model: str
    room: str
    seed: int
    mixture: int  # of a seed: those of all rooms have the same talkers, places and clips
    seconds: float
    targets: tuple[float, ...]  # of every voice against the print of its talker [nat]
    strangers: int  # how often a voice was compared with somebody else's print
    near: tuple[float, ...]  # what came out above `NEAR` then [nat]


def split(values: Real, same: NDArray[np.bool_]) -> tuple[tuple[float, ...], int, tuple[float, ...]]:
    """The last three columns of a row: of values (n,) [nat] those of the ``same`` talkers (n,), and of strangers."""
    rounded = np.round(values, DIGITS)
    return tuple(rounded[same].tolist()), int((~same).sum()), tuple(rounded[~same & (rounded > NEAR)].tolist())


def equal_error_rate(targets: Real, strangers: Real) -> float:
    """Share of errors at the threshold where rejected targets (n,) and accepted strangers (m,) are as frequent.

    >>> equal_error_rate(np.array([1.0, 2, 3, 4]), np.array([-3.0, -2, -1, 1.5]))
    0.25
    """
    thresholds = np.sort(np.concatenate([targets, strangers]))
    rejected = np.searchsorted(np.sort(targets), thresholds, side="right") / targets.size
    accepted = 1 - np.searchsorted(np.sort(strangers), thresholds, side="right") / strangers.size
    best = int(np.argmin(np.abs(rejected - accepted)))
    return float((rejected[best] + accepted[best]) / 2)


def errors(rows: Sequence[VoicePrintRow]) -> Real:
    """Equal error rate, false rejects and false accepts at the criterion, (3,); not a number where nobody is."""
    (found,) = _redrawn([rows], np.ones((1, 1)))
    return np.asarray(found)


def intervals(rows: Sequence[VoicePrintRow]) -> Real:
    """Where 95 % of `errors` lie when whole mixtures are resampled, each with all its rooms, (2, 3)."""
    mixtures = list(grouped(rows, lambda row: (row.seed, row.mixture)).values())
    rng, n = np.random.default_rng(0), len(mixtures)
    times = [np.bincount(rng.integers(n, size=n), minlength=n) for _ in range(REDRAWN)]
    return np.asarray(np.nanpercentile(_redrawn(mixtures, np.array(times, float)), [2.5, 97.5], axis=0))


def _redrawn(mixtures: Sequence[Sequence[VoicePrintRow]], times: Real) -> Real:
    """`errors` where mixtures (m,) count so many ``times`` (n, m), (n, 3)."""
    targets = [np.concatenate([row.targets for row in rows]) for rows in mixtures]
    near = [np.concatenate([row.near for row in rows]) for rows in mixtures]
    far = np.array([sum(row.strangers for row in rows) for rows in mixtures]) - [values.size for values in near]
    thresholds = np.unique(np.concatenate([*targets, *near, [-np.inf, CRITERION]]))
    with np.errstate(invalid="ignore"):  # where nobody is
        rejected = times @ [_at_most(values, thresholds) for values in targets]
        rejected /= rejected[:, -1:]
        accepted = times @ (np.array([_at_most(values, thresholds) for values in near]) + far[:, None])
        accepted = 1 - accepted / accepted[:, -1:]
    best, criterion = np.argmin(np.abs(rejected - accepted), axis=1), np.searchsorted(thresholds, CRITERION)
    equal = np.take_along_axis(rejected + accepted, best[:, None], axis=1)[:, 0] / 2
    return np.where(
        np.isnan(equal)[:, None], np.nan, np.stack([equal, rejected[:, criterion], accepted[:, criterion]], 1)
    )


def _at_most(values: Real, thresholds: Real) -> Real:
    """How many of the values are at most each threshold."""
    return np.asarray(np.searchsorted(np.sort(values), thresholds, side="right"), float)


def voice_prints(rows: Sequence[VoicePrintRow]) -> Table:
    """Errors by room and duration, of all rooms but the open one together, and of these seed by seed."""
    lines = []
    models = grouped(rows, lambda row: row.model)
    for model, found in models.items():
        rooms = grouped(found, lambda row: row.room)
        indoors = [row for row in found if SETTINGS[row.room].t60]
        seeds = grouped(indoors, lambda row: row.seed)
        if len({row.room for row in indoors}) > 1:
            rooms[TOGETHER] = indoors
            rooms |= {f"{TOGETHER}, seed {seed}": part for seed, part in seeds.items() if len(seeds) > 1}
        for room, part in rooms.items():
            for seconds, group in sorted(grouped(part, lambda row: row.seconds).items()):
                label = f"{room}, {seconds:g} s"
                lines.append((label if len(models) == 1 else f"{model}, {label}", *_cells(group)))
    about = (
        f"Percent, at the criterion of missions, {CRITERION:g} nat, and 95 % intervals by bootstrapping whole mixtures."
    )
    return Table("Voice prints", HEADER, tuple(lines), about)


def _cells(rows: Sequence[VoicePrintRow]) -> tuple[str, ...]:
    targets, strangers = sum(len(row.targets) for row in rows), sum(row.strangers for row in rows)
    low, high = intervals(rows)
    shares = [
        "-" if np.isnan(share) else f"{100 * share:.1f} ({100 * least:.0f}-{100 * most:.0f})"
        for share, least, most in zip(errors(rows), low, high, strict=True)
    ]
    return f"{targets}, {strangers:,}", *shares
