"""What every table of the configuration is made of, and how a file is read and checked."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from ross_payload.bounded_files import parsed_toml, read_bounded
from ross_payload.errors import ConfigError

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Degrees = Annotated[float, Field(allow_inf_nan=False)]
Model = TypeVar("Model", bound=BaseModel)


class Table(BaseModel):
    """A table of the file: frozen, and an unknown key is an error."""

    model_config = ConfigDict(frozen=True, extra="forbid")


def read_toml(path: Path) -> dict[str, Any]:
    """Read a TOML file.

    Raises
    ------
    ConfigError
        When the file is missing, unreadable, larger than 1 MB or not TOML.
    """
    try:
        return parsed_toml(read_bounded(path))
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise ConfigError(f"{path}: not TOML: {error}") from error


def validated(model: type[Model], values: Any, where: str) -> Model:
    """Check values against a model.

    Raises
    ------
    ConfigError
        With one line that names the first wrong key, what was found and what was wanted.
    """
    try:
        return model.model_validate(values)
    except ValidationError as error:
        raise ConfigError(f"{where}: {_explain(error)}") from error


def _explain(error: ValidationError) -> str:
    first, others = error.errors()[0], error.error_count() - 1
    key = ".".join(str(part) for part in first["loc"])
    if first["type"] == "extra_forbidden":
        text = f"unknown key '{key}'"
    else:
        text = f"{key}: " * bool(key) + first["msg"].removeprefix("Value error, ")
        if not isinstance(first["input"], dict):
            text += f" (found {first['input']!r})"
    return text + (f"; and {others} more" if others else "")
