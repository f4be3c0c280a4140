"""A payload's parameters for programs: asked for when somebody first does, and set until they are read back."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ConfigDict, Field

from ross_payload.ground.client.param_client import ParamClient
from ross_payload.ground.client.parameters import Parameters, unknown
from ross_payload.ground.errors import LinkLost
from ross_payload.ground.web.rest import page_answers
from ross_payload.ground.web.rest.operation import Call
from ross_payload.ground.web.rest.places import OfParameter, OfPayload, WaitForList
from ross_payload.json_values import finite
from ross_protocols.mavlink.field_converters import FLOAT32_MAX

LIST_TIMEOUT_S = 10.0  # for the list to arrive, before one of it is set


class Value(BaseModel):
    """A value of a parameter, as a 32-bit float can hold it; its own bounds are the payload's to judge."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)
    value: float = Field(ge=-FLOAT32_MAX, le=FLOAT32_MAX)


async def get_parameters(call: Call, where: OfPayload, query: WaitForList) -> page_answers.ParameterList:
    """All parameters of a payload, as far as they have arrived; the first one who asks makes the page ask for them."""
    settings = call.operator.settings(where.who)
    await _arrived(call, settings, query.wait)
    rows = [page_answers.Parameter.model_validate(finite(row)) for row in settings.rows()]
    return page_answers.ParameterList(complete=_is_complete(settings), notes=settings.notes(), parameters=rows)


async def refresh_parameters(call: Call, where: OfPayload, query: WaitForList) -> page_answers.ParameterList:
    """Forget all parameters of a payload and ask for them again."""
    call.operator.settings(where.who).refresh()
    call.operator.state.tick()
    return await get_parameters(call, where, query)


async def get_parameter(call: Call, where: OfParameter, query: WaitForList) -> page_answers.Parameter:
    """One parameter, with what the payload says about it."""
    settings = call.operator.settings(where.who)
    await _arrived(call, settings, query.wait)
    return _row(settings, where.name)


async def set_parameter(call: Call, where: OfParameter, body: Value) -> page_answers.Parameter:
    """Set a parameter, and answer when it was read back; takes control if it is free.

    A value that the payload refuses is a problem (409, refused) with the payload's reason; then it keeps its value. One
    that is not answered is another (504): it may have been set nevertheless.
    """
    settings = call.operator.settings(where.who)
    call.operator.check_control()
    if where.name not in settings.values:
        await _arrived(call, settings, LIST_TIMEOUT_S)
    _row(settings, where.name)
    call.operator.hold()
    await Parameters(settings, call.operator.state.changed).set(where.name, body.value)
    return _row(settings, where.name)


async def _arrived(call: Call, settings: ParamClient, wait: float) -> None:
    """Wait for the list and its descriptions, no longer than so long [s]."""
    call.operator.state.tick()  # asks for it
    if wait > 0:
        await call.operator.state.changed.within(wait, lambda: call.abandoned or _is_complete(settings))


def _is_complete(settings: ParamClient) -> bool:
    return settings.complete and settings.described


def _row(settings: ParamClient, name: str) -> page_answers.Parameter:
    """Return a row.

    Raises
    ------
    UnknownParameter
        When the payload has none of that name.
    LinkLost
        When nobody knows, since the list has not arrived.
    """
    found: dict[str, Any] | None = next((row for row in settings.rows() if row["name"] == name), None)
    if found is not None:
        return page_answers.Parameter.model_validate(finite(found))
    if settings.complete:
        raise unknown(settings, name)
    raise LinkLost("the list of parameters", f"{len(settings.values)} have arrived so far")
