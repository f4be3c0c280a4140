"""The folder of a study: a journal that a kill cannot spoil, and results that appear whole.

Every finished task is one line of ``journal.jsonl``, on the disk before the next one counts. A line that a crash cut
short is dropped. ``study.json`` says what the journal belongs to: another study, other voices or another version of
the code are never mixed with it.
"""

from __future__ import annotations

import csv
import fcntl
import hashlib
import io
import json
import os
import platform
import typing
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import asdict, fields
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import ross_payload
import ross_sim
import ross_sim.study
from ross_payload.atomic_files import replacing
from ross_payload.bounded_files import parsed_json, read_bounded
from ross_payload.errors import ConfigError, OutputError, refused_as
from ross_sim.study.result_rows import Result, columns, decode
from ross_sim.study.study_design import Study

PACKAGES = ("numpy", "scipy", "scikit-learn", "pyroomacoustics")  # what the numbers depend on
FINGERPRINTED = {  # so do these parts of the code
    ross_payload: (
        *(f"{room}/*.py" for room in ("dsp", "localization", "separation", "alignment")),
        "separation/*.npz",
        "plugin_checks.py",
        "angles.py",
    ),
    ross_sim: ("acoustics/room.py", "acoustics/impulse_responses.py", "talkers/speech.py"),
    ross_sim.study: tuple(
        f"{name}.py"
        for name in (
            "baselines",
            "exploration",
            "mixtures",
            "oracle_separators",
            "result_rows",
            "room_settings",
            "scoring",
            "study_case",
            "talker_placement",
        )
    ),
}


def manifest(study: Study, voices: dict[str, str]) -> dict[str, Any]:
    """Everything that two runs must share for their rows to be comparable."""
    versions = {"python": platform.python_version()} | {name: _version(name) for name in ("ross-payload", *PACKAGES)}
    values = study.model_dump(mode="json")
    return {"study": values, "talkers": voices, "versions": versions, "code": code_hash()}


def code_hash() -> str:
    """Fingerprint of the code that the numbers depend on."""
    digest = hashlib.sha256()
    for path in sources():
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()[:16]


def sources() -> Iterator[Path]:
    """The files that the numbers depend on."""
    for package, patterns in FINGERPRINTED.items():
        root = Path(str(package.__file__)).parent
        yield from sorted(path for pattern in patterns for path in root.glob(pattern))


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None


class Store(AbstractContextManager["Store"]):
    """The folder of one study, open for one process at a time.

    Raises
    ------
    ConfigError
        When it cannot be written, another process uses it, or it holds another study.
    """

    def __init__(self, folder: Path, wanted: dict[str, Any]) -> None:
        self.folder = folder
        self.results: dict[str, Result] = {}
        with refused_as(ConfigError, f"--out {folder}: cannot be written"):
            folder.mkdir(parents=True, exist_ok=True)
            self._file = (folder / "journal.jsonl").open("ab+")
        try:
            self._open(wanted)
        except BaseException:
            self._file.close()
            raise

    def _open(self, wanted: dict[str, Any]) -> None:
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            raise ConfigError(f"--out {self.folder}: another study is writing there") from error
        self._file.seek(0)
        whole = 0
        for line in self._file:
            if not line.endswith(b"\n"):
                break
            whole += len(line)
            self._remember(line)
        self._claim(wanted)
        self._file.truncate(whole)

    def _remember(self, line: bytes) -> None:
        try:
            result = decode(parsed_json(line))
        except (ValueError, KeyError, TypeError) as error:
            raise ConfigError(
                f"{self.folder / 'journal.jsonl'}: expected lines of a study, got something else: {error}"
            ) from error
        self.results[result.task] = result

    def _claim(self, wanted: dict[str, Any]) -> None:
        """Take an empty folder; refuse that of another study."""
        path = self.folder / "study.json"
        if not self.results:
            self.write("study.json", (json.dumps(wanted, indent=2) + "\n").encode())
            return
        try:
            found = parsed_json(read_bounded(path))
        except (OSError, ValueError) as error:
            raise ConfigError(f"{path}: cannot be read, so the journal beside it may be another study's") from error
        other = difference(found, wanted)
        if other:
            raise ConfigError(f"--out {self.folder}: holds another study ({other}); choose another folder")

    def add(self, result: Result) -> None:
        """Write down a result; when this returns it is on the disk.

        Raises
        ------
        OutputError
            When the disk is full or gone.
        """
        with refused_as(OutputError, f"{self.folder / 'journal.jsonl'}: cannot be written"):
            self._file.write(json.dumps(asdict(result), allow_nan=False).encode() + b"\n")
            self._file.flush()
            os.fsync(self._file.fileno())
        self.results[result.task] = result

    def write(self, name: str, content: bytes) -> None:
        """Write a whole file, or nothing of it.

        Raises
        ------
        OutputError
            When the disk is full or gone.
        """
        with self.writing(name) as path:
            path.write_bytes(content)

    @contextmanager
    def writing(self, name: str) -> Iterator[Path]:
        """Give a temporary place that becomes the file when everything went well."""
        there = self.folder / name
        with refused_as(OutputError, f"{there}: cannot be written"), replacing(there) as path:
            yield path

    def __exit__(self, kind: type[BaseException] | None, *rest: object) -> None:
        try:
            self._file.close()
        except OSError as failure:  # what could not be flushed is not counted as done
            if kind is None:
                raise OutputError(f"{self.folder}: cannot be written: {failure.strerror}") from failure


def difference(found: Any, wanted: Any, where: str = "") -> str:
    """The first thing in which two manifests differ, in words; empty when they are the same.

    >>> difference({"study": {"seed": 1}}, {"study": {"seed": 2}})
    'seed is 1, not 2'
    """
    if isinstance(found, dict) and isinstance(wanted, dict):
        for key in dict.fromkeys([*wanted, *found]):
            words = difference(found.get(key), wanted.get(key), key)
            if words:
                return words
        return ""
    return "" if found == wanted else f"{where} is {_short(found)}, not {_short(wanted)}"


def _short(value: Any) -> str:
    text = ", ".join(map(str, value)) if isinstance(value, list) else str(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def as_csv(rows: Sequence[Any], kind: type[Any]) -> bytes:
    """Rows as CSV; lists are separated by spaces, and what is not known is empty."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns(kind))
    for row in rows:
        writer.writerow([_cell(getattr(row, name)) for name in columns(kind)])
    return text.getvalue().encode()


def _cell(value: Any) -> str:
    if isinstance(value, tuple):
        return " ".join(map(_cell, value))
    if isinstance(value, bool):
        return str(value).lower()
    return "" if value is None else str(value)


def has_parquet() -> bool:
    """Whether the package that writes Parquet is here."""
    return find_spec("pyarrow") is not None


def parquet_schema(kind: type[Any]) -> Any:
    """Columns and their types, from the fields of a kind of row; needs the extra ``study``."""
    import pyarrow as pa

    plain = {str: pa.string(), int: pa.int64(), float: pa.float64(), bool: pa.bool_()}

    def type_of(hint: Any) -> Any:
        if hint in plain:
            return plain[hint]
        first = typing.get_args(hint)[0]
        return pa.list_(plain[first]) if typing.get_origin(hint) is tuple else plain[first]

    hints = typing.get_type_hints(kind)
    return pa.schema([(field.name, type_of(hints[field.name])) for field in fields(kind)])


def write_parquet(path: Path, rows: Sequence[Any], kind: type[Any]) -> None:
    """Write rows as one Parquet file; needs the extra ``study``."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = pa.Table.from_pylist([asdict(row) for row in rows], schema=parquet_schema(kind))
    pq.write_table(table, path)
