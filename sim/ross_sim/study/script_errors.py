"""How the scripts of this package, ``python -m ross_sim.study...``, end on a mistake: as the command ``ross`` does."""

from __future__ import annotations

from argparse import ArgumentParser
from collections.abc import Iterator
from contextlib import contextmanager

import click

from ross_payload.errors import OutputError, RossError


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
        raise click.ClickException(str(error)) from error
    except RossError as error:
        raise Refused(str(error)) from error


@contextmanager
def told_by(parser: ArgumentParser) -> Iterator[None]:
    """End a script with the usage, one line and exit code 2 on bad input, as its parser does.

    Raises
    ------
    SystemExit
        When something is wrong.
    """
    try:
        yield
    except RossError as error:
        parser.error(str(error))
