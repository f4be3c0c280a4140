"""Writes docs/reference/rest.md from the description that the page serves; a test compares both.

Run it in a checkout: ``python docs/rest.py``.
"""

import json
from pathlib import Path

from ross_payload.ground.web.rest.event_stream import KINDS
from ross_payload.ground.web.rest.openapi import document
from ross_payload.ground.web.rest.problems import CODES, OF_ERRORS
from ross_payload.ground.web.rest.routes import GROUPS

PAGE = Path(__file__).parent / "reference" / "rest.md"
HEAD = """\
# REST interface

<!-- made by: python docs/rest.py -->

{about}
All paths are below `/api/v1`, on the address of the page; `{{payload}}` are the MAVLink ids of a system and its
component, as `1-191`. The description itself (OpenAPI 3.1) is at `/api/v1/openapi.json`.
[Use the REST interface](../how-to/use-the-rest-interface.md) has examples, and the rules of control and token.
"""
PROBLEMS = """\
## Problems

`application/problem+json`, a [Problem](#problem). Every request can be answered with 400, 401, 403, 421, 422,
429 or 500.

| status | `code` |
| --- | --- |"""
SCHEMAS = """\
## Schemas

In answers every field is there, null where the payload did not tell it. In a request a field with *may be left out* may
be; a null or a field that is not listed is an error.
"""


def text(words):
    """Words in a cell of a table."""
    return " ".join(words.split()).replace("|", "\\|").replace("<", "&lt;")


def link(reference):
    """A reference to a schema as a link."""
    name = reference.rpartition("/")[2]
    return f"[{name}](#{name.lower()})"


def kind(schema):
    """The type of a value."""
    if "$ref" in schema:
        return link(schema["$ref"])
    if options := schema.get("anyOf") or schema.get("oneOf"):
        return " or ".join(kind(each) for each in options)
    if "const" in schema or "enum" in schema:
        return ", ".join(f"`{json.dumps(each)}`" for each in schema.get("enum", [schema.get("const")])).replace('"', "")
    if schema.get("type") == "array":
        return f"array of {kind(schema['items'])}" if "items" in schema else "pair of numbers"
    if isinstance(inner := schema.get("additionalProperties"), dict):
        return f"object of {kind(inner)}"
    least, most = schema.get("minimum"), schema.get("maximum")
    span = f", {number(least)} to {number(most)}" if least is not None and most is not None else ""
    return schema.get("type", "any") + span


def number(value):
    """A bound: exact where that is shorter."""
    return str(value) if isinstance(value, int) else f"{value:g}"


def described(schema):
    """What a value means: its own words, or those of one that may also be null."""
    options = schema.get("anyOf", ())
    return schema.get("description") or next((each["description"] for each in options if "description" in each), "")


def operation(method, path, told):
    """One operation."""
    lines = [f"### `{method.upper()} {path}`\n", f"{told['summary']} (`{told['operationId']}`)\n"]
    lines += [f"{' '.join(part.split())}\n" for part in told.get("description", "").split("\n\n") if part]
    if parameters := [each for each in told.get("parameters", ()) if each["name"] != "payload"]:
        lines += ["| parameter | in | type | means |\n| --- | --- | --- | --- |"]
        lines += [parameter(each) for each in parameters] + [""]
    if body := told.get("requestBody"):
        ((media, content),) = body["content"].items()
        lines.append(f"Body: `{media}`, {kind(content['schema'])}\n")
    (status, good), *others = told["responses"].items()
    answer = "; ".join(f"`{media}`, {kind(content['schema'])}" for media, content in good.get("content", {}).items())
    own = [each for each, _ in others if int(each) not in (400, 401, 403, 421, 422, 429, 500)]
    lines.append(f"Answer: {status}{', ' * bool(answer)}{answer}{'. Also ' * bool(own)}{', '.join(own)}\n")
    return lines


def parameter(told):
    """A row of a parameter."""
    schema, words = told["schema"], text(told["description"])
    default = f" (default {schema['default']:g})" if "default" in schema else ""
    example = f", as `{schema['examples'][0]}`" if "examples" in schema else ""
    return f"| `{told['name']}` | {told['in']} | {kind(schema)} | {words}{example}{default} |"


def schema_of(name, schema):
    """One schema."""
    lines = [f"### {name}\n", f"{text(schema.get('description', ''))}\n"]
    if options := schema.get("oneOf"):
        return [*lines, f"One of {', '.join(link(each['$ref']) for each in options)}\n"]
    if not schema.get("properties"):
        return lines
    lines.append("| field | type | means |\n| --- | --- | --- |")
    for field, about in schema["properties"].items():
        left = "" if field in schema.get("required", ()) else "*may be left out* "
        lines.append(f"| `{field}` | {kind(about)} | {(left + text(described(about))).strip()} |")
    return [*lines, ""]


def problems():
    """The codes of problems by their statuses."""
    codes = {}
    for status, code in [*CODES.items(), *((status, code) for _, status, code in OF_ERRORS)]:
        codes.setdefault(status, []).append(f"`{code}`")
    return [PROBLEMS, *(f"| {status} | {', '.join(sorted(set(codes[status])))} |" for status in sorted(codes)), ""]


def tables():
    """The page as Markdown."""
    told = document(GROUPS, KINDS)
    lines = [HEAD.format(about=told["info"]["description"])]
    for tag in told["tags"]:
        lines.append(f"## Operations: {tag['name'].lower()}\n")
        for path, methods in told["paths"].items():
            for method, each in methods.items():
                lines += operation(method, path, each) if tag["name"] in each["tags"] else []
    lines += [*problems(), SCHEMAS]
    for name, schema in told["components"]["schemas"].items():
        lines += schema_of(name, schema)
    return "\n".join(lines)


if __name__ == "__main__":
    PAGE.write_text(tables(), encoding="utf-8")
