"""Change some keys of a configuration file; comments, order and all other keys stay as they are."""

from __future__ import annotations

import os
import shutil
from collections.abc import Mapping
from contextlib import suppress
from itertools import count
from pathlib import Path
from typing import Any

from ross_payload.atomic_files import replacing, synchronise
from ross_payload.bounded_files import read_bounded
from ross_payload.config.table import Table, read_toml, validated
from ross_payload.errors import ConfigError, OutputError, refused_as

BACKUP = "before"  # in the name under which the old file is kept


def edited(text: str, changes: Mapping[str, Any]) -> str:
    r"""Return TOML with other values for some keys, ``table.key``; a table or key that is missing is added.

    >>> print(edited("[array]  # mine\nspacing_m = 0.05  # as ordered", {"array.spacing_m": 0.0642}))
    [array]  # mine
    spacing_m = 0.0642  # as ordered
    """
    import tomlkit  # noqa: PLC0415  only where something is written

    document = tomlkit.parse(text)
    for name, value in changes.items():
        table, key = name.split(".")
        if table not in document:
            document[table] = tomlkit.table()
        document[table][key] = value
    return tomlkit.dumps(document)


def write_changes(path: Path, changes: Mapping[str, Any], model: type[Table]) -> Path:
    """Change keys of a file, whole or not at all; return where the old file is kept.

    A link stays one, and mode and owner stay as far as this user may set them.

    Raises
    ------
    ConfigError
        When the file cannot be read, or would not be good any more.
    OutputError
        When it cannot be written: nothing has changed, unless it says so.
    """
    file = path.resolve()
    before = read_toml(file)
    with refused_as(ConfigError, f"{path}: cannot be read"):
        text = edited(read_bounded(file).decode("utf-8-sig"), changes)
    with refused_as(OutputError, f"{path}: cannot be written"), replacing(file, 0o600) as part:
        part.write_bytes(text.encode())
        after = read_toml(part)
        validated(model, after, str(path))
        if after != _with(before, changes):
            raise ConfigError(f"{path}: its tables cannot be edited safely; change it by hand: {as_toml(changes)}")
        shutil.copymode(file, part)
        with suppress(PermissionError):
            os.chown(part, file.stat().st_uid, file.stat().st_gid)
        synchronise(part)
        kept = _kept(file)
    with refused_as(OutputError, f"{path}: was written, and may be lost at a power cut"):
        synchronise(file.parent)
    return kept


def as_toml(changes: Mapping[str, Any]) -> str:
    """Write keys and values as they stand in a file, with dots.

    >>> as_toml({"array.spacing_m": 0.064, "audio.invert": [False, True]})
    'array.spacing_m = 0.064, audio.invert = [false, true]'
    """
    return ", ".join(f"{key} = {str(value).lower()}" for key, value in changes.items())


def _with(values: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    wanted: dict[str, Any] = {key: dict(value) if isinstance(value, dict) else value for key, value in values.items()}
    for name, value in changes.items():
        table, key = name.split(".")
        wanted.setdefault(table, {})[key] = value
    return wanted


def _kept(file: Path) -> Path:
    """Keep the old file beside the new one, under a name that is free, also after a power cut."""
    names = (file.with_name(f"{file.name}.{BACKUP}{'' if n == 1 else f'-{n}'}") for n in count(1))
    free = next(name for name in names if not os.path.lexists(name))
    with replacing(free, 0o600) as part:
        shutil.copy2(file, part)
        synchronise(part)
    synchronise(file.parent)  # the copy is there for good before the file itself is replaced
    return free
