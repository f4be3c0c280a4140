"""Files that appear whole or not at all."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ross_payload.ground.errors import GroundError


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """Give a place beside ``path``; what lies there in the end replaces it, unless something went wrong.

    Raises
    ------
    GroundError
        When it cannot be written.
    """
    try:
        with tempfile.TemporaryDirectory(prefix=f".{path.name}-", dir=path.parent) as folder:
            aside = Path(folder) / path.name
            yield aside
            aside.replace(path)
    except OSError as error:
        raise GroundError(f"{path}: cannot be written: {error.strerror}") from error
