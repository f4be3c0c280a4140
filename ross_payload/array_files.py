"""Arrays by name as the bytes of a file: npz, without pickle."""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ross_payload.errors import ConfigError


def encode_arrays(arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Write arrays of numbers; the same arrays give the same bytes."""
    buffer = io.BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, **dict(arrays))
    return buffer.getvalue()


def decode_arrays(content: bytes, name: str, expected: str) -> dict[str, NDArray[Any]]:
    """Read what `encode_arrays` wrote; ``name`` and what was ``expected`` there are for the error.

    Raises
    ------
    ConfigError
        When it is damaged or something else.
    """
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as arrays:
            return {key: arrays[key] for key in arrays.files}
    except Exception as error:  # zipfile, zlib and numpy each have their own way to fail on damaged bytes
        raise ConfigError(f"{name}: expected {expected}, got something else") from error
