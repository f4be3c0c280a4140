"""What every table of the configuration is made of, and how a file is read and checked."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin

from pydantic import BaseModel, ConfigDict, Field, ValidationError, ValidationInfo, field_validator
from pydantic_core import ErrorDetails

from ross_payload.bounded_files import parsed_toml, read_bounded
from ross_payload.errors import ConfigError, near, shown

LARGEST = 1e9  # of a quantity that has no other bound
Positive = Annotated[float, Field(gt=0, le=LARGEST)]
Degrees = Annotated[float, Field(ge=-36_000, le=36_000)]  # a hundred turns
Model = TypeVar("Model", bound=BaseModel)
KIND = re.compile(r".*\[.*|(constrained-)?(bool|float|int|str)")  # among several, in pydantic's path to a value
BEGINNINGS = {"be": "expected ", "have": "expected "}
WORDS = {
    "greater": "a number greater",
    "less": "a number less",
    "a valid dictionary": "a table",
    "a valid tuple": "a list",
}
FORMS = {
    r"^[A-Za-z][\w.-]*:.+": "device:NAME, file:PATH, tcp:HOST:PORT or NAME:ADDRESS of a plug-in",
    "^(can:.+)?$": "can:INTERFACE:CHANNEL[:BITRATE]",
    "^can:": "can:INTERFACE:CHANNEL[:BITRATE]",
    "^serial:": "serial:DEVICE:BAUD",
}  # of texts in a configuration, by their patterns


class Table(BaseModel):
    """A table of the file: frozen, and an unknown key is an error."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    @field_validator("*", mode="before")
    @classmethod
    def _no_switch_for_a_number(cls, value: Any, info: ValidationInfo) -> Any:
        """Refuse true and false where a number is expected: they would be 1 and 0, such as a heading that is known."""
        if _holds_switch(value) and _is_number(cls.model_fields[str(info.field_name)].annotation):
            raise ValueError(f"expected {'a number' if isinstance(value, bool) else 'numbers'}, got {_toml(value)}")
        return value


def _holds_switch(value: Any) -> bool:
    """Whether a value is true or false, or a list that has any."""
    return isinstance(value, bool) or (isinstance(value, list | tuple) and any(map(_holds_switch, value)))


def _toml(value: Any) -> str:
    """Return a value, or a list, whose switches stand as in the file."""
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_toml, value))}]"
    return str(value).lower() if isinstance(value, bool) else shown(value)


def _is_number(annotation: Any) -> bool:
    """Whether what a key may have is a number, or a list of them, and not a switch as well."""
    parts = set(_parts(annotation))
    return bool(parts & {int, float}) and bool not in parts


def _parts(annotation: Any) -> Iterator[Any]:
    """The types among which a value, or one in a list, may be."""
    inner = get_args(annotation)
    if get_origin(annotation) is Annotated:
        yield from _parts(inner[0])
    elif get_origin(annotation) in (Union, UnionType, tuple):
        for part in inner:
            yield from _parts(part)
    elif get_origin(annotation) is Literal:
        yield from map(type, inner)
    else:
        yield annotation


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
        With one line that names the first wrong key, an unknown one before others, what was expected and what was got.
    """
    try:
        return model.model_validate(values)
    except ValidationError as error:
        raise ConfigError(f"{where}: {_explain(error, model)}") from error


def _explain(error: ValidationError, model: type[BaseModel]) -> str:
    errors = sorted(error.errors(), key=lambda each: each["type"] != "extra_forbidden")  # a misspelt key first
    first, others = errors[0], len(errors) - 1
    more = f"; and {others} more" if others else ""
    if first["type"] == "extra_forbidden":
        key = ".".join(map(str, first["loc"]))  # its last part is the file's own, whatever it looks like
        return f"unknown key {shown(key)}{near(str(first['loc'][-1]), _keys(model, first['loc'][:-1]))}{more}"
    key = ".".join(str(part) for part in first["loc"] if not KIND.fullmatch(str(part)))
    return f"{key}: " * bool(key) + _wrong(first) + more


def _wrong(error: ErrorDetails) -> str:
    """Say what was expected and what was got; a check of ours has said so itself."""
    text, value = error["msg"], error["input"]
    if error["type"] == "value_error":
        return text.removeprefix("Value error, ")
    if error["type"] == "string_pattern_mismatch":
        return f"expected {FORMS.get(error['ctx']['pattern'], error['ctx']['pattern'])}, got {shown(value)}"
    if isinstance(value, float) and math.isnan(value):
        return "expected a number, got nan"
    if error["type"] == "missing":
        return "expected a value, got none"
    if error["type"] == "int_parsing_size":
        return f"expected a valid integer, got {shown(value)}"
    text = re.sub(r"^\w+ should (be|have) ", lambda found: BEGINNINGS[found[1]], text)
    text = re.sub(r" after validation, not \d+", "", text)
    text = re.sub(r" or instance of \w+", "", text)
    for word, meant in WORDS.items():
        text = text.replace(f"expected {word}", f"expected {meant}")
    meant = (
        near(value, re.findall(r"'([^']+)'", text))
        if error["type"] == "literal_error" and isinstance(value, str)
        else ""
    )
    return f"{text}, got {shown(value)}{meant}"


def _keys(model: Any, path: Sequence[int | str]) -> Iterable[str]:
    """Return the keys that the table at a path may have; none when it is not a table of ours."""
    for part in path:
        fields = getattr(model, "model_fields", {})
        if isinstance(part, str) and part in fields:
            model = next(_tables(fields[part].annotation), None)
    return getattr(model, "model_fields", {})


def _tables(annotation: Any) -> Iterator[Any]:
    if hasattr(annotation, "model_fields"):
        yield annotation
    for part in get_args(annotation):
        yield from _tables(part)
