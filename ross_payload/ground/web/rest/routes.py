"""The table of the interface, and how it is served beside the page."""

from __future__ import annotations

import json
from collections.abc import Awaitable, Callable
from functools import cache

from aiohttp import web

from ross_payload.ground.web.rest import (
    event_stream,
    file_handlers,
    order_handlers,
    parameter_handlers,
    payload_handlers,
)
from ross_payload.ground.web.rest.openapi import document
from ross_payload.ground.web.rest.operation import JSON, Call, Operation
from ross_payload.ground.web.rest.order_handlers import BASE
from ross_payload.ground.web.rest.programs import Programs
from ross_payload.ground.web.websocket_sessions import WebSocketSessions

OF_PAYLOAD = "/payloads/{payload}"
ORDER, PARAMETER = f"{OF_PAYLOAD}/orders/{{number}}", f"{OF_PAYLOAD}/parameters/{{name}}"
RECORDING = "/recordings/{name}"
OF_PARTS = (404, 412, 416)  # of a file that may be asked for in parts
OPENAPI = f"{BASE}/openapi.json"

STATE = (
    Operation("GET", "/station", payload_handlers.get_station),
    Operation("GET", "/payloads", payload_handlers.get_payloads),
    Operation("GET", OF_PAYLOAD, payload_handlers.get_payload, problems=(404,)),
    Operation("GET", f"{OF_PAYLOAD}/sources", payload_handlers.get_sources, problems=(404,)),
    Operation("GET", f"{OF_PAYLOAD}/streams", payload_handlers.get_streams, problems=(404,)),
    Operation("GET", f"{OF_PAYLOAD}/plan", payload_handlers.get_plan, problems=(404,)),
    Operation("GET", f"{OF_PAYLOAD}/exploration", payload_handlers.get_exploration, problems=(404,)),
    Operation("GET", f"{OF_PAYLOAD}/separation", payload_handlers.get_separation, problems=(404,)),
    Operation("GET", f"{OF_PAYLOAD}/history", payload_handlers.get_history, problems=(404,)),
    Operation("GET", f"{OF_PAYLOAD}/texts", payload_handlers.get_texts, problems=(404,)),
    Operation(
        "GET",
        f"{OF_PAYLOAD}/events",
        event_stream.get_events,
        media=event_stream.MEDIA,
        problems=(404, 503),
        named=True,
    ),
)
ORDERS = (
    Operation("POST", "/stop", order_handlers.stop_all, 202, problems=(404, 409), always=True),
    Operation("POST", f"{OF_PAYLOAD}/stop", order_handlers.stop_payload, 202, problems=(409,), always=True),
    Operation("GET", f"{OF_PAYLOAD}/orders", order_handlers.get_orders, problems=(404,)),
    Operation("POST", f"{OF_PAYLOAD}/orders", order_handlers.give_order, 202, problems=(404, 409, 504), named=True),
    Operation("GET", ORDER, order_handlers.get_order, problems=(404, 504), named=True),
    Operation("POST", f"{ORDER}/cancel", order_handlers.cancel_order, 202, problems=(404, 409, 504), named=True),
    Operation("GET", "/control", order_handlers.get_control, named=True),
    Operation("PUT", "/control", order_handlers.take_control, named=True),
    Operation("DELETE", "/control", order_handlers.give_up_control, named=True),
)
PARAMETERS = (
    Operation("GET", f"{OF_PAYLOAD}/parameters", parameter_handlers.get_parameters, problems=(404, 409, 504)),
    Operation("POST", f"{OF_PAYLOAD}/refresh", parameter_handlers.refresh_parameters, problems=(404, 409, 504)),
    Operation("GET", PARAMETER, parameter_handlers.get_parameter, problems=(404, 409, 504)),
    Operation("PUT", PARAMETER, parameter_handlers.set_parameter, problems=(404, 409, 504), named=True),
)
FILES = (
    Operation("GET", "/flights", file_handlers.get_flights),
    Operation(
        "POST", "/flights", file_handlers.add_flight, 201, takes=file_handlers.OCTETS, problems=(408, 413, 415, 507)
    ),
    Operation(
        "GET",
        "/flights/{name}/sound/{track}",
        file_handlers.get_flight_sound,
        media=file_handlers.OCTETS,
        problems=OF_PARTS,
    ),
    Operation("GET", "/recordings", file_handlers.get_recordings),
    Operation("GET", RECORDING, file_handlers.get_recording, problems=(404,)),
    Operation("DELETE", RECORDING, file_handlers.delete_recording, 204, problems=(404, 409)),
    Operation(
        "GET", f"{RECORDING}/archive", file_handlers.get_recording_archive, media=file_handlers.OCTETS, problems=(404,)
    ),
    Operation(
        "GET",
        f"{RECORDING}/files/{{file}}",
        file_handlers.get_recording_file,
        media=file_handlers.OCTETS,
        problems=OF_PARTS,
    ),
)
OPERATIONS = (*STATE, *ORDERS, *PARAMETERS, *FILES)
GROUPS = {"State": STATE, "Orders": ORDERS, "Parameters": PARAMETERS, "Files": FILES}


def add_routes(app: web.Application, browsers: WebSocketSessions, *, token: bool) -> None:
    """Serve the interface with an application; ``token``: one is needed."""
    programs = Programs(browsers.state)

    async def description(request: web.Request) -> web.Response:
        return web.Response(body=_description(token), content_type=JSON)

    app.router.add_get(OPENAPI, description)
    for operation in OPERATIONS:
        answering = _answering(operation, programs, browsers)
        expected = _expects_nothing if operation.always else None
        app.router.add_route(operation.method, BASE + operation.path, answering, expect_handler=expected)
        if operation.method == "GET" and operation.media != event_stream.MEDIA:
            app.router.add_route("HEAD", BASE + operation.path, answering)


async def _expects_nothing(request: web.Request) -> None:
    """Pay no attention to an Expect header: what is answered does not depend on the body."""


@cache
def _description(token: bool) -> bytes:
    """Return the description as it is sent; nobody waits for it before somebody asks."""
    return json.dumps(document(GROUPS, event_stream.KINDS, token=token)).encode()


def _answering(
    operation: Operation, programs: Programs, browsers: WebSocketSessions
) -> Callable[[web.Request], Awaitable[web.StreamResponse]]:
    async def answering(request: web.Request) -> web.StreamResponse:
        operator = programs.operator_of(request, strict=not operation.always)
        with programs.asking(operator):
            return await operation.answer(Call(request, operator, browsers, programs))

    return answering
