"""One run of a study: what is missing is measured, and tables, figures and files are made of everything.

How far it is shows a bar with the time left on a terminal, plain lines elsewhere.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from ross_payload.clock import SystemClock
from ross_payload.errors import OutputError, refused_as
from ross_payload.plugins import install_line
from ross_sim.study.oracle_separators import ORACLES
from ross_sim.study.rows.exploration_ends import EndRow, SigmaRow, end_rows, sigma_rows
from ross_sim.study.rows.exploration_tables import finds
from ross_sim.study.rows.figures import draw
from ross_sim.study.rows.layout_gains import GainRow, gain_rows
from ross_sim.study.rows.motion_rows import MotionRow, motion_rows, motions
from ross_sim.study.rows.result_rows import ESTIMATED, Exploration, Result, Separation, Timing, decode
from ross_sim.study.rows.row_files import has_parquet, write_csv, write_parquet
from ross_sim.study.rows.separation_tables import gains, losses
from ross_sim.study.rows.tables import Table
from ross_sim.study.runs.dask_engine import Basis, cluster
from ross_sim.study.runs.study_case import Failure, attempt
from ross_sim.study.runs.study_design import ALL, Shard, Study, Task, chosen, mixed, tasks
from ross_sim.study.runs.study_store import Rows, Store, manifest
from ross_sim.study.runs.talker_placement import Source, check_voices, heard_as, voices_of
from ross_sim.study.runs.task_engine import Engine, EngineChoice, Named, processes, serial
from ross_sim.unread_console import UnreadConsole

EVERY = 60.0  # between plain lines [s]


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


def view_of(console: Console, total: int, before: int, now: Callable[[], float]) -> Bar | Lines:
    """Choose a view for where the output goes."""
    return Bar(console, total, before) if console.is_terminal else Lines(console, total, before, now)


def conduct(
    preset: str,
    changes: dict[str, Any],
    *,
    out: Path,
    speech: Path | None,
    engine: EngineChoice,
    quick: bool,
    shard: Shard = ALL,
) -> int:
    """Run a study or a shard of it, or what is left of that; returns the exit code."""
    study = chosen(preset, changes, quick)
    source = Source(speech and speech.absolute(), study.talkers, study.rate_hz)
    check_voices(voices_of(source), study)
    basis = Basis(partial(study_manifest, study, source), study_manifest(study, source))
    with Store(out, basis.wanted, decode) as store:
        every: list[Task] = shard.of_all(tasks(study))
        left = mixed(task for task in every if task.id not in store.results)
        work = Work(partial(attempt, study=study, source=source), left, len(every), basis, engine)
        return carried_out(work, store, lambda: write(store, study) if shard == ALL else [])


def study_manifest(study: Study, source: Source) -> dict[str, Any]:
    """Everything that the rows of a study depend on, as it is in this process."""
    named = [("ross_payload.explorers", name) for name in study.explorers]
    named += [("ross_payload.separators", name) for name in study.separators if name not in ORACLES]
    return manifest(study, heard_as(voices_of(source)), named=named)


@dataclass(frozen=True, slots=True)
class Work:
    """What is left of a study."""

    function: Callable[[Any], Any]  # of a task; gives its rows, or a `Failure`
    left: Sequence[Named]
    total: int  # tasks of the study
    basis: Basis
    engine: EngineChoice


def carried_out(work: Work, store: Store[Rows], finish: Callable[[], list[Table]]) -> int:
    """Do what is left of a study, write rows and tables, and show the tables; returns the exit code."""
    console, clock = UnreadConsole("the study"), SystemClock()
    began = clock.now()
    try:
        failures = measure(_engine(work, console), work.function, work.left, store, clock.now, console=console)
    except KeyboardInterrupt:
        done = f"{len(store.results)} of {work.total} tasks are done and kept"
        console.print(f"\nstopped: {done}; the same command goes on", highlight=False, soft_wrap=True)
        raise
    for table in finish():
        console.print()
        console.print(table.screen() if console.is_terminal else table.markdown(), markup=False, soft_wrap=True)
    _print_summary(console, store.folder, len(work.left), clock.now() - began, failures)
    return 1 if failures else 0


def _engine(work: Work, console: Console) -> Engine:
    """Choose who does the tasks; nothing is started before there is one."""
    choice = work.engine
    if choice.dask:
        say = partial(console.print, highlight=False, markup=False, soft_wrap=True)
        return cluster(choice.scheduler, choice.processes, work.basis, say)
    return serial if choice.processes == 1 else processes(choice.processes)


def measure(
    run: Engine,
    function: Callable[[Any], Rows | Failure],
    left: Sequence[Named],
    store: Store[Rows],
    now: Callable[[], float],
    *,
    console: Console,
) -> list[Failure]:
    """Do the tasks that are left and keep every result as it comes."""
    failures = []
    if not left:
        return []
    view = view_of(console, len(left) + len(store.results), len(store.results), now)
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


@dataclass(frozen=True, slots=True)
class StoredRows:
    """Rows of one kind in the order of the tasks; read from the journal whenever somebody iterates."""

    store: Store[Any]
    tasks: Sequence[str]
    kind: str  # attribute of a result

    def __iter__(self) -> Iterator[Any]:
        return (row for task in self.tasks for row in getattr(self.store.results[task], self.kind))


def write(store: Store[Result], study: Study) -> list[Table]:
    """Write rows, tables and figures; the order of the rows is the study's, whatever came first."""
    done = [task.id for task in tasks(study) if task.id in store.results]
    for name, kind in (("separations", Separation), ("explorations", Exploration), ("timings", Timing)):
        write_rows(store, name.replace("timings", "timing"), StoredRows(store, done, name), kind)
    separations, explorations = (list(StoredRows(store, done, name)) for name in ("separations", "explorations"))
    made = []
    if separations:
        made += _separating(store, gain_rows(separations))
    if explorations:
        ends = end_rows(study.rotations, explorations)
        write_rows(store, "ends", ends, EndRow)
        write_rows(store, "sigmas", sigma_rows(study.rotations, explorations), SigmaRow)
        made.append(finds(ends))
    if any(study.turning_deg_s):
        compared = motion_rows(explorations)
        write_rows(store, "motions", compared, MotionRow)
        made.append(motions(compared))
    store.write("tables.md", "\n".join(table.markdown() for table in made).encode())
    with refused_as(OutputError, f"{store.folder}: figures cannot be written"):
        draw(store.folder, separations, explorations)
    return made


def _separating(store: Store[Result], rows: Sequence[GainRow]) -> list[Table]:
    write_rows(store, "gains", rows, GainRow)
    estimated = any(row.how == ESTIMATED for row in rows)
    return [gains(rows), losses(rows)] if estimated else [gains(rows)]


def write_rows(store: Store[Any], name: str, rows: Iterable[Any], kind: type[Any]) -> None:
    """Write rows of one kind, if there are any, as CSV and, where that can be written, as Parquet; iterates twice."""
    if next(iter(rows), None) is None:
        return
    with store.writing(f"{name}.csv") as path, path.open("w", newline="", encoding="utf-8") as file:
        write_csv(file, rows, kind)
    if has_parquet():
        with store.writing(f"{name}.parquet") as path:
            write_parquet(path, rows, kind)


def _print_summary(console: Console, out: Path, n: int, seconds: float, failures: Sequence[Failure]) -> None:
    if not has_parquet():
        console.print(f"No Parquet was written; it needs: {install_line('study')}", markup=False, soft_wrap=True)
    kinds = {"*.csv": "rows", "*.parquet": "rows, typed", "tables.md": "tables", "*.pdf": "figures"}
    there = ", ".join(f"{name} ({what})" for name, what in kinds.items() if any(out.glob(name)))
    words = f"{n} tasks in {in_words(seconds)}. Results in {out}/: {there or 'journal.jsonl, for ross study merge'}"
    console.print(f"\n{words}", highlight=False, markup=False, soft_wrap=True)
    if failures:
        first = failures[0]
        text = f"{len(failures)} tasks failed, and the same command tries them again; {first.task}: {first.reason}"
        console.print(text, style="red", highlight=False, markup=False, soft_wrap=True)
