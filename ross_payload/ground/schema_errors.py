"""What is wrong with values that do not fit a model: where, what was expected, and what was got, each in one line."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from ross_payload.errors import near

SHOWN = 40  # characters of a value
Schema = Mapping[str, Any]
TYPES = {
    "boolean": "true or false", "integer": "a whole number", "number": "a number", "string": "a text",
    "array": "a list", "object": "an object",
}  # fmt: skip


def explained(error: ValidationError, model: type[BaseModel]) -> list[tuple[str, str]]:
    """Return of every error where it is, as ``a.0.b``, and what is wrong; a misspelt name before others.

    >>> from typing import Annotated
    >>> from pydantic import Field
    >>> class Turn(BaseModel):
    ...     heading: Annotated[float, Field(ge=-360, le=360)]
    >>> try:
    ...     Turn(heading=400)
    ... except ValidationError as error:
    ...     explained(error, Turn)
    [('heading', 'expected -360 to 360, got 400')]
    """
    whole = model.model_json_schema()
    errors = sorted(error.errors(), key=lambda each: each["type"] != "extra_forbidden")
    return [_told(each, whole) for each in errors]


def first_line(error: ValidationError, model: type[BaseModel]) -> str:
    """Return the first of them in one line."""
    (where, what), *_ = explained(error, model)
    return f"{where}: {what}" if where else what


def expected(schema: Schema) -> str:
    """Return what a schema accepts, in words.

    >>> expected({"type": "integer", "minimum": 0, "maximum": 255}), expected({"enum": ["opus", "L16"]})
    ('0 to 255', 'one of opus, L16')
    """
    if "const" in schema:
        return json.dumps(schema["const"])
    if "enum" in schema:
        return f"one of {', '.join(map(str, schema['enum']))}"
    least, most = schema.get("minimum"), schema.get("maximum")
    if least is not None and most is not None:
        return f"{least:g} to {most:g}"
    if "minItems" in schema and "maxItems" in schema:
        return f"a list of {schema['minItems']} to {schema['maxItems']} values"
    words = TYPES.get(schema.get("type", ""), "another value")
    return f"{words} such as {schema['examples'][0]}" if "examples" in schema else words


def short(value: Any) -> str:
    """Return a value as it stands in a message."""
    if value is None:
        return "null"
    text = "NaN" if value != value else repr(value)  # noqa: PLR0124 - NaN is not itself
    return text if len(text) <= SHOWN else f"{text[:SHOWN]}..."


def _told(error: ErrorDetails, whole: Schema) -> tuple[str, str]:
    """Return where an error is, and what is wrong; of several models, the one that a field names is meant."""
    path, kinds = list(error["loc"]), whole.get("discriminator", {})
    chosen: Schema = {"$ref": kinds["mapping"][path.pop(0)]} if kinds and path else whole
    if error["type"] in ("union_tag_invalid", "union_tag_not_found"):
        name = kinds["propertyName"]
        got = short(error["input"][name]) if name in error["input"] else "nothing"
        return name, f"expected one of {', '.join(kinds['mapping'])}, got {got}"
    if kinds and not path:
        chosen = {"type": "object"}
    return ".".join(map(str, path)), _wrong(error, path, chosen, whole)


def _wrong(error: ErrorDetails, path: Sequence[int | str], schema: Schema, whole: Schema) -> str:
    kind, value = error["type"], error["input"]
    if kind == "value_error":
        return error["msg"].removeprefix("Value error, ")
    if kind == "extra_forbidden":
        names = _place(schema, path[:-1], whole).get("properties", {})
        return f"unknown field{near(str(path[-1]), names)}"
    place = _place(schema, path, whole)
    broken = place.get("type") == "integer" and isinstance(value, float) and value % 1 > 0
    wanted = "a whole number" if broken else expected(place)
    return f"expected {wanted}, got {'nothing' if kind == 'missing' else short(value)}"


def _place(schema: Schema, path: Sequence[int | str], whole: Schema) -> Schema:
    """Return the part of a schema that is about a place in the values; empty: it says nothing of it."""
    found = _resolved(schema, whole)
    for part in path:
        inner = found.get("items", {}) if isinstance(part, int) else found.get("properties", {}).get(part, {})
        found = _resolved(inner, whole)
    return found


def _resolved(part: Schema, whole: Schema) -> Schema:
    """Follow references, and what may also be null."""
    while "$ref" in part or len(_options(part)) == 1:
        part = whole["$defs"][part["$ref"].rpartition("/")[2]] if "$ref" in part else _options(part)[0]
    return part


def _options(part: Schema) -> list[Schema]:
    return [each for each in part.get("anyOf", ()) if each.get("type") != "null"]
