"""How the scripts of this package, ``python -m ross_sim.study...``, end on a mistake: as the command ``ross`` does."""

from __future__ import annotations

from argparse import ArgumentParser
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import click

from ross_payload.atomic_files import write_whole
from ross_payload.bounded_files import printable
from ross_payload.errors import ConfigError, OutputError, RossError, refused_as


class Refused(click.ClickException):
    """A mistake of the user, in one line."""

    exit_code = 2


@contextmanager
def told_in_a_line() -> Iterator[None]:
    """End a script with one line and exit code 2 on bad input, 1 when its results cannot be written.

    Raises
    ------
    click.ClickException
        Which click prints.
    """
    try:
        yield
    except OutputError as error:
        raise click.ClickException(printable(str(error))) from error
    except RossError as error:
        raise Refused(printable(str(error))) from error


@contextmanager
def told_by(parser: ArgumentParser) -> Iterator[None]:
    """End a script with one line: with the usage and exit code 2 on bad input, 1 when its results cannot be written.

    Raises
    ------
    SystemExit
        When something is wrong.
    """
    try:
        yield
    except OutputError as error:
        parser.exit(1, f"{parser.prog}: error: {printable(str(error))}\n")
    except RossError as error:
        parser.error(printable(str(error)))


def expect_writable(*paths: Path) -> None:
    """Look, before hours of work, whether files can be written at its end.

    Raises
    ------
    ConfigError
        When one is a folder, or would be in a folder that is none.
    """
    for path in paths:
        there = next((each for each in path.parents if each.exists()), Path())
        if path.is_dir():
            raise ConfigError(f"{path}: expected a file to write, got a folder")
        if not there.is_dir():
            raise ConfigError(f"{path}: expected a file in a folder, but {there} is a file")


def write_result(path: Path, content: bytes) -> None:
    """Write what a script has made.

    Raises
    ------
    OutputError
        When it cannot be written.
    """
    with refused_as(OutputError, f"{path}: cannot be written"):
        write_whole(path, content)
