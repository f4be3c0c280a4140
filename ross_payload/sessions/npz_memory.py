"""What a session knows beside its Inputs, as .npz files without pickle: a memory, and the print of a synthetic voice.

A person's print is never written.
"""

from __future__ import annotations

import io
import json
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, TypeVar, get_args, get_origin, get_type_hints
from zipfile import BadZipFile

import numpy as np
from pydantic import TypeAdapter, ValidationError

from ross_payload.bounded_files import MB, read_bounded
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Real
from ross_payload.voiceprint import EmbeddingPrint, VoiceModel, built_in_model

T = TypeVar("T")
LARGEST = 64 * MB
VOICE_FILE = "voice.npz"


def packed(value: Any) -> bytes:
    """Pack a dataclass: arrays as they are, everything else as JSON, which keeps every float; None is left out."""
    arrays = {}
    for field in fields(value):
        content = getattr(value, field.name)
        if content is not None and not isinstance(content, np.ndarray):
            content = np.array(json.dumps(TypeAdapter(type(content)).dump_python(content, mode="json")))
        if content is not None:
            arrays[field.name] = content
    file = io.BytesIO()
    np.savez(file, **arrays)
    return file.getvalue()


def unpacked(path: Path, kind: type[T], *, others: bool = False) -> T:
    """Read a dataclass again; ``others``: the file may have fields beside those of the dataclass.

    Raises
    ------
    ConfigError
        When the file is damaged or was made for another program.
    """
    hints = get_type_hints(kind)
    try:
        with np.load(io.BytesIO(read_bounded(path, LARGEST)), allow_pickle=False) as arrays:
            if (size := sum(about.file_size for about in arrays.zip.infolist())) > LARGEST:
                raise ValueError(f"expected at most {LARGEST:,} bytes when unpacked, got {size:,}")
            values = {name: _value(arrays[name], hints[name]) for name in arrays.files if name in hints or not others}
        return kind(**values)
    except (OSError, ValueError, KeyError, TypeError, ValidationError, EOFError, BadZipFile, RuntimeError) as error:
        raise ConfigError(f"{path.name}: damaged, or of another version: {error!r}") from error


def _value(content: Any, hint: Any) -> Any:
    if content.dtype.kind == "U":
        return TypeAdapter(hint).validate_json(str(content))
    if not any((get_origin(each) or each) is np.ndarray for each in (hint, *get_args(hint))):
        raise ValueError(f"expected {hint}, got an array")
    if content.dtype.kind not in "fiu" or not np.isfinite(content).all():
        raise ValueError(f"expected finite numbers, got {content.dtype}")
    return content


@dataclass(frozen=True, slots=True)
class StoredPrint:
    """What a print is made of beside its model."""

    embedding: Real
    seconds: float
    criterion: float
    background: str  # the fingerprint of the model


def packed_voice(voice: EmbeddingPrint) -> bytes:
    """Return the content of the file."""
    return packed(StoredPrint(voice.embedding, voice.seconds, voice.criterion, voice.fingerprint))


def restored_voice(path: Path, used: VoiceModel | None = None) -> EmbeddingPrint:
    """Read it again; it was made with the built-in model, or with the one that is ``used``.

    Raises
    ------
    ConfigError
        When the file is damaged, or was made with another model.
    """
    models = {model.fingerprint: model for model in (used, built_in_model()) if model is not None}
    model = models.get(unpacked(path, _AnyPrint, others=True).background)
    if model is None:
        other = "made with another model of voices than the one in use: see ross voice-model list"
        raise ConfigError(f"{path.name}: {other}")
    values = unpacked(path, StoredPrint)
    if values.embedding.shape != (model.size,):
        raise ConfigError(f"{path.name}: damaged: expected {model.size} numbers, got {values.embedding.shape}")
    if not np.isfinite([values.seconds, values.criterion]).all():
        raise ConfigError(f"{path.name}: damaged: expected finite numbers")
    return EmbeddingPrint(values.embedding, values.seconds, model, values.criterion)


@dataclass(frozen=True, slots=True)
class _AnyPrint:
    """What every version of the file says."""

    background: str
