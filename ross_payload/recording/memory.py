"""A frozen dataclass of arrays and plain values as one .npz file, without pickle."""

from __future__ import annotations

import io
import json
from dataclasses import fields
from pathlib import Path
from typing import Any, TypeVar, get_type_hints
from zipfile import BadZipFile

import numpy as np
from pydantic import TypeAdapter, ValidationError

from ross_payload.bounded_files import MB, read_bounded
from ross_payload.errors import ConfigError

T = TypeVar("T")
LARGEST = 64 * MB


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


def unpacked(path: Path, kind: type[T]) -> T:
    """Read a dataclass again.

    Raises
    ------
    ConfigError
        When the file is damaged or was made for another program.
    """
    hints = get_type_hints(kind)
    try:
        with np.load(io.BytesIO(read_bounded(path, LARGEST)), allow_pickle=False) as arrays:
            values = {name: _value(arrays[name], hints[name]) for name in arrays.files}
        return kind(**values)
    except (OSError, ValueError, KeyError, TypeError, ValidationError, EOFError, BadZipFile) as error:
        raise ConfigError(f"{path.name}: damaged, or of another version: {error!r}") from error


def _value(content: Any, hint: Any) -> Any:
    if content.dtype.kind != "U":
        return content
    return TypeAdapter(hint).validate_json(str(content))
