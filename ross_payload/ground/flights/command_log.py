"""Orders that a log holds, and what was answered."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ross_payload.ground.model.view import word
from ross_protocols.mavlink.codec import Packet
from ross_protocols.mavlink.commands import UNKNOWN_PROGRESS, Command, Result, command_of
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common


@dataclass(frozen=True, slots=True)
class Answer:
    """One COMMAND_ACK; of several that tell of progress in a row the latest."""

    at: float  # [s]
    result: str
    progress: float | None  # 0 to 1


@dataclass(frozen=True, slots=True)
class LoggedCommand:
    """One order; ``at`` and ``sender`` are None when the log holds its answers only."""

    at: float | None  # [s]
    sender: ComponentId | None
    payload: ComponentId
    command: str
    numbers: tuple[float, ...]  # as on the wire
    answers: tuple[Answer, ...] = ()


Entry = dict[str, Any]


class CommandLog:
    """Puts answers to orders, in the order in which they come."""

    def __init__(self) -> None:
        self._asked: list[Entry] = []

    def on_packet(self, packet: Packet, at: float, payloads: tuple[ComponentId, ...]) -> None:
        """Take a message; those that are neither order nor answer are left alone."""
        who = packet.sender
        order = command_of(packet.message)
        if isinstance(order, Command):
            for payload in (each for each in payloads if order.target.includes(each)):
                to_all = order.target != payload and not _is_ours(order.number)
                self._ask(order, at, who, payload, to_all=to_all)
        elif packet.name == "COMMAND_ACK" and who in payloads:
            self._answer(packet.message, at, who)

    def asked(self, payload: ComponentId) -> tuple[LoggedCommand, ...]:
        """Return the orders to a payload, the oldest first; of those to all components the ones that it answered."""
        mine = [dict(each) for each in self._asked if each["payload"] == payload]
        meant = (each for each in mine if not each.pop("to_all") or each["answers"])
        return tuple(LoggedCommand(**{**each, "answers": tuple(each["answers"])}) for each in meant)

    def _ask(self, order: Command, at: float, sender: ComponentId, payload: ComponentId, *, to_all: bool) -> None:
        if order.confirmation and self._latest(order.number, payload, sender) is not None:
            return  # said again
        numbers = tuple(order.numbers)
        name = command_name(order.number)
        self._put(at=at, sender=sender, payload=payload, command=name, numbers=numbers, to_all=to_all)

    def _answer(self, message: Any, at: float, payload: ComponentId) -> None:
        asker = ComponentId(message.target_system, message.target_component)
        order = self._latest(message.command, payload, asker if asker.system else None)
        if order is None:
            name = command_name(message.command)
            order = self._put(at=None, sender=None, payload=payload, command=name, numbers=(), to_all=False)
        running = message.result == Result.IN_PROGRESS
        known = running and message.progress != UNKNOWN_PROGRESS
        answer = Answer(at, result_name(message.result), message.progress / 100 if known else None)
        if running and order["answers"] and order["answers"][-1].result == answer.result:
            order["answers"].pop()
        order["answers"].append(answer)

    def _put(self, **order: Any) -> Entry:
        self._asked.append({**order, "answers": []})
        return self._asked[-1]

    def _latest(self, number: int, payload: ComponentId, sender: ComponentId | None) -> Entry | None:
        """Return the latest order of a number from a sender, None: of anybody."""
        for order in reversed(self._asked):
            same = order["payload"] == payload and order["command"] == command_name(number)
            if same and (sender is None or order["sender"] in (None, sender)):
                return order
        return None


def _is_ours(number: int) -> bool:
    """Whether only a payload obeys a command."""
    return (word("MAV_CMD", number) or "").startswith("ross_")


def command_name(number: int) -> str:
    """Return what a command is called.

    >>> command_name(54003), command_name(512), command_name(31999)
    ('turn', 'REQUEST_MESSAGE', '31999')
    """
    name = word("MAV_CMD", number) or str(number)
    return name.removeprefix("ross_") if name.startswith("ross_") else name.upper()


def result_name(number: int) -> str:
    """Return what a result is called.

    >>> result_name(6)
    'cancelled'
    """
    names = {int(result): result.name.lower() for result in Result}
    return names.get(number, str(number))


COMMAND_MESSAGES = (
    common.MAVLINK_MSG_ID_COMMAND_LONG,
    common.MAVLINK_MSG_ID_COMMAND_INT,
    common.MAVLINK_MSG_ID_COMMAND_ACK,
)  # messages that `CommandLog` reads
