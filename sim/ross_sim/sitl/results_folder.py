"""A folder of results that is either the old one or the new one, file by file, and never half-written."""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path
from typing import Any

from ross_payload.atomic_files import json_text, make_private
from ross_payload.errors import ConfigError, OutputError, refused_as

OURS = re.compile(
    r"(report|timing|truth)\.json|events\.jsonl|azimuths\.csv|mixture\.wav|target\.wav|(group|image)-\d+\.wav|mission\.(png|tlog)"
)


class ResultsFolder(AbstractContextManager["ResultsFolder"]):
    """Collects results in a hidden folder beside its place and moves them there when closed.

    What has the name of a result is taken for an earlier mission's and replaced; other files are left alone. A folder
    that had to be made is for its owner alone, and removed again when there are no results.

    Raises
    ------
    ConfigError
        When the folder cannot be made or written, before anything is simulated.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        with refused_as(ConfigError, f"--out {path}: cannot be written"):
            self._made = not os.path.lexists(path)
            make_private(path)  # voices of people
            self.staging = Path(tempfile.mkdtemp(prefix=".mission-", dir=path))

    def write_text(self, name: str, text: str) -> None:
        """Write a small file.

        Raises
        ------
        OutputError
            When the disk is full or gone.
        """
        with self.writing(name) as path:
            path.write_text(text, encoding="utf-8")

    @contextmanager
    def writing(self, name: str) -> Iterator[Path]:
        """Give the place of a file; what goes wrong with the disk meanwhile becomes an OutputError."""
        with refused_as(OutputError, f"{self.path / name}: cannot be written"):
            yield self.staging / name

    def write_json(self, name: str, values: Any) -> None:
        """Write plain values as indented JSON."""
        self.write_text(name, json_text(values))

    def close(self, complete: bool) -> None:
        """Put the results in place when they are complete; otherwise leave the earlier ones as they were."""
        try:
            if complete:
                for stale in [old for old in self.path.iterdir() if OURS.fullmatch(old.name)]:
                    stale.unlink()
                for file in sorted(self.staging.iterdir()):
                    os.replace(file, self.path / file.name)  # noqa: PTH105 - the atomic rename
        except OSError as error:
            raise OutputError(f"{self.path}: cannot be written: {error.strerror}") from error
        finally:
            shutil.rmtree(self.staging, ignore_errors=True)
            if self._made and not complete:
                with suppress(OSError):
                    self.path.rmdir()

    def __exit__(self, kind: type[BaseException] | None, *rest: object) -> None:
        self.close(complete=kind is None)
