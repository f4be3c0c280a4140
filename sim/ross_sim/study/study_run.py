"""One run of a study: what is missing is measured, and tables, figures and files are made of everything.

How far it is shows a bar with the time left on a terminal, plain lines elsewhere.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Protocol

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from ross_payload.clock import SystemClock
from ross_payload.errors import OutputError, refused_as
from ross_payload.plugins import install_line
from ross_sim.study import task_engine
from ross_sim.study.figures import draw
from ross_sim.study.result_rows import Exploration, Result, Separation, Timing, decode
from ross_sim.study.row_files import as_csv, has_parquet, write_parquet
from ross_sim.study.study_case import Failure, attempt
from ross_sim.study.study_design import ALL, Shard, Study, Task, chosen, mixed, tasks
from ross_sim.study.study_store import Rows, Store, manifest
from ross_sim.study.tables import Table, tables
from ross_sim.study.talker_placement import Source, check_voices, heard_as, voices_of

EVERY = 60.0  # between plain lines [s]


class Named(Protocol):
    """A task."""

    @property
    def id(self) -> str:
        """What it is called in the journal."""


class Bar:
    """A bar that is redrawn in place."""

    def __init__(self, console: Console, total: int, before: int) -> None:
        parts = (BarColumn(), MofNCompleteColumn(), TextColumn("tasks"), TimeElapsedColumn(), TextColumn("left"))
        left = TimeRemainingColumn()
        self._progress = Progress(*parts, left, TextColumn("{task.description}"), console=console)
        self._task = self._progress.add_task("", total=total - before)
        self._progress.start()

    def done(self, name: str) -> None:
        """Move on."""
        self._progress.update(self._task, advance=1, description=name)

    def close(self) -> None:
        """Leave the last bar on the screen."""
        self._progress.stop()


class Lines:
    """A line now and then."""

    def __init__(self, console: Console, total: int, before: int, now: Callable[[], float]) -> None:
        self._console, self._total, self._done, self._before, self._now = console, total, before, before, now
        self._began = self._printed_at = now()
        if before:
            self._print(f"{before} of {total} tasks were done before")

    def done(self, name: str) -> None:
        """Say something when nothing has been said for a while, and at the end."""
        self._done += 1
        spent = self._now() - self._began
        if self._now() - self._printed_at >= EVERY or self._done == self._total:
            self._printed_at = self._now()
            left = spent / (self._done - self._before) * (self._total - self._done)
            self._print(f"{self._done} of {self._total} tasks, {in_words(spent)}, {in_words(left)} left")

    def close(self) -> None:
        """Nothing to give back."""

    def _print(self, text: str) -> None:
        self._console.print(text, highlight=False, soft_wrap=True)


def in_words(seconds: float) -> str:
    """A duration for people.

    >>> in_words(75.4), in_words(7320.0)
    ('1 min 15 s', '2 h 02 min')
    """
    minutes, rest = divmod(round(seconds), 60)
    if minutes >= 60:
        return f"{minutes // 60} h {minutes % 60:02d} min"
    return f"{minutes} min {rest:02d} s" if minutes else f"{rest} s"


def view_of(total: int, before: int, now: Callable[[], float]) -> Bar | Lines:
    """Choose a view for where the output goes."""
    console = Console()
    return Bar(console, total, before) if console.is_terminal else Lines(console, total, before, now)


def conduct(
    preset: str,
    changes: dict[str, Any],
    *,
    out: Path,
    speech: Path | None,
    workers: int | None,
    quick: bool,
    shard: Shard = ALL,
) -> int:
    """Run a study or a shard of it, or what is left of that; returns the exit code."""
    study = chosen(preset, changes, quick)
    source = Source(speech, study.talkers, study.rate_hz)
    voices = voices_of(source)
    check_voices(voices, study)
    with Store(out, manifest(study, heard_as(voices)), decode) as store:
        every: list[Task] = shard.of_all(tasks(study))
        left = mixed(task for task in every if task.id not in store.results)
        work = Work(partial(attempt, study=study, source=source), left, len(every), workers)
        return carried_out(work, store, lambda: write(store, study) if shard == ALL else [])


@dataclass(frozen=True, slots=True)
class Work:
    """What is left of a study."""

    function: Callable[[Any], Any]  # of a task; gives its rows, or a `Failure`
    left: Sequence[Named]
    total: int  # tasks of the study
    workers: int | None  # processes; None: one per core


def carried_out(work: Work, store: Store[Rows], finish: Callable[[], list[Table]]) -> int:
    """Do what is left of a study, write rows and tables, and show the tables; returns the exit code."""
    console, clock = Console(), SystemClock()
    began = clock.now()
    run = task_engine.serial if work.workers == 1 else task_engine.processes(work.workers or os.cpu_count() or 1)
    try:
        failures = measure(run, work.function, work.left, store, clock.now)
    except KeyboardInterrupt:
        done = f"{len(store.results)} of {work.total} tasks are done and kept"
        console.print(f"\nstopped: {done}; the same command goes on", highlight=False, soft_wrap=True)
        raise
    for table in finish():
        console.print()
        console.print(table.screen() if console.is_terminal else table.markdown(), markup=False, soft_wrap=True)
    _farewell(console, store.folder, len(work.left), clock.now() - began, failures)
    return 1 if failures else 0


def measure(
    run: task_engine.Engine,
    function: Callable[[Any], Rows | Failure],
    left: Sequence[Named],
    store: Store[Rows],
    now: Callable[[], float],
) -> list[Failure]:
    """Do the tasks that are left and keep every result as it comes."""
    failures = []
    if not left:
        return []
    view = view_of(len(left) + len(store.results), len(store.results), now)
    try:
        with closing(run(function, left)) as results:
            for result in results:
                if isinstance(result, Failure):
                    failures.append(result)
                else:
                    store.add(result)
                view.done(result.task)
    finally:
        view.close()
    return failures


def write(store: Store[Result], study: Study) -> list[Table]:
    """Write rows, tables and figures; the order of the rows is the study's, whatever came first."""
    results = [store.results[task.id] for task in tasks(study) if task.id in store.results]
    separations = [row for result in results for row in result.separations]
    explorations = [row for result in results for row in result.explorations]
    timings = [row for result in results for row in result.timings]
    made = tables(study, separations, explorations)
    write_rows(store, "separations", separations, Separation)
    write_rows(store, "explorations", explorations, Exploration)
    write_rows(store, "timing", timings, Timing)
    store.write("tables.md", "\n".join(table.markdown() for table in made).encode())
    with refused_as(OutputError, f"{store.folder}: figures cannot be written"):
        draw(store.folder, separations, explorations)
    return made


def write_rows(store: Store[Any], name: str, rows: Sequence[Any], kind: type[Any]) -> None:
    """Write rows of one kind, if there are any, as CSV and, where that can be written, as Parquet."""
    if not rows:
        return
    store.write(f"{name}.csv", as_csv(rows, kind))
    if has_parquet():
        with store.writing(f"{name}.parquet") as path:
            write_parquet(path, rows, kind)


def _farewell(console: Console, out: Path, n: int, seconds: float, failures: Sequence[Failure]) -> None:
    if not has_parquet():
        console.print(f"No Parquet was written: {install_line('study')}", markup=False)
    kinds = {"*.csv": "rows", "*.parquet": "rows, typed", "tables.md": "tables", "*.pdf": "figures"}
    there = ", ".join(f"{name} ({what})" for name, what in kinds.items() if any(out.glob(name)))
    words = f"{n} tasks in {in_words(seconds)}. Results in {out}/: {there or 'journal.jsonl, for ross study merge'}"
    console.print(f"\n{words}", highlight=False, markup=False, soft_wrap=True)
    if failures:
        first = failures[0]
        text = f"{len(failures)} tasks failed, and the same command tries them again; {first.task}: {first.reason}"
        console.print(text, style="red", highlight=False, markup=False, soft_wrap=True)
