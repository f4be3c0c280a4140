"""How far a study is: a bar with the time left on a terminal, plain lines elsewhere."""

from __future__ import annotations

from collections.abc import Callable

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

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


def view_of(total: int, before: int, now: Callable[[], float]) -> Bar | Lines:
    """Choose a view for where the output goes."""
    console = Console()
    return Bar(console, total, before) if console.is_terminal else Lines(console, total, before, now)
