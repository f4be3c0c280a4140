"""One operation: what a program may ask for at a path, read from the types of the function that answers it."""

from __future__ import annotations

import asyncio
import inspect
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass
from functools import cache
from http import HTTPStatus
from typing import Any, get_type_hints

from aiohttp import web
from pydantic import BaseModel, ConfigDict, ValidationError
from pydantic_core import from_json

from ross_payload.ground.schema_errors import explained
from ross_payload.ground.web.connections import HEADER_TIMEOUT
from ross_payload.ground.web.operator import Operator
from ross_payload.ground.web.rest.problems import Place, Refusal, WrongValue
from ross_payload.ground.web.rest.programs import Programs
from ross_payload.ground.web.security import PRIVATE, shown
from ross_payload.ground.web.websocket_sessions import WebSocketSessions

JSON = "application/json"

Handle = Callable[..., Awaitable[Any]]


class Parameters(BaseModel):
    """The root of what stands in a path or behind its question mark; what is not listed is an error."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Nothing(Parameters):
    """No parameters."""


@dataclass(frozen=True, slots=True)
class Call:
    """What an operation is asked with."""

    request: web.Request
    operator: Operator
    browsers: WebSocketSessions
    programs: Programs

    @property
    def abandoned(self) -> bool:
        """Whether the program has gone that asks: nobody waits for the answer."""
        return self.request.transport is None


@dataclass(frozen=True, slots=True)
class Operation:
    """An entry of the interface.

    Parameters
    ----------
    handle
        Answers: it takes a `Call` and, where it has parameters of these names, ``where`` (the path), ``query`` and
        ``body``, each a model; it returns a model, None, or a response of its own.
    status
        Of a good answer.
    media
        Type of a good answer that is no model.
    takes
        Type of a body that is no model.
    problems
        Statuses of what may go wrong, besides what may with every operation.
    named
        Control depends on who asks.
    always
        Neither the query nor the body is looked at: nothing in them may prevent it.
    """

    method: str
    path: str
    handle: Handle
    status: int = 200
    media: str = JSON
    takes: str = ""
    problems: tuple[int, ...] = ()
    named: bool = False
    always: bool = False

    @property
    def name(self) -> str:
        """What clients call it."""
        return self.handle.__name__

    @property
    def words(self) -> str:
        """What it does, and more about it, as the function says."""
        return inspect.getdoc(self.handle) or ""

    @property
    def located(self) -> bool:
        """Whether it makes something that has an address of its own."""
        answer = self.model("return")
        return self.status == HTTPStatus.ACCEPTED and answer is not None and "url" in answer.model_fields

    def model(self, part: str) -> Any:
        """Return the model of ``where``, ``query``, ``body`` or of the answer (``return``); None: there is none."""
        found = _types(self.handle).get(part)
        return found if isinstance(found, type) and issubclass(found, BaseModel) else None

    async def answer(self, call: Call) -> web.StreamResponse:
        """Check what is asked, do it, and answer.

        Raises
        ------
        Refusal
            When something in it cannot be meant.
        """
        given: dict[str, Any] = {}
        if (where := self.model("where")) is not None:
            given["where"] = _checked(where, dict(call.request.match_info), "path")
        if not self.always:
            query = self.model("query")
            checked = _checked(query or Nothing, _single(call.request.query), "query")
            given |= {"query": checked} if query is not None else {}
        if (body := self.model("body")) is not None:
            given["body"] = _checked(body, await _json(call.request), "body")
        return self._response(await self.handle(call, **given))

    def _response(self, answered: Any) -> web.StreamResponse:
        if isinstance(answered, web.StreamResponse):
            return answered
        if answered is None:
            return web.Response(status=self.status)
        headers = {**PRIVATE, **({"Location": answered.url} if self.located else {})}
        return web.Response(
            body=answered.model_dump_json(by_alias=True), status=self.status, content_type=JSON, headers=headers
        )


@cache
def _types(handle: Handle) -> dict[str, Any]:
    return get_type_hints(handle)


def _checked(model: type[BaseModel], values: Any, place: Place) -> BaseModel:
    try:
        return model.model_validate(values)
    except ValidationError as error:
        errors = [WrongValue(place=place, name=name, detail=detail) for name, detail in explained(error, model)]
        first = errors[0]
        what = f"{first.name}: {first.detail}" if first.name else f"{place}: {first.detail}"
        raise Refusal(422, what, errors=errors) from error


def _single(query: Mapping[str, str]) -> dict[str, str]:
    """Return the query, in which every name stands once."""
    names = [name for name, _ in query.items()]  # one for each value
    if len(names) != len(set(names)):
        twice = next(name for name in names if names.count(name) > 1)
        raise Refusal(422, f"{shown(twice)}: expected one value, got {names.count(twice)}")
    return dict(query)


async def _json(request: web.Request) -> Any:
    """Read the body as JSON.

    Raises
    ------
    Refusal
        When it is none, or does not come.
    """
    charset = (request.charset or "utf-8").lower()
    if request.content_type != JSON or charset not in ("utf-8", "us-ascii"):
        got = shown(request.headers.get("Content-Type", "none"))
        raise Refusal(415, f"Content-Type: expected {JSON} in UTF-8, got {got}")
    try:
        async with asyncio.timeout(HEADER_TIMEOUT):
            body = await request.read()
    except TimeoutError as error:
        raise Refusal(408, f"body: expected it within {HEADER_TIMEOUT:.0f} s") from error
    try:
        return from_json(body, allow_inf_nan=False)
    except ValueError as error:
        raise Refusal(400, f"body: expected JSON, got {shown(str(error))}") from error
