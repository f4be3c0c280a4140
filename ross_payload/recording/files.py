"""Files that only their owner can read, and that hold what was written to them when the process is killed."""

from __future__ import annotations

import json
import os
from io import FileIO
from pathlib import Path
from typing import Any


def create(path: Path) -> FileIO:
    """Make a new file, mode 0600, without a buffer of our own."""
    return FileIO(os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600), "r+")


def append(file: FileIO, data: bytes) -> None:
    """Write all of it; a disk that takes only a part of it raises with the rest."""
    view = memoryview(data)
    while view:
        view = view[file.write(view) or 0 :]


def put(path: Path, data: bytes) -> None:
    """Write a small file so that it is whole or not there, also after a power cut."""
    part = path.with_name(f".{path.name}.part")
    part.unlink(missing_ok=True)
    with create(part) as file:
        append(file, data)
        os.fsync(file.fileno())
    part.replace(path)


def put_json(path: Path, values: Any) -> None:
    """Write plain values as indented JSON, whole or not at all."""
    put(path, (json.dumps(values, indent=2, allow_nan=False) + "\n").encode())
