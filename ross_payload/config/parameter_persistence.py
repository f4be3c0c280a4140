"""The file that keeps what was set in flight: read whole or not at all, written crash-safe."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ross_payload.atomic_files import write_whole
from ross_payload.bounded_files import parsed_toml, read_bounded
from ross_payload.errors import ConfigError

VERSION = 1
HEAD = "# Written by ross: what was set in flight, and what the configuration said then.\n"


@dataclass(frozen=True, slots=True)
class StoredValue:
    """One value set in flight."""

    value: float
    replaced: float  # what the configuration said then


class Unusable(ConfigError):
    """The file cannot be used; ``word`` says why, for the name under which it is kept."""

    def __init__(self, word: str, reason: str) -> None:
        super().__init__(reason)
        self.word = word


def read(path: Path) -> dict[str, StoredValue]:
    """Return what the file keeps, by name; nothing when there is no file.

    Raises
    ------
    Unusable
        When it is half-written, damaged, or of a newer version.
    """
    try:
        content = parsed_toml(read_bounded(path))
    except FileNotFoundError:
        return {}
    except OSError as error:
        raise Unusable("unreadable", f"{path}: cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise Unusable("unreadable", f"{path}: damaged: {error}") from error
    version, parameters = content.get("version"), content.get("parameters", {})
    if not isinstance(version, int) or not isinstance(parameters, dict):
        raise Unusable("unreadable", f"{path}: damaged: no version")
    if version > VERSION:
        raise Unusable("newer", f"{path}: expected version {VERSION} at most, got {version}")
    return {name: _kept(path, name, entry) for name, entry in parameters.items()}


def _kept(path: Path, name: str, entry: Any) -> StoredValue:
    match entry:
        case {"value": float() | int() as value, "replaced": float() | int() as replaced}:
            if math.isfinite(value) and math.isfinite(replaced):
                return StoredValue(float(value), float(replaced))
    raise Unusable("unreadable", f"{path}: damaged: {name} is not two numbers")


def write(path: Path, kept: Mapping[str, StoredValue]) -> None:
    """Replace the file: after a crash there is the old one or the new one, whole.

    Raises
    ------
    OSError
        When it cannot be written.
    """
    rows = (f"{name} = {{ value = {k.value!r}, replaced = {k.replaced!r} }}\n" for name, k in sorted(kept.items()))
    write_whole(path, f"{HEAD}version = {VERSION}\n\n[parameters]\n{''.join(rows)}".encode())
