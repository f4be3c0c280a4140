"""What the rows of a file depend on, kept in a file beside it: rows of other voices or settings never join them."""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import ross_payload
import ross_sim
import ross_sim.study
from ross_payload.atomic_files import json_text, replacing
from ross_payload.bounded_files import parsed_json, read_bounded
from ross_payload.errors import ConfigError, OutputError, refused_as
from ross_payload.interfaces import Samples
from ross_payload.plugin_checks import load_separator
from ross_sim.study.runs.study_store import FINGERPRINTED, Code, basis_of, difference
from ross_sim.study.runs.talker_placement import heard_as
from ross_sim.study.script_errors import expect_writable
from ross_sim.talkers.speech import TalkerVoice

RECORDED = "recorded noise"  # what its recordings stand under
CODE: Code = {  # behind the rows of studies in noise
    ross_payload: (*FINGERPRINTED[ross_payload], "mission/align.py"),
    ross_sim: ("acoustics/*.py", "noise_tables.py", "scenario.py", "talkers/speech.py"),
    ross_sim.study: (
        *FINGERPRINTED[ross_sim.study],
        *("above_study.py", "rows/above_rows.py", "scenes/above_scenes.py"),
        *("noise_study.py", "rows/noise_rows.py", "scenes/noise_scenes.py"),
    ),
}


def basis_in_noise(
    asked: dict[str, Any], voices: Sequence[TalkerVoice], clips: Sequence[Samples], separator: str
) -> dict[str, Any]:
    """Everything that rows of a study in noise must share to stand in one file: ``asked`` and what it is made of.

    Raises
    ------
    PluginError
        When there is no such separator, or it is none.
    """
    load_separator(separator)
    noise = hashlib.sha256(b"".join(clip.tobytes() for clip in clips)).hexdigest()[:16] if clips else None
    own = basis_of(heard_as(voices), CODE, [("ross_payload.separators", separator)])
    return {"asked": {**asked, "separator": separator}, RECORDED: noise} | own


def manifest_of(rows: Path) -> Path:
    """Where it stands what the rows of a file depend on."""
    return rows.with_name(f"{rows.name}.json")


def claim(rows: Path, wanted: dict[str, Any], later: Collection[str] = ()) -> None:
    """Take a file for rows that depend on ``wanted``; write down beside it that they do.

    Parameters
    ----------
    rows
        The file.
    wanted
        What its rows depend on.
    later
        Names in ``wanted`` that only some rows depend on: those before may know nothing of them.

    Raises
    ------
    ConfigError
        When it holds rows that depend on something else, it is not known on what, or it is a folder.
    OutputError
        When it cannot be written.
    """
    expect_writable(rows)
    path, found = manifest_of(rows), dict[str, Any]()
    if rows.exists():
        try:
            found = parsed_json(read_bounded(path))
        except (OSError, ValueError) as error:
            raise ConfigError(
                f"--out {rows}: holds rows, but {path.name} beside it cannot be read; choose another"
            ) from error
        known = {name: found[name] for name in later if name in found}
        added = {name: wanted[name] for name in later if name in wanted and name not in found}
        other = difference(found | added, json.loads(json_text(known | wanted)))
        if other:
            raise ConfigError(f"--out {rows}: holds rows of another study ({other}); choose another")
        if not added:
            return
    with refused_as(OutputError, f"{path}: cannot be written"):
        rows.parent.mkdir(parents=True, exist_ok=True)
        with replacing(path) as part:
            part.write_text(json_text(found | wanted), encoding="utf-8")


@contextmanager
def held(folder: Path, *, waits: bool) -> Iterator[None]:
    """Write in a folder while nobody else does who holds it; who ``waits`` has its turn after them.

    Raises
    ------
    ConfigError
        When somebody else writes there, and it does not wait.
    """
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        with suppress(OSError):  # a file system without locks
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | (0 if waits else fcntl.LOCK_NB))
            except BlockingIOError as error:
                raise ConfigError(f"{folder}: another command is writing there") from error
        yield
    finally:
        os.close(handle)


@contextmanager
def alone_with(rows: Path) -> Iterator[None]:
    """Add rows to a file while nobody else does: who writes it whole after every row would lose those of others.

    Raises
    ------
    ConfigError
        When another command adds rows to it, or its folder cannot be written.
    """
    expect_writable(rows)
    path, told = rows.with_name(f".{rows.name}.lock"), f"--out {rows}: another command is adding rows to it"
    with refused_as(ConfigError, f"--out {rows}: cannot be written"):
        rows.parent.mkdir(parents=True, exist_ok=True)
        handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_CLOEXEC, 0o666)
    try:
        with suppress(OSError):  # a file system without locks
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError as error:
                raise ConfigError(told) from error
        if not path.exists() or not os.path.samestat(os.fstat(handle), path.stat()):  # its holder has just ended
            raise ConfigError(told)
        try:
            yield
        finally:
            with suppress(OSError):  # of a disk that is no longer written the error of the rows is told
                path.unlink()
    finally:
        os.close(handle)
