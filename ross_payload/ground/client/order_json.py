"""Orders from JSON objects, as the page sends them and as the words of a command line become."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import ValidationError

from ross_payload.ground.client.command_types import Order
from ross_payload.ground.client.order_models import MODELS, OrderModel
from ross_payload.ground.schema_errors import first_line, short


def order_of(mapping: Mapping[str, Any]) -> Order:
    """Return the order that a JSON object asks for; what is null or empty is not given, and other fields are not read.

    >>> order_of({"kind": "turn", "heading": 40}), order_of({"kind": "listen"}).words
    (Turn(heading=40.0), 'find the enrolled voice')

    Raises
    ------
    ValueError
        When it asks for none, or with a number that cannot be meant.
    """
    model = model_of(mapping.get("kind"))
    read = {name: mapping[name] for name in model.model_fields if mapping.get(name) not in (None, "")}
    try:
        return model.model_validate(read).order()
    except ValidationError as error:
        raise ValueError(first_line(error, model)) from error


def model_of(kind: Any) -> type[OrderModel]:
    """Return the model of a kind of orders.

    Raises
    ------
    ValueError
        When there is no such kind.
    """
    if not isinstance(kind, str) or kind not in MODELS:
        raise ValueError(f"kind: expected one of {', '.join(MODELS)}, got {'nothing' if kind is None else short(kind)}")
    return MODELS[kind]
