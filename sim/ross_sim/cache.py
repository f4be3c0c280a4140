"""Arrays on disk that may be lost, cut short or written twice at once without harm."""

from __future__ import annotations

import hashlib
import json
import os
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ross_payload.atomic_files import replacing
from ross_payload.errors import ConfigError
from ross_payload.named_paths import home_folder

Array = NDArray[Any]

_UNREADABLE = (OSError, EOFError, KeyError, ValueError, NotImplementedError, zipfile.BadZipFile, zlib.error)


def cache_folder(folder: Path | None = None) -> Path:
    """Where to keep things: ``folder``, else ROSS_CACHE, else ross in XDG_CACHE_HOME, else in ~/.cache."""
    if folder is not None:
        return folder
    own = os.environ.get("ROSS_CACHE")
    if own:
        return Path(own)
    return Path(os.environ.get("XDG_CACHE_HOME") or home_folder("XDG_CACHE_HOME") / ".cache") / "ross"


def fingerprint(**values: Any) -> str:
    """Hash everything that a cached array depends on; numbers count to their last bit.

    >>> fingerprint(t60=0.1 + 0.2) == fingerprint(t60=0.3)
    False
    """
    return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()[:32]


def cached(path: Path, make: Callable[[], dict[str, Array]]) -> dict[str, Array]:
    """Read arrays from ``path``; when the file is missing or damaged, make them, write them and read them back.

    They come from the disk on the first run also, so that the first and every later run compute with the same bytes.
    A file appears under its name only when complete, and what a crash cuts short its checksum tells; of two writers
    the last wins, with the same content.

    Raises
    ------
    ConfigError
        When the folder cannot be written.
    """
    found = _read(path)
    if found is None:
        _write(path, make())
        found = _read(path)
    if found is None:
        raise ConfigError(f"{path}: written but cannot be read back; set ROSS_CACHE to another folder")
    return found


def _read(path: Path) -> dict[str, Array] | None:
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            return {name: arrays[name] for name in arrays.files}  # the archive's checksums are compared here
    except _UNREADABLE:
        return None


def _write(path: Path, arrays: dict[str, Array]) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with replacing(path, 0o600) as part, part.open("wb") as file:
            np.savez(file, allow_pickle=False, **arrays)
    except OSError as error:
        raise ConfigError(
            f"{path.parent}: the cache cannot be written: {error.strerror}; set ROSS_CACHE to another folder"
        ) from error
