"""How soon a stop counts, and how often pulses run out: rows of the soak tests in real time, and their tables.

The tests are ``tests/realtime/test_stop_latency.py`` and ``test_pulses_under_load.py``, with ``--rows FOLDER``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ross_sim.study.rows.tables import Table, grouped


@dataclass(frozen=True, slots=True)
class StopRow:
    """One move that was stopped."""

    stop: str  # what stopped it
    beside: str  # what else the computer did
    ahead_ms: int  # before they are due pulses are handed over
    after_s: float  # into the move
    braking_ms: float | None  # from the stop until steps come later; None: the pulses ran out before
    accepted_ms: float | None = None  # until the answer ACCEPTED, where one was waited for


@dataclass(frozen=True, slots=True)
class PulseRow:
    """One move that nobody stopped."""

    priority: str  # of the payload
    ahead_ms: int
    move: int
    lost: bool  # its pulses ran out


def stops(rows: Sequence[StopRow]) -> Table:
    """Time from a stop to the deceleration, by who stops and what goes on beside.

    >>> some = [StopRow("SIGTERM", "nothing", 40, 0.1, latency) for latency in (20.0, 30.0, None)]
    >>> stops(some).rows
    (('SIGTERM', 'nothing', '40', '2 of 3', '25.0', '29.5', '30.0'),)
    """
    lines = []
    for (stop, beside, ahead_ms), group in grouped(rows, lambda row: (row.stop, row.beside, row.ahead_ms)).items():
        cells = _quantiles([row.braking_ms for row in group])
        lines.append((stop, beside, f"{ahead_ms}", *cells))
    header = ("stop", "beside", "`ahead_ms`", "measured", "median [ms]", "p95 [ms]", "max [ms]")
    return Table("Stops", header, tuple(lines), "Time from a stop until the steps come later.")


def answers(rows: Sequence[StopRow]) -> Table:
    """Time from a stop to its answer ACCEPTED, where one was waited for."""
    asked = [row for row in rows if row.accepted_ms is not None]
    lines = []
    for (stop, beside, ahead_ms), group in grouped(asked, lambda row: (row.stop, row.beside, row.ahead_ms)).items():
        lines.append((stop, beside, f"{ahead_ms}", *_quantiles([row.accepted_ms for row in group])))
    header = ("stop", "beside", "`ahead_ms`", "accepted", "median [ms]", "p95 [ms]", "max [ms]")
    return Table("Answers", header, tuple(lines), "Time from a stop to its answer, which waits for the disk.")


def pulses(rows: Sequence[PulseRow]) -> Table:
    """How many moves ran out of pulses, by priority and by how far ahead pulses are handed over.

    >>> pulses([PulseRow("ordinary", 40, 0, True), PulseRow("ordinary", 40, 1, False)]).rows
    (('ordinary', '40', '1 of 2'),)
    """
    lines = [
        (priority, f"{ahead_ms}", f"{sum(row.lost for row in group)} of {len(group)}")
        for (priority, ahead_ms), group in grouped(rows, lambda row: (row.priority, row.ahead_ms)).items()
    ]
    return Table("Pulses", ("priority of the payload", "`ahead_ms`", "moves lost"), tuple(lines))


def _quantiles(times: Sequence[float | None]) -> tuple[str, ...]:
    whole = [time for time in times if time is not None]
    numbers = np.percentile(whole, [50, 95, 100]).tolist() if whole else []
    return f"{len(whole)} of {len(times)}", *(f"{number:.1f}" for number in numbers or [np.nan] * 3)
