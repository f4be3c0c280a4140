"""Files that somebody else may have written: read without waiting, up to a size, and parsed up to a depth.

Whatever lies under a path, a named pipe, a folder, gigabytes, a thousand brackets, is an error of one line, and soon.
"""

from __future__ import annotations

import errno
import json
import os
import stat
import tomllib
from itertools import count
from pathlib import Path
from typing import Any

MB = 1_000_000  # [bytes]
DEEPEST = 64  # tables and lists inside each other
KINDS = (
    (stat.S_ISDIR, "a folder"), (stat.S_ISFIFO, "a named pipe"), (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"), (stat.S_ISBLK, "a device"),
)  # fmt: skip


def open_regular(path: Path) -> int:
    """Open a regular file for reading and return its descriptor; a named pipe that nobody writes to does not block.

    Raises
    ------
    OSError
        When it cannot be opened, or is no regular file; ``strerror`` says what it is.
    """
    handle = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC)
    mode = os.fstat(handle).st_mode
    if stat.S_ISREG(mode):
        return handle
    os.close(handle)
    raise OSError(errno.EINVAL, f"expected a regular file, got {kind_of(mode)}", str(path))


def kind_of(mode: int) -> str:
    """Say what lies under a path that is no regular file, by its mode.

    >>> kind_of(stat.S_IFIFO | 0o600)
    'a named pipe'
    """
    return next((words for is_it, words in KINDS if is_it(mode)), "something else")


def read_bounded(path: Path, most: int = MB) -> bytes:
    """Read a regular file of at most ``most`` bytes.

    Raises
    ------
    OSError
        When it cannot be read, is no regular file, or is larger; ``strerror`` says why.
    """
    with os.fdopen(open_regular(path), "rb") as file:
        data = file.read(most + 1)
    if len(data) > most:
        raise OSError(errno.EFBIG, f"expected at most {most:,} bytes, got more", str(path))
    return data


def parsed_json(data: bytes | str) -> Any:
    """Parse JSON of somebody else.

    >>> parsed_json('{"end": null}')
    {'end': None}

    Raises
    ------
    ValueError
        When it is not JSON in UTF-8, or is nested deeper than `DEEPEST`; one line.
    """
    try:
        values = json.loads(data)
    except RecursionError as error:
        raise ValueError(_TOO_DEEP) from error
    except UnicodeDecodeError as error:
        raise ValueError("expected UTF-8 text, got other bytes") from error
    return _shallow(values)


def parsed_toml(data: bytes) -> dict[str, Any]:
    """Parse TOML of somebody else; a byte order mark in front, as of editors on Windows, is no part of it.

    >>> parsed_toml(b"rate_hz = 16000")
    {'rate_hz': 16000}

    Raises
    ------
    ValueError
        When it is not TOML in UTF-8, or is nested deeper than `DEEPEST`; one line.
    """
    try:
        values = tomllib.loads(data.decode("utf-8-sig"))
    except RecursionError as error:
        raise ValueError(_TOO_DEEP) from error
    except UnicodeDecodeError as error:
        raise ValueError("expected UTF-8 text, got other bytes") from error
    _shallow(values)
    return values


def toml_value(text: str) -> Any:
    """Return a value as it stands in TOML; what is none is a word.

    >>> toml_value("[1, 2]"), toml_value("duet")
    ([1, 2], 'duet')
    """
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


def printable(text: str) -> str:
    r"""Escape what would colour a terminal, move its cursor or forge a line of a log.

    >>> print(printable("\x1b[2J"))
    \x1b[2J
    """
    return "".join(char if char.isprintable() else char.encode("unicode_escape").decode() for char in text)


def set_aside(path: Path, word: str) -> str:
    """Rename what cannot be used, so that it is neither read again nor lost, and say where it is now.

    Nothing that was set aside before is touched. On a disk that cannot be written it stays where it is.
    """
    names = (path.with_name(f"{path.name}.{word}{'' if n == 1 else f'-{n}'}") for n in count(1))
    try:
        free = next(name for name in names if not os.path.lexists(name))
        return f"kept as {path.rename(free).name}"
    except OSError as error:
        return f"it cannot be renamed: {error.strerror}"


_TOO_DEEP = f"nested deeper than {DEEPEST} levels"


def _shallow(values: Any) -> Any:
    """Return values that are not nested too deeply for whoever walks through them by recursion."""
    level = [values]
    for _ in range(DEEPEST + 1):
        level = [part for each in level for part in _parts(each)]
        if not level:
            return values
    raise ValueError(_TOO_DEEP)


def _parts(value: Any) -> Any:
    return value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
