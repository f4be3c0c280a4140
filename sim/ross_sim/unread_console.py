"""Standard output of a long command that writes files, whose reader may go, as `head -1` does."""

from __future__ import annotations

import os
import sys

import click
from rich.console import Console


class UnreadConsole(Console):
    """Standard output; when its reader goes, the ``work`` ("the mission") goes on for what it writes."""

    def __init__(self, work: str) -> None:
        super().__init__()
        self._work = work

    def on_broken_pipe(self) -> None:
        """Say so once, and write to nobody from here on; without this method rich ends the program."""
        nobody = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nobody, sys.stdout.fileno())
        os.close(nobody)
        click.echo(f"ross: nobody reads the output any more; {self._work} goes on for what it writes", err=True)
