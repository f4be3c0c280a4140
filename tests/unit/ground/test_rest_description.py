"""What the OpenAPI document says: it is whole, it is what is served, and what programs rely on stays."""

import json
from pathlib import Path

import pytest

from ross_payload.ground.client.order_models import MODELS
from ross_payload.ground.web.rest.event_stream import KINDS
from ross_payload.ground.web.rest.openapi import document
from ross_payload.ground.web.rest.problems import CODES, OF_ERRORS
from ross_payload.ground.web.rest.routes import GROUPS, OPERATIONS

RELIED_ON = Path(__file__).parents[2] / "data" / "rest-0.1.0.json"
DOCUMENT = document(GROUPS, KINDS)
SCHEMAS = DOCUMENT["components"]["schemas"]
REQUESTS = {"Value", *(model.__name__ for model in MODELS.values())}


def operations():
    return {
        f"{method.upper()} {path}": told
        for path, told_of in DOCUMENT["paths"].items()
        for method, told in told_of.items()
    }


def kind(schema):
    """The type of a field, and what it refers to, without what may be said about it."""
    if "$ref" in schema:
        return schema["$ref"].rpartition("/")[2]
    if "anyOf" in schema:
        return " or ".join(sorted(map(kind, schema["anyOf"])))
    if "items" in schema:
        return f"array of {kind(schema['items'])}"
    return str(schema.get("const", schema.get("enum", schema.get("type", "any"))))


def interface():
    """What programs rely on: names and types."""
    fields = {
        name: {field: kind(about) for field, about in schema["properties"].items()}
        for name, schema in SCHEMAS.items() if "properties" in schema
    }  # fmt: skip
    return {
        "operations": {path: told["operationId"] for path, told in operations().items()},
        "fields": fields,
        "required": {name: sorted(SCHEMAS[name].get("required", ())) for name in sorted(REQUESTS)},
        "kinds": sorted(MODELS),
        "codes": sorted({*CODES.values(), *(code for _, _, code in OF_ERRORS)}),
    }


def test_nothing_that_programs_rely_on_is_taken_away():
    """What is new is added to the file: ``python -c`` with `interface` of this module and `json.dump`."""
    before, now = json.loads(RELIED_ON.read_text(encoding="utf-8")), interface()
    assert before["operations"].items() <= now["operations"].items()
    for name, fields in before["fields"].items():
        assert fields.items() <= now["fields"][name].items(), name
    assert now["required"].items() >= before["required"].items(), "a request needs more than before"
    assert set(before["kinds"]) <= set(now["kinds"])
    assert set(before["codes"]) <= set(now["codes"])


def test_every_operation_says_what_it_does_under_a_name_of_its_own():
    names = [told["operationId"] for told in operations().values()]
    assert len(names) == len(set(names)) == len(OPERATIONS)
    assert all(told["summary"].endswith(".") for told in operations().values())


def test_every_order_that_there_is_can_be_given():
    body = operations()["POST /payloads/{payload}/orders"]["requestBody"]["content"]["application/json"]["schema"]
    given = SCHEMAS[body["$ref"].rpartition("/")[2]]
    assert set(given["discriminator"]["mapping"]) == set(MODELS)


@pytest.mark.parametrize("name", sorted(SCHEMAS))
def test_every_reference_leads_somewhere_and_every_schema_says_what_it_is(name):
    assert SCHEMAS[name].get("description"), name
    for line in json.dumps(SCHEMAS[name]).split('"$ref": "')[1:]:
        assert line.partition('"')[0].removeprefix("#/components/schemas/") in SCHEMAS


@pytest.mark.parametrize("name", sorted(SCHEMAS.keys() - REQUESTS))
def test_every_field_of_an_answer_is_always_there(name):
    assert set(SCHEMAS[name].get("required", ())) == SCHEMAS[name].get("properties", {}).keys()


def test_every_problem_of_an_operation_has_a_code():
    statuses = {int(status) for told in operations().values() for status in told["responses"]}
    assert {status for status in statuses if status >= 400} <= CODES.keys()


def test_a_page_without_a_token_asks_for_none():
    assert document(GROUPS, KINDS, token=False)["security"] == [{}]
    assert DOCUMENT["security"] == [{"token": []}]
