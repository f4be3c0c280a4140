"""The networks that a user has added, and which model of voices is in use."""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from ross_payload.atomic_files import remove_leftovers, write_whole
from ross_payload.bounded_files import MB, parsed_json, read_bounded
from ross_payload.errors import ConfigError, near, shown, unkept, unknown
from ross_payload.voiceprint.built_in import built_in_model
from ross_payload.voiceprint.embedding_model import EmbeddingModel
from ross_payload.voiceprint.embedding_print import Calibration
from ross_payload.voiceprint.speaker_model import VoiceModel
from ross_payload.voiceprint.store import data_folder, names_in

LARGEST = 512 * MB
BUILT_IN, AUTO = "built-in", "auto"
SUFFIX = ".onnx"

ANY = Calibration((21.9, 22.1), (0.345, 0.411), poor=(11.5, 0.102))
"""Of CAM++ (Wang et al., Interspeech 2023) for Chinese and English, with 192 numbers: the first guess for any other.

Measured by `ross_sim.study.calibrate_voice_model` on seven talkers of other corpora than those who trained the built-in
model, three and four at a time in S2, A0.45 and B0.45, eight mixtures of each, seed 0.
"""


@dataclass(frozen=True, slots=True)
class ModelFolder:
    """A folder of networks, one ONNX file per name, with its calibration beside it where it has one of its own."""

    folder: Path

    @classmethod
    def default(cls, environment: Mapping[str, str] = os.environ) -> ModelFolder:
        """Return that of this user: ``$XDG_DATA_HOME/ross/voice-models``, or below ``~/.local/share``."""
        return cls(data_folder(environment) / "voice-models")

    def names(self) -> tuple[str, ...]:
        """Return what was added, sorted.

        Raises
        ------
        ConfigError
            When the folder cannot be read.
        """
        return names_in(self.folder, SUFFIX)

    def path(self, name: str) -> Path:
        """Return the file of a name."""
        return self.folder / (name + SUFFIX)

    def add(self, source: Path, calibration: Path | None = None) -> EmbeddingModel:
        """Check a network and keep a copy of it under the name of its file, in place of an earlier one.

        Raises
        ------
        ConfigError
            When it cannot be read or kept, is no network of speakers, or its name or calibration is wrong.
        OutputError
            When the disk takes no more.
        """
        name = source.name.removesuffix(SUFFIX)
        if not re.fullmatch(r"\w[\w.-]{0,63}", name) or name in (BUILT_IN, AUTO) or source.suffix != SUFFIX:
            expected = "at most 64 letters, digits, '_', '-' and '.' and then .onnx as the name of a file"
            raise ConfigError(f"expected {expected}, got {shown(source.name or str(source))}")
        content = read_model(source)
        read = _calibration(calibration) if calibration is not None else ANY
        model = EmbeddingModel(content, str(source), read)
        remove_leftovers(self.folder, f"*{SUFFIX}")
        try:
            write_whole(self.path(name), content)
            beside = self._calibration_path(name)
            if calibration is None:
                beside.unlink(missing_ok=True)
            else:
                write_whole(beside, json.dumps(asdict(read)).encode())
        except OSError as error:
            raise unkept(f"{self.folder}: the model cannot be kept", error) from error
        return model

    def load(self, name: str) -> EmbeddingModel:
        """Return a network.

        Raises
        ------
        ConfigError
            When there is none of that name, or it cannot be used.
        """
        if name not in self.names():
            raise ConfigError(unknown("voice model", name, (AUTO, BUILT_IN, *self.names())))
        path, beside = self.path(name), self._calibration_path(name)
        calibration = _calibration(beside) if beside.exists() else ANY
        try:
            found = path.stat()
        except OSError as error:
            raise ConfigError(f"{path}: no voice model can be read: {error.strerror}") from error
        return _network(path, (found.st_ino, found.st_mtime_ns, found.st_size), calibration)

    def remove(self, name: str) -> None:
        """Delete a network.

        Raises
        ------
        ConfigError
            When there is none of that name, or it cannot be deleted.
        """
        remove_leftovers(self.folder, f"*{SUFFIX}")
        if name not in self.names():  # nor a path to a file elsewhere
            raise ConfigError(f"no voice model {shown(name)} was added{near(name, self.names())}")
        try:
            self.path(name).unlink(missing_ok=True)
            self._calibration_path(name).unlink(missing_ok=True)
        except OSError as error:
            raise ConfigError(f"{self.path(name)}: cannot be deleted: {error.strerror}") from error

    def in_use(self, choice: str = AUTO) -> VoiceModel:
        """Return the model of a configuration's choice: ``auto`` is the network that was added, if there is one.

        Raises
        ------
        ConfigError
            When the choice is unknown, cannot be used, or ``auto`` could be any of several networks.
        """
        names = self.names()
        if choice == AUTO and len(names) > 1:
            raise ConfigError(f"expected one of {', '.join(names)} or {BUILT_IN} as voice model, got '{AUTO}'")
        if choice == BUILT_IN or (choice == AUTO and not names):
            return built_in_model()
        return self.load(names[0] if choice == AUTO else choice)

    def _calibration_path(self, name: str) -> Path:
        return self.folder / (name + ".json")


@lru_cache(maxsize=2)
def _network(path: Path, _version: tuple[int, int, int], calibration: Calibration) -> EmbeddingModel:
    """Open a network, once for each version of its file: every task asks for it."""
    return EmbeddingModel(read_model(path), str(path), calibration)


def read_model(path: Path) -> bytes:
    """Read the file of a network.

    Raises
    ------
    ConfigError
        When it cannot be read, or is too large for one.
    """
    try:
        return read_bounded(path, LARGEST)
    except OSError as error:
        raise ConfigError(f"{path}: no voice model can be read: {error.strerror}") from error


def _calibration(path: Path) -> Calibration:
    """Read a calibration: slopes and thresholds at 3 and 10 s, those of poor voices, and how they were measured."""
    try:
        content: Any = parsed_json(read_bounded(path))
        (short, long), (low, high) = (map(float, content[key]) for key in ("slopes", "thresholds"))
        told = content.get("poor")  # which is newer than the rest
        slope, threshold = (short, low) if told is None else map(float, told)
        inside = all(-1 < each < 1 for each in (low, high, threshold))
        if not inside or not all(0 < each < math.inf for each in (short, long, slope)):
            raise ValueError("slopes above 0 and thresholds between -1 and 1")
        poor = None if told is None else (slope, threshold)
        return Calibration((short, long), (low, high), str(content["source"]), poor)
    except OSError as error:
        raise ConfigError(f"{path}: no calibration can be read: {error.strerror}") from error
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        ends = "[at 3 s, at 10 s]"
        expected = f"{{'slopes': {ends}, 'thresholds': {ends}, 'poor': [slope, threshold], 'source': 'how'}}"
        raise ConfigError(f"{path}: expected a calibration {expected}, got {error}") from error
