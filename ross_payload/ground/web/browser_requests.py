"""What a browser may ask for, and what is answered when it may not."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

from ross_payload.ground.client.command_protocol import CommandProtocol
from ross_payload.ground.client.command_types import Cancel, Stop
from ross_payload.ground.client.order_json import order_of
from ross_payload.ground.web.browser_session import BrowserSession
from ross_payload.ground.web.positions import number, typed_position
from ross_protocols.mavlink.component_id import ComponentId

Message = dict[str, Any]
SLOTS = ("a", "b")
LONGEST = 1e9  # [s] of a flight


def on_message(session: BrowserSession, text: str) -> None:
    """Do what a browser asks for; what cannot be done is refused in words."""
    what = "message"
    try:
        message = json.loads(text)
        if not isinstance(message, dict):
            raise ValueError(f"expected an object with a type, got {text[:40]}")
        what = _name(message)
        kind = str(message.get("type"))[:40]
        if kind not in REQUESTS:
            raise ValueError(f"type: expected one of {', '.join(REQUESTS)}, got {kind}")
        REQUESTS[kind](session, message)
    except (ValueError, OverflowError, RecursionError) as error:
        session.refuse(what, str(error))


def _name(message: Message) -> str:
    """Return what a refusal names: an order by its kind, all else by its type."""
    order = message.get("order")
    kind = order.get("kind") if isinstance(order, dict) else message.get("type")
    return str(kind)[:40]


def _order(session: BrowserSession, message: Message) -> None:
    """Pass an order on; a stop is anybody's, and for whoever was not heard yet, too."""
    wanted = message.get("order")
    if not isinstance(wanted, dict):
        raise ValueError(f"order: expected an object with a kind, got {str(wanted)[:40]}")
    order, orders = order_of(wanted), session.state.client.orders
    who = _live(session, message) if isinstance(order, Stop) else _known(session, message)
    by_number = isinstance(order, Cancel) and "number" in wanted
    number = _number_of(orders, who, wanted["number"]) if by_number else 0
    if not isinstance(order, Stop):
        _hold(session)
    if by_number:
        orders.cancel(number)
    else:
        orders.order(who, order)
    session.state.tick()


def _number_of(orders: CommandProtocol, who: ComponentId, number: Any) -> int:
    if not any(each.number == number and each.who == who for each in orders.doing):
        raise ValueError(f"number: expected that of an order to {who}, got {str(number)[:20]}")
    return int(number)


def _set(session: BrowserSession, message: Message) -> None:
    """Set a parameter; its own bounds are the payload's to judge."""
    who, name, value = _known(session, message), message.get("name"), message.get("value")
    settings = session.state.client.settings(who)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"{str(name)[:40]}: expected a number, got {str(value)[:40]}")
    _hold(session)
    settings.set(str(name), float(value))
    session.state.tick()


def _refresh(session: BrowserSession, message: Message) -> None:
    session.state.client.settings(_known(session, message)).refresh()
    session.state.tick()


def _flight(session: BrowserSession, message: Message) -> None:
    """Open, close or move a playback."""
    name = message.get("slot")
    if name not in SLOTS:
        raise ValueError(f"slot: expected one of {', '.join(SLOTS)}, got {str(name)[:20]}")
    if "open" in message:
        session.open_flight(name, str(message["open"]))
        return
    slot = session.slots.get(name)
    if slot is None:
        raise ValueError(f"no flight is open in {name}")
    if message.get("close") is True:
        session.close_flight(name)
    elif "seek" in message:
        slot.request(seek=number(message, "seek", 0, LONGEST))
    elif "speed" in message:
        slot.request(speed=number(message, "speed", 1, 64))
    elif "watch" in message:
        slot.watch(ComponentId.parse(str(message["watch"])))
    elif isinstance(message.get("play"), bool):
        slot.request(play=message["play"])
    else:
        raise ValueError("flight: expected one of open, close, seek, play, speed, watch, got none of them")


def _hold(session: BrowserSession) -> None:
    """Take control when it is free.

    Raises
    ------
    ValueError
        When somebody else has it.
    """
    control = session.state.control
    if not control.may_order(session.id, session.name):
        raise ValueError(f"{control.name} has control: take control first")


def _control(session: BrowserSession, message: Message) -> None:
    if message.get("take") is True:
        session.state.control.acquire(session.id, session.name)
    else:
        session.state.control.release(session.id)
    session.state.tick()


def _place(session: BrowserSession, message: Message) -> None:
    session.state.positions.typed[_known(session, message)] = typed_position(message)
    session.state.tick()


def _who(message: Message) -> ComponentId:
    return ComponentId.parse(str(message.get("id")))


def _live(session: BrowserSession, message: Message) -> ComponentId:
    if not session.state.live:
        raise ValueError("a recorded flight accepts no commands")
    return _who(message)


def _known(session: BrowserSession, message: Message) -> ComponentId:
    who = _live(session, message)
    if who not in session.state.station.fleet.payloads:
        raise ValueError(f"id: expected a payload that was received, got {who}")
    return who


REQUESTS: dict[str, Callable[[BrowserSession, Message], None]] = {
    "order": _order,
    "set": _set,
    "refresh": _refresh,
    "watch": lambda session, message: session.watch(_who(message)),
    "unwatch": lambda session, message: session.watch(None),
    "control": _control,
    "place": _place,
    "flight": _flight,
}
