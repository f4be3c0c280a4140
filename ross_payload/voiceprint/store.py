"""Keep voice prints: personal data, in files that only their owner can read."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ross_payload.atomic_files import PART, remove_leftovers, write_whole
from ross_payload.bounded_files import MB, parsed_json, read_bounded
from ross_payload.errors import ConfigError, near, refused_as, shown, unkept
from ross_payload.named_paths import home_folder
from ross_payload.voiceprint.built_in import built_in_model
from ross_payload.voiceprint.embedding_print import EmbeddingPrint, restored_print
from ross_payload.voiceprint.speaker_model import VoiceModel

FORMAT = "ross-voice-print"
VERSION = 1
SUFFIX = ".json"
LARGEST = 8 * MB


def data_folder(environment: Mapping[str, str] = os.environ) -> Path:
    """Return what this user keeps: ``ross`` in ``$XDG_DATA_HOME`` (XDG Base Directory Specification) or its default."""
    home = environment.get("XDG_DATA_HOME", "")
    return (Path(home) if Path(home).is_absolute() else home_folder("XDG_DATA_HOME") / ".local" / "share") / "ross"


def names_in(folder: Path, suffix: str) -> tuple[str, ...]:
    """Return the names of the files with a suffix that are kept in a folder, without it, sorted.

    Raises
    ------
    ConfigError
        When the folder cannot be read.
    """
    with refused_as(ConfigError, f"{folder}: cannot be read"), suppress(FileNotFoundError):
        names = (path.name for path in folder.iterdir())  # which says what `glob` passes over: that it cannot be read
        return tuple(sorted(name.removesuffix(suffix) for name in names if name.endswith(suffix) and name[0] != "."))
    return ()


class Damaged(ConfigError):
    """A file that is no voice print at all, whoever's it was."""


class NameTaken(ConfigError):
    """Somebody else is enrolled under that name."""


def save(voice: EmbeddingPrint, path: Path, *, new: bool = False) -> None:
    """Write a voice print as JSON, readable by its owner only; the file is whole or not there at all.

    Missing folders are made with mode 0700. If ``new``, no file is replaced.

    Raises
    ------
    ConfigError
        When the print is not finite, or the file cannot be written; `NameTaken` when it is to be new and is there.
    OutputError
        When the disk takes no more: what was there before is kept.
    """
    finite = np.isfinite([*voice.embedding, voice.seconds, voice.criterion]).all()
    if not finite or not voice.embedding.any():
        got = "zeros" if finite else "numbers that are not finite"
        raise ConfigError(f"{path}: expected a voice print to compare with, got {got}: the old one is kept, if any")
    content = {
        "format": FORMAT,
        "version": VERSION,
        "background": voice.fingerprint,
        "seconds": voice.seconds,
        "consent": voice.consent,
        **voice.values(),
    }
    try:
        write_whole(path, (json.dumps(content) + "\n").encode(), new=new)
    except OSError as error:
        if new and isinstance(error, FileExistsError) and os.path.lexists(path):
            raise NameTaken(f"{path}: expected a new voice print, got one that is there") from error
        raise unkept(f"{path}: the voice print cannot be written", error) from error


def load(path: Path, model: VoiceModel | None = None) -> EmbeddingPrint:
    """Read a voice print that a model made, the built-in one unless another is given.

    Raises
    ------
    ConfigError
        When the file is missing or damaged, or was made with another model.
    """
    try:
        content = parsed_json(read_bounded(path, LARGEST))
    except OSError as error:
        kind = ConfigError if isinstance(error, PermissionError) else Damaged
        raise kind(f"{path}: no voice print can be read: {error.strerror}") from error
    except ValueError as error:
        raise Damaged(f"{path}: damaged voice print: expected JSON: {error}") from error
    return _decoded(content, model or built_in_model(), path)


@dataclass(frozen=True, slots=True)
class VoiceStore:
    """A folder of voice prints, one file per name."""

    folder: Path

    @classmethod
    def default(cls, environment: Mapping[str, str] = os.environ) -> VoiceStore:
        """Return the store of this user: ``$XDG_DATA_HOME/ross/voices``, or ``~/.local/share/ross/voices``."""
        return cls(data_folder(environment) / "voices")

    def path(self, name: str) -> Path:
        """Return the file of a name.

        Raises
        ------
        ConfigError
            When the name is not made of letters, digits, ``_``, ``-`` and ``.`` (no leading dot), 64 at most.
        """
        if not re.fullmatch(r"\w[\w.-]{0,63}", name):
            raise ConfigError(
                f"expected at most 64 letters, digits, '_', '-' and '.' as the name of a voice, got {shown(name)}"
            )
        return self.folder / (name + SUFFIX)

    def names(self) -> tuple[str, ...]:
        """Return who is enrolled, sorted.

        Raises
        ------
        ConfigError
            When the folder cannot be read.
        """
        return names_in(self.folder, SUFFIX)

    def save(self, name: str, voice: EmbeddingPrint, *, new: bool = False) -> Path:
        """Keep a voice print under a name, in place of an earlier one; returns the file.

        Raises
        ------
        ConfigError
            When it cannot be written; `NameTaken` when it is to be ``new`` and the name has a print.
        OutputError
            When the disk takes no more.
        """
        path = self.path(name)
        remove_leftovers(self.folder, f"*{SUFFIX}")
        save(voice, path, new=new)
        with suppress(OSError):  # somebody else's folder, or a file system without modes; the print has its own
            self.folder.chmod(0o700)
        return path

    def load(self, name: str, model: VoiceModel | None = None) -> EmbeddingPrint:
        """Return the voice print of a name.

        Raises
        ------
        ConfigError
            When nobody of that name is enrolled, or the file is damaged.
        """
        self.check(name)
        return load(self.path(name), model)

    def check(self, name: str) -> None:
        """Refuse a name that is none, or of nobody here.

        Raises
        ------
        ConfigError
            When nobody of that name is enrolled; says who is.
        """
        if not os.path.lexists(self.path(name)):
            known = ", ".join(self.names()) or "none"
            raise ConfigError(f"no voice '{name}' is enrolled; enrolled: {known}{near(name, self.names())}")

    def forget(self, name: str) -> None:
        """Delete the voice print of a name, also what a kill has left of one, and damaged ones that were set aside.

        Raises
        ------
        ConfigError
            When nobody of that name is enrolled, or a file cannot be deleted.
        """
        path = self.path(name)
        ours = re.compile(rf"(\.[0-9a-f]{{8}}{re.escape(PART)}-)?{re.escape(path.name)}(\.unreadable(-\d+)?)?")
        try:
            there = self.folder.iterdir() if self.folder.is_dir() else ()
            found = [each for each in there if ours.fullmatch(each.name)]
            for each in found:
                each.unlink(missing_ok=True)
        except OSError as error:
            raise ConfigError(f"{path}: cannot be deleted: {error.strerror}") from error
        if not found:
            raise ConfigError(f"no voice '{name}' is enrolled{near(name, self.names())}")


def _decoded(content: Any, model: VoiceModel, path: Path) -> EmbeddingPrint:
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise Damaged(f"{path}: expected a voice print, got something else")
    if content.get("version") != VERSION:
        raise ConfigError(f"{path}: expected a voice print of version {VERSION}, got {content.get('version')!r}")
    if content.get("background") != model.fingerprint:
        raise ConfigError(f"{path}: made with another voice model: enrol this voice again")
    try:
        seconds = float(content["seconds"])
        if not np.isfinite(seconds):
            raise ValueError("not finite")
        return restored_print(model, content, seconds, str(content.get("consent", ""))[:200])
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise Damaged(f"{path}: damaged voice print: {error!r}") from error
