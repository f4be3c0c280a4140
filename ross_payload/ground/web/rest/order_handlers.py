"""What programs may order, by the page's own rules: control, the payload's words, and a stop that needs nothing."""

from __future__ import annotations

from functools import reduce
from operator import or_
from typing import Annotated, Any

from pydantic import Field, RootModel

from ross_payload.ground.client.command_status import REFUSED, CommandStatus
from ross_payload.ground.client.command_types import Stop
from ross_payload.ground.client.order_models import MODELS, OrderModel
from ross_payload.ground.client.parameters import REASON_TIMEOUT_S
from ross_payload.ground.web.rest import page_answers
from ross_payload.ground.web.rest.operation import Call
from ross_payload.ground.web.rest.places import OfOrder, OfPayload, Wait
from ross_payload.ground.web.rest.problems import Refusal
from ross_protocols.mavlink.component_id import ComponentId

BASE = "/api/v1"
AnyOrder: Any = Annotated[reduce(or_, MODELS.values()), Field(discriminator="kind")]


class GivenOrder(RootModel[AnyOrder]):
    """What is ordered, by its `kind`."""


async def get_orders(call: Call, where: OfPayload) -> page_answers.Orders:
    """The latest orders to a payload, newest last, whoever gave them: of all payloads 50 are kept."""
    doing = call.operator.state.client.doing(where.who)
    if not doing:
        call.operator.known(where.who)
    return page_answers.Orders(orders=[told_of(each) for each in doing])


async def give_order(call: Call, where: OfPayload, query: Wait, body: GivenOrder) -> page_answers.OrderStatus:
    """Order something, and take control if it is free.

    What becomes of it is asked for at its `url`, or waited for with `wait`. What the payload refuses while the request
    waits is a problem (409, refused) with the payload's words; else its `state` is refused, and `reason` has them.
    """
    wanted: OrderModel = body.root
    try:
        order = wanted.order()
    except ValueError as error:
        raise Refusal(422, str(error)) from error
    told = await _waited(call, call.operator.give(where.who, order), query.wait)
    if query.wait and told.state == REFUSED:
        raise Refusal(409, f"{told.words} was refused: {told.reason}", "refused", headers={"Location": told.url})
    return told


async def get_order(call: Call, where: OfOrder, query: Wait) -> page_answers.OrderStatus:
    """What has become of an order."""
    return await _waited(call, call.operator.status(where.who, where.number), query.wait)


async def cancel_order(call: Call, where: OfOrder, query: Wait) -> page_answers.OrderStatus:
    """Ask the payload to end one order; one that is over stays as it is, and so does a stop."""
    return await _waited(call, call.operator.cancel(where.who, where.number), query.wait)


async def stop_payload(call: Call, where: OfPayload) -> page_answers.OrderStatus:
    """Stop: decelerate now, and refuse to move until re-armed.

    It needs no body and no control, and also goes to a payload that was not received yet, for half a minute. A body, a
    content type or a query that comes with it is ignored.
    """
    return told_of(call.operator.give(where.who, Stop()))


async def stop_all(call: Call) -> page_answers.Orders:
    """Stop every payload that is listed, as `/payloads/{payload}/stop` does."""
    payloads = list(call.operator.state.station.fleet.payloads)
    if call.operator.state.live and not payloads:
        where = f"{BASE}/payloads/ID/stop"
        raise Refusal(404, f"expected a payload that was received, got none: {where} stops any", "unknown-payload")
    return page_answers.Orders(orders=[told_of(call.operator.give(who, Stop())) for who in payloads])


async def get_control(call: Call) -> page_answers.Control:
    """Who may command."""
    return page_answers.Control.model_validate(call.operator.control())


async def take_control(call: Call) -> page_answers.Control:
    """Take control, whoever has it; the one who had it sees that at once.

    A program keeps control for 10 s after its latest request, and as long as one is under way.
    """
    call.operator.take_control()
    return await get_control(call)


async def give_up_control(call: Call) -> page_answers.Control:
    """Let control be free; without effect when another one has it."""
    call.operator.give_up_control()
    return await get_control(call)


async def _waited(call: Call, status: CommandStatus, wait: float) -> page_answers.OrderStatus:
    """Return how an order is when it is over, or after a while [s]; the payload's reason comes a little later."""
    changed, who, number = call.operator.state.changed, status.who, status.number
    if wait > 0 and not status.explained:
        ended = await changed.within(wait, lambda: _latest(call, who, number, "over"))
        if ended is not None and not ended.explained:
            await changed.within(min(REASON_TIMEOUT_S, wait), lambda: _latest(call, who, number, "explained"))
        status = call.operator.status(who, number)
    return told_of(status)


def _latest(call: Call, who: ComponentId, number: int, what: str) -> CommandStatus | None:
    """Return an order's status as soon as it is so, or nobody waits for it; of one that is not kept it is over."""
    status = call.operator.status(who, number)
    return status if getattr(status, what) or call.abandoned else None


def told_of(status: CommandStatus) -> page_answers.OrderStatus:
    """Return what is told of an order."""
    url = f"{BASE}/payloads/{status.who}/orders/{status.number}"
    return page_answers.OrderStatus.model_validate({**status.json(), "url": url, "over": status.over})
