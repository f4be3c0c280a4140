"""The folder of a study: a journal that a kill cannot spoil, and results that appear whole.

Every finished task is one line of ``journal.jsonl``, on the disk before the next one counts. A line that a crash cut
short is dropped. ``study.json`` says what the journal belongs to: another study, other voices or another version of
the code are never mixed with it.
"""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
import platform
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from dataclasses import asdict
from importlib.metadata import EntryPoint, PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import IO, Any, ClassVar, Generic, Protocol, TypeVar

import ross_payload
import ross_sim
import ross_sim.study
from ross_payload import plugins
from ross_payload.atomic_files import replacing
from ross_payload.bounded_files import parsed_json, read_bounded
from ross_payload.config import Table
from ross_payload.errors import ConfigError, OutputError, refused_as

Code = dict[ModuleType, tuple[str, ...]]  # packages, and patterns of files in them
PACKAGES = ("numpy", "scipy", "scikit-learn", "pyroomacoustics")  # what the numbers depend on
FINGERPRINTED: Code = {  # so do these parts of the code
    ross_payload: (
        *(f"{room}/*.py" for room in ("config", "dsp", "localization", "separation", "alignment")),
        "actuators/motion.py",
        "separation/*.npz",
        "localization/*.json",
        "localization/*.npz",
        *(f"{name}.py" for name in ("angles", "events", "interfaces", "plugin_checks", "plugin_results")),
    ),
    ross_sim: ("acoustics/room.py", "acoustics/render.py", "acoustics/impulse_responses.py", "talkers/speech.py"),
    ross_sim.study: tuple(
        f"{name}.py"
        for name in (
            "baselines",
            "oracle_separators",
            "rows/exploration_ends",
            "rows/result_rows",
            "runs/exploration_course",
            "runs/scoring",
            "runs/study_case",
            "runs/study_design",
            "runs/talker_placement",
            "scenes/exploration",
            "scenes/mixtures",
            "scenes/room_settings",
            "scenes/turning_render",
        )
    ),
}


class Measured(Protocol):
    """All rows of one task, as a dataclass."""

    __dataclass_fields__: ClassVar[dict[str, Any]]

    @property
    def task(self) -> str:
        """What the task is called."""


Rows = TypeVar("Rows", bound=Measured)


def manifest(
    study: Table, voices: dict[str, str], code: Code = FINGERPRINTED, named: Iterable[tuple[str, str]] = ()
) -> dict[str, Any]:
    """Everything that two runs must share for their rows to be comparable; ``named``: group and name of plug-ins.

    Raises
    ------
    PluginError
        When a plug-in is not there or cannot be imported.
    """
    return {"study": study.model_dump(mode="json")} | basis_of(voices, code, named)


def basis_of(voices: dict[str, str], code: Code, named: Iterable[tuple[str, str]] = ()) -> dict[str, Any]:
    """What rows depend on beside what is asked for: voices, versions, code, and plug-ins that are not built in.

    Raises
    ------
    PluginError
        When a plug-in is not there or cannot be imported.
    """
    versions = {"python": platform.python_version()} | {name: _version(name) for name in ("ross-payload", *PACKAGES)}
    others = plugin_versions(named)
    found = {"talkers": voices, "versions": versions, "code": code_hash(code)}
    return found | ({"plug-ins": others} if others else {})


def plugin_versions(named: Iterable[tuple[str, str]]) -> dict[str, str]:
    """Distribution, version and fingerprint of the code of plug-ins that are not built in, by name.

    Raises
    ------
    PluginError
        When one is not there or cannot be imported.
    """
    found = {}
    for group, name in sorted(set(named)):
        point = plugins.available(group).get(name)
        if point is not None and point.dist is not None and point.dist.name == plugins.PACKAGE:
            continue
        plugins.load(group, name)
        point = plugins.available(group)[name]
        told = "unknown" if point.dist is None else f"{point.dist.name} {point.dist.version}"
        found[name] = f"{told}, code {_hash(_modules(point))}"
    return found


def _modules(point: EntryPoint) -> list[Path]:
    """The module of a plug-in, or where it is in a package, all of that."""
    spec = find_spec(point.module.partition(".")[0])
    if spec is None:
        return []
    folders = [Path(folder) for folder in spec.submodule_search_locations or ()]
    alone = [Path(spec.origin)] if spec.origin and not folders else []
    return alone + sorted(path for folder in folders for path in folder.rglob("*.py"))


def code_hash(code: Code = FINGERPRINTED) -> str:
    """Fingerprint of the code that the numbers depend on."""
    return _hash(sources(code))


def _hash(paths: Iterable[Path]) -> str:
    digest = hashlib.sha256()
    for path in paths:
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()[:16]


def sources(code: Code = FINGERPRINTED) -> Iterator[Path]:
    """The files that the numbers depend on."""
    for package, patterns in code.items():
        root = Path(str(package.__file__)).parent
        yield from sorted(path for pattern in patterns for path in root.glob(pattern))


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None


class Results(Mapping[str, Rows]):
    """What a journal holds, by task: every result is read when it is asked for, so that none is kept in memory."""

    def __init__(self, file: IO[bytes], read: Callable[[bytes], Rows]) -> None:
        self._file, self._read = file, read
        self._places: dict[str, tuple[int, int]] = {}  # offset and length of the line of a task [bytes]

    def note(self, task: str, offset: int, length: int) -> None:
        """Learn where the line of a task is; the last one counts."""
        self._places[task] = offset, length

    def __getitem__(self, task: str) -> Rows:
        offset, length = self._places[task]
        return self._read(os.pread(self._file.fileno(), length, offset))

    def __iter__(self) -> Iterator[str]:
        return iter(self._places)

    def __len__(self) -> int:
        return len(self._places)


class Store(AbstractContextManager["Store[Rows]"], Generic[Rows]):
    """The folder of one study, open for one process at a time.

    Parameters
    ----------
    folder
        Made when it is not there.
    wanted
        The `manifest` of the study.
    decode
        Turns the plain values of a line of the journal back into the rows of a task.

    Raises
    ------
    ConfigError
        When it cannot be written, another process uses it, or it holds another study.
    """

    def __init__(self, folder: Path, wanted: dict[str, Any], decode: Callable[[dict[str, Any]], Rows]) -> None:
        self.folder = folder
        self._decode = decode
        with refused_as(ConfigError, f"--out {folder}: cannot be written"):
            folder.mkdir(parents=True, exist_ok=True)
            self._file = (folder / "journal.jsonl").open("ab+")
        self.results = Results(self._file, lambda line: _decoded(line, decode, folder))
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
            self.results.note(_decoded(line, self._decode, self.folder).task, whole, len(line))
            whole += len(line)
        self._claim(wanted)
        self._file.truncate(whole)

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
        was = found.get("versions") if isinstance(found, dict) else None
        absent = {name: None for name, each in was.items() if each is None} if isinstance(was, dict) else {}
        same = {"versions": wanted["versions"] | absent} if absent else {}  # a package that was absent made no row
        other = difference(found, wanted | same)
        if not other and absent:
            self.write("study.json", (json.dumps(wanted, indent=2) + "\n").encode())
        if other:
            raise ConfigError(f"--out {self.folder}: holds another study ({other}); choose another folder")

    def add(self, result: Rows) -> None:
        """Write down a result; when this returns it is on the disk.

        Raises
        ------
        OutputError
            When the disk is full or gone.
        """
        line = json.dumps(asdict(result), allow_nan=False).encode() + b"\n"
        with refused_as(OutputError, f"{self.folder / 'journal.jsonl'}: cannot be written"):
            self._file.write(line)
            self._file.flush()
            os.fsync(self._file.fileno())
        self.results.note(result.task, self._file.tell() - len(line), len(line))

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


def journal(folder: Path, decode: Callable[[dict[str, Any]], Rows]) -> Iterator[Rows]:
    """Give what a study has kept, without opening it for writing; a line that was cut short does not count.

    Raises
    ------
    ConfigError
        When there is no journal, or it holds something else.
    """
    try:
        content = (folder / "journal.jsonl").read_bytes()
    except OSError as error:
        raise ConfigError(f"{folder}: expected the folder of a study, got none: {error.strerror}") from error
    for line in content.splitlines(keepends=True):
        if line.endswith(b"\n"):
            yield _decoded(line, decode, folder)


def _decoded(line: bytes, decode: Callable[[dict[str, Any]], Rows], folder: Path) -> Rows:
    try:
        return decode(parsed_json(line))
    except (ValueError, KeyError, TypeError) as error:
        raise ConfigError(
            f"{folder / 'journal.jsonl'}: expected lines of a study, got something else: {error}"
        ) from error


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
