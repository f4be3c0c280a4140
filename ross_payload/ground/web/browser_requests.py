"""What a browser may ask for, and what is answered when it may not."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

from ross_payload.ground.client.command_types import Cancel
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
    """Pass an order on, or cancel one."""
    wanted, operator = message.get("order"), session.operator
    if not isinstance(wanted, dict):
        raise ValueError(f"order: expected an object with a kind, got {str(wanted)[:40]}")
    order, who = order_of(wanted), _who(message)
    if isinstance(order, Cancel) and "number" in wanted:
        operator.cancel(who, wanted["number"])
    else:
        operator.give(who, order)


def _set(session: BrowserSession, message: Message) -> None:
    """Set a parameter; its own bounds are the payload's to judge."""
    name, value, settings = message.get("name"), message.get("value"), session.operator.settings(_who(message))
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"{str(name)[:40]}: expected a number, got {str(value)[:40]}")
    session.operator.hold()
    settings.set(str(name), float(value))
    session.state.tick()


def _refresh(session: BrowserSession, message: Message) -> None:
    session.operator.settings(_who(message)).refresh()
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


def _control(session: BrowserSession, message: Message) -> None:
    if message.get("take") is True:
        session.operator.take_control()
    else:
        session.operator.give_up_control()


def _place(session: BrowserSession, message: Message) -> None:
    who = _who(message)
    session.operator.addressed(who)
    session.state.positions.typed[who] = typed_position(message)
    session.state.tick()


def _who(message: Message) -> ComponentId:
    return ComponentId.parse(str(message.get("id")))


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
