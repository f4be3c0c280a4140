"""Paths that a configuration names."""

from __future__ import annotations

import os
from pathlib import Path

from ross_payload.errors import ConfigError


def expanded(named: str) -> Path:
    r"""Return the path that a configuration names; a ``~`` in front is a home folder.

    Raises
    ------
    ConfigError
        When there is no such home, or no file may be named so.

    >>> expanded("~nobody-of-this-name/tones.flac")
    Traceback (most recent call last):
    ...
    ross_payload.errors.ConfigError: expected a path, got '~nobody-of-this-name/tones.flac': no such user
    >>> expanded("a\0b")
    Traceback (most recent call last):
    ...
    ross_payload.errors.ConfigError: expected a path, got 'a\x00b': it holds a null byte
    """
    if "\0" in named:
        raise ConfigError(f"expected a path, got {named!r}: it holds a null byte")
    try:
        return Path(named).expanduser()
    except RuntimeError as error:
        raise ConfigError(f"expected a path, got {named!r}: no such user") from error


def home_folder(otherwise: str) -> Path:
    """Return the home folder of this user; ``otherwise`` is the variable that could be set in its place.

    Raises
    ------
    ConfigError
        When there is none: without HOME, of a user whom the system does not know, as in a container.
    """
    try:
        return Path.home()
    except RuntimeError as error:
        raise ConfigError(f"this user has no home folder: set HOME, or {otherwise}") from error


def nearest_there(folder: Path) -> Path:
    """Return a folder, or the nearest of those above it that is there: where it would have to be made.

    >>> nearest_there(Path("/nobody-has-this/recordings"))
    PosixPath('/')
    """
    return next((path for path in (folder, *folder.absolute().parents) if os.path.lexists(path)), Path("/"))
