"""The interface described by OpenAPI 3.1, made from the operations and their models."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from http import HTTPStatus
from typing import Any

from pydantic import BaseModel, TypeAdapter
from pydantic.json_schema import GenerateJsonSchema

from ross_payload import __version__
from ross_payload.ground.web.rest.operation import JSON, Operation
from ross_payload.ground.web.rest.problems import CODES, MEDIA, Problem, phrase
from ross_payload.ground.web.rest.programs import ANYBODY, HEADER, NAME_PATTERN

Groups = Mapping[str, Sequence[Operation]]
Json = dict[str, Any]

REFERENCE = "#/components/schemas/{model}"
EVERYWHERE = (400, 401, 403, 421, 422, 429, 500)  # what may go wrong with every operation
OF_BODIES = (408, 413, 415)
ABOUT = """\
Other programs read here what the page of `ross ground` shows, and give the orders that its buttons give. Payloads are
those that are received over MAVLink; angles are degrees, clockwise, and times seconds on the clock of the ground
process.

An order is treated like one from the page: only the program or browser in control may order, everyone may stop, and a
refusal has the payload's own words. A request that cannot be carried out is answered with a problem (RFC 9457).
"""
TOKEN_ABOUT = "The token of the page, where it needs one; the cookie of the page will do, too."  # noqa: S105


class _Plain(GenerateJsonSchema):
    """Schemas without a title for every field: that is its name once more."""

    def field_title_should_be_set(self, schema: Any) -> bool:
        """Return that none should be."""
        return False


def document(groups: Groups, events: Sequence[type] = (), *, token: bool = True) -> Json:
    """Return the description of some groups of operations; ``token``: one is needed.

    ``events`` are types whose schemas are described, too.
    """
    operations = [each for group in groups.values() for each in group]
    models: list[tuple[type, Any]] = [(each, "serialization") for each in (Problem, *events)]
    models += [(model, "serialization") for each in operations if (model := each.model("return"))]
    models += [(model, "validation") for each in operations if (model := each.model("body"))]
    references, schemas = _schemas(models)
    paths: Json = {}
    for tag, group in groups.items():
        for each in group:
            paths.setdefault(each.path, {})[each.method.lower()] = _operation(each, tag, references)
    return {
        "openapi": "3.1.0",
        "info": {"title": "ross ground", "version": __version__, "description": ABOUT},
        "servers": [{"url": "/api/v1"}],
        "security": [{"token": []}] if token else [{}],
        "tags": [{"name": name} for name in groups],
        "paths": paths,
        "components": {"schemas": schemas, "responses": _problems(), "securitySchemes": _security()},
    }


def _schemas(models: Sequence[tuple[type, Any]]) -> tuple[dict[type, Json], Json]:
    """Return the reference of every model, and the schemas by their names."""
    inputs: Any = [(model, mode, TypeAdapter(model)) for model, mode in dict(models).items()]
    found, whole = TypeAdapter.json_schemas(inputs, ref_template=REFERENCE, schema_generator=_Plain)
    return {model: schema for (model, _), schema in found.items()}, dict(sorted(whole["$defs"].items()))


def _operation(operation: Operation, tag: str, references: Mapping[type, Json]) -> Json:
    summary, _, more = operation.words.partition("\n\n")
    described: Json = {"operationId": operation.name, "tags": [tag], "summary": summary}
    if more:
        described["description"] = more
    if parameters := [*_parameters(operation)]:
        described["parameters"] = parameters
    if body := _body(operation, references):
        described["requestBody"] = body
    statuses = sorted({*EVERYWHERE, *operation.problems, *(OF_BODIES if operation.model("body") else ())})
    problems = {str(each): {"$ref": f"#/components/responses/{_name(each)}"} for each in statuses}
    return described | {"responses": {str(operation.status): _good(operation, references), **problems}}


def _good(operation: Operation, references: Mapping[type, Json]) -> Json:
    answer = operation.model("return")
    if answer is not None:
        good: Json = {"description": answer.__doc__, "content": {JSON: {"schema": references[answer]}}}
        if operation.located:
            good["headers"] = {"Location": {"description": "where to ask again", "schema": {"type": "string"}}}
        return good
    if operation.status == HTTPStatus.NO_CONTENT:
        return {"description": "It is done."}
    kind = {"type": "string"} if operation.media.startswith("text/") else {"type": "string", "format": "binary"}
    return {"description": operation.words.partition("\n\n")[0], "content": {operation.media: {"schema": kind}}}


def _body(operation: Operation, references: Mapping[type, Json]) -> Json:
    if (model := operation.model("body")) is not None:
        return {"required": True, "content": {JSON: {"schema": references[model]}}}
    if operation.takes:
        return {"required": True, "content": {operation.takes: {"schema": {"type": "string", "format": "binary"}}}}
    return {}


def _parameters(operation: Operation) -> Iterator[Json]:
    for part, place in (("where", "path"), ("query", "query")):
        model = operation.model(part)
        if model is not None:
            yield from _of_model(model, place)
    if operation.named:
        words = f"what the program calls itself, for control; without: {ANYBODY}"
        schema = {"type": "string", "pattern": NAME_PATTERN}
        yield {"name": HEADER, "in": "header", "required": False, "description": words, "schema": schema}


def _of_model(model: type[BaseModel], place: str) -> Iterator[Json]:
    whole = model.model_json_schema(schema_generator=_Plain)
    for name, schema in whole["properties"].items():
        required = name in whole.get("required", ())
        words = schema.pop("description", "")
        yield {"name": name, "in": place, "required": required, "description": words, "schema": schema}


def _problems() -> Json:
    content = {MEDIA: {"schema": {"$ref": REFERENCE.format(model="Problem")}}}
    return {_name(each): {"description": phrase(each), "content": content} for each in CODES}


def _name(status: int) -> str:
    """Return the name of the answer to a problem.

    >>> _name(404)
    'NotFound'
    """
    return phrase(status).title().replace(" ", "").replace("-", "")


def _security() -> Json:
    return {"token": {"type": "http", "scheme": "bearer", "description": TOKEN_ABOUT}}
