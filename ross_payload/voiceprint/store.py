"""Keep voice prints: personal data, in files that only their owner can read."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ross_payload.atomic_files import write_whole
from ross_payload.bounded_files import MB, parsed_json, read_bounded
from ross_payload.errors import ConfigError, near, shown
from ross_payload.voiceprint.background import Adapted, Background, shipped_background
from ross_payload.voiceprint.speaker_model import VoicePrintModel

FORMAT = "ross-voice-print"
VERSION = 1
SUFFIX = ".json"
LARGEST = 8 * MB


class Damaged(ConfigError):
    """A file that is no voice print at all, whoever's it was."""


def save(model: VoicePrintModel, path: Path) -> None:
    """Write a voice print as JSON, readable by its owner only; the file is whole or not there at all.

    Missing folders are made with mode 0700.

    Raises
    ------
    ConfigError
        When the file cannot be written.
    """
    content = {
        "format": FORMAT,
        "version": VERSION,
        "background": model.background.fingerprint,
        "seconds": model.seconds,
        "criterion": model.criterion,
        "consent": model.consent,
        "offsets": np.round(model.voice.offsets, 4).tolist(),
        "pitch_weights": np.round(model.voice.pitch_weights, 6).tolist(),
    }
    try:
        write_whole(path, (json.dumps(content) + "\n").encode())
    except OSError as error:
        raise ConfigError(f"{path}: the voice print cannot be written: {error.strerror}") from error


def load(path: Path, background: Background | None = None) -> VoicePrintModel:
    """Read a voice print.

    Raises
    ------
    ConfigError
        When the file is missing or damaged, or was made with another background model.
    """
    model = background or shipped_background()
    try:
        content = parsed_json(read_bounded(path, LARGEST))
    except OSError as error:
        kind = ConfigError if isinstance(error, PermissionError) else Damaged
        raise kind(f"{path}: no voice print can be read: {error.strerror}") from error
    except ValueError as error:
        raise Damaged(f"{path}: damaged voice print: expected JSON: {error}") from error
    return _decoded(content, model, path)


@dataclass(frozen=True, slots=True)
class VoiceStore:
    """A folder of voice prints, one file per name."""

    folder: Path

    @classmethod
    def default(cls, environment: Mapping[str, str] = os.environ) -> VoiceStore:
        """Return the store of this user: ``$XDG_DATA_HOME/ross/voices``, or ``~/.local/share/ross/voices``."""
        home = environment.get("XDG_DATA_HOME", "")
        base = Path(home) if Path(home).is_absolute() else Path.home() / ".local" / "share"
        return cls(base / "ross" / "voices")

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
        """Return who is enrolled, sorted."""
        return tuple(sorted(path.name.removesuffix(SUFFIX) for path in self.folder.glob(f"[!.]*{SUFFIX}")))

    def save(self, name: str, model: VoicePrintModel) -> Path:
        """Keep a voice print under a name, in place of an earlier one; returns the file."""
        path = self.path(name)
        save(model, path)
        self.folder.chmod(0o700)
        return path

    def load(self, name: str, background: Background | None = None) -> VoicePrintModel:
        """Return the voice print of a name.

        Raises
        ------
        ConfigError
            When nobody of that name is enrolled, or the file is damaged.
        """
        self.check(name)
        return load(self.path(name), background)

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
        """Delete the voice print of a name.

        Raises
        ------
        ConfigError
            When nobody of that name is enrolled, or the file cannot be deleted.
        """
        try:
            self.path(name).unlink()
        except FileNotFoundError as error:
            raise ConfigError(f"no voice '{name}' is enrolled{near(name, self.names())}") from error
        except OSError as error:
            raise ConfigError(f"{self.path(name)}: cannot be deleted: {error.strerror}") from error


def _decoded(content: Any, background: Background, path: Path) -> VoicePrintModel:
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise Damaged(f"{path}: expected a voice print, got something else")
    if content.get("version") != VERSION:
        raise ConfigError(f"{path}: expected a voice print of version {VERSION}, got {content.get('version')!r}")
    if content.get("background") != background.fingerprint:
        raise ConfigError(f"{path}: made with another background model: enrol this voice again")
    try:
        offsets = np.array(content["offsets"], dtype=np.float64)
        pitch = np.array(content["pitch_weights"], dtype=np.float64)
        seconds, criterion = float(content["seconds"]), float(content["criterion"])
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise Damaged(f"{path}: damaged voice print: {error!r}") from error
    if offsets.shape != background.means.shape or pitch.shape != background.pitch_weights.shape:
        raise Damaged(f"{path}: damaged voice print: {offsets.size} + {pitch.size} numbers")
    if not all(np.isfinite(values).all() for values in (offsets, pitch, seconds, criterion)) or (pitch < 0).any():
        raise Damaged(f"{path}: damaged voice print: not finite, or negative weights")
    consent = str(content.get("consent", ""))[:200]
    return VoicePrintModel(Adapted(offsets, pitch), seconds, background, criterion, consent)
