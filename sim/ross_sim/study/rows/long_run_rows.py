"""Whether anything grows or falls behind over an hour: rows of the soak tests, and their tables.

The tests are ``tests/realtime/test_endurance.py``, ``tests/interop/test_listening_soak.py`` and
``tests/browser/test_page_soak.py``, with ``--rows FOLDER``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

from ross_sim.study.rows.tables import Table

Run = TypeVar("Run")


@dataclass(frozen=True, slots=True)
class PayloadRun:
    """One payload, whose tasks, links and microphones came and went."""

    minutes: float  # after the first eight, in which histories that are bounded fill
    growth_mb: float  # of resident memory: the lowest of the last third above the lowest of the first
    least_mb: float
    most_mb: float
    threads_first: int
    threads_last: int
    files_first: int  # descriptors: the fewest of the first two minutes
    files_last: int
    orders: int
    accepted: int
    unplugged: int  # times that the microphones were
    reopened: int
    missing_s: float  # sound that did not come
    lost_s: float  # sound that was counted as lost
    silence_s: float  # the longest between two heartbeats
    cpu: float  # of all threads, share of one core
    pump: float  # of the pump alone


@dataclass(frozen=True, slots=True)
class ListeningMinute:
    """One minute of live listening in simulated time."""

    minute: int
    memory_mb: float  # resident
    age_s: float  # of what the ground plays, mean


@dataclass(frozen=True, slots=True)
class PageRun:
    """The ground station's page beside five payloads."""

    seconds: int
    frames: int  # that were drawn
    median_ms: float  # from the reception of a message until it is drawn
    p95_ms: float
    max_ms: float
    core: float  # of the ground process, share of one core
    dropped: int  # datagrams, by the system
    paused_ms: float  # the longest that a thread without work was kept from waking
    memory: float  # the lowest of the last third over the lowest of the first: resident memory of the ground process,
    files: float  # its descriptors,
    heap: float  # the heap of the page,
    nodes: float  # and its nodes
    memory_mb: float
    heap_mb: float


PAYLOAD: dict[str, Callable[[PayloadRun], str]] = {
    "time in which nothing may grow": lambda run: f"{run.minutes:.0f} min",
    "growth of resident memory": lambda run: f"{run.growth_mb:.1f} MB",
    "resident memory": lambda run: f"{run.least_mb:.0f} to {run.most_mb:.0f} MB",
    "threads, at both ends": lambda run: f"{run.threads_first}, {run.threads_last}",
    "descriptors, at both ends": lambda run: f"{run.files_first}, {run.files_last}",
    "orders, of them accepted": lambda run: f"{run.orders}, {run.accepted}",
    "microphones unplugged and back": lambda run: f"{run.reopened} of {run.unplugged}",
    "sound that did not come, sound counted as lost": lambda run: f"{run.missing_s:.1f} s, {run.lost_s:.1f} s",
    "longest silence between two heartbeats": lambda run: f"{run.silence_s:.2f} s",
    "CPU of all threads, of the pump": lambda run: f"{100 * run.cpu:.0f} %, {100 * run.pump:.1f} % of a core",
}
PAGE: dict[str, Callable[[PageRun], str]] = {
    "delay, median and 95 of 100": lambda run: f"{run.median_ms:.0f} and {run.p95_ms:.0f} ms, {run.frames:,} frames",
    "longest delay": lambda run: f"{run.max_ms:.0f} ms",
    "longest pause of a thread without work": lambda run: f"{run.paused_ms:.0f} ms",
    "ground process": lambda run: f"{run.core:.2f} of a core",
    "datagrams that the system had to drop": lambda run: f"{run.dropped}",
    "resident memory, floor of the last third over the first": lambda run: f"x{run.memory:.2f}, {run.memory_mb:.0f} MB",
    "open files, nodes of the page": lambda run: f"x{run.files:.2f}, x{run.nodes:.2f}",
    "heap of the page": lambda run: f"x{run.heap:.2f}, {run.heap_mb:.1f} MB",
}
REQUIRED = ("< 150 ms", "", "", "< 0.5 of a core", "0", "< x1.1", "< x1.1", "< x1.1")


def endurance(rows: Sequence[PayloadRun]) -> Table:
    """What a payload had after a long time, one column for every run.

    >>> run = PayloadRun(16.0, 0.4, 168.0, 194.2, 11, 11, 9, 9, 706, 703, 12, 12, 55.5, 55.4, 1.07, 0.15, 0.048)
    >>> endurance([run]).rows[1:3]
    (('growth of resident memory', '0.4 MB'), ('resident memory', '168 to 194 MB'))
    """
    return Table("Endurance", ("", *_numbers(rows)), _lines(PAYLOAD, rows))


def listening(rows: Sequence[ListeningMinute]) -> Table:
    """Memory, and age of what is heard, after the first, tenth, thirtieth and last minute.

    >>> listening([ListeningMinute(minute, 238.3, 0.1549) for minute in range(1, 13)]).rows[0]
    ('resident memory', '238.3 MB', '238.3 MB', '238.3 MB')
    """
    shown = [row for row in rows if row.minute in {1, 10, 30, len(rows)}]
    lines = (
        ("resident memory", *(f"{row.memory_mb:.1f} MB" for row in shown)),
        ("age of what the ground plays", *(f"{1e3 * row.age_s:.0f} ms" for row in shown)),
    )
    return Table("Listening", ("after", *(f"{row.minute} min" for row in shown)), lines)


def page_runs(rows: Sequence[PageRun]) -> Table:
    """How far a page was behind, and what had grown, one column for every run."""
    lines = [(name, required, *cells) for (name, *cells), required in zip(_lines(PAGE, rows), REQUIRED, strict=True)]
    return Table("Page runs", ("", "required", *(f"{run.seconds / 60:.0f} min" for run in rows)), tuple(lines))


def _numbers(rows: Sequence[Run]) -> tuple[str, ...]:
    return tuple(f"run {number}" for number in range(1, len(rows) + 1)) if len(rows) > 1 else ("measured",)


def _lines(cells: dict[str, Callable[[Run], str]], rows: Sequence[Run]) -> tuple[tuple[str, ...], ...]:
    return tuple((name, *map(cell, rows)) for name, cell in cells.items())
