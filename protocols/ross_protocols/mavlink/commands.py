"""The command protocol: commands from either of its messages, acknowledgements, and what a command's degrees mean."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

from ross_protocols.mavlink.component_id import ComponentId, target_of
from ross_protocols.mavlink.dialect import common, ross
from ross_protocols.mavlink.field_converters import clockwise

UNKNOWN_PROGRESS = 255
HEARD = 128  # from this confirmation on a sender knows that the command has arrived: it asks for its end alone
MOST_CONFIRMATION = 255  # where a sender stops counting
NOT_TOLD = 2**31 - 1  # in an integer of COMMAND_INT, what NaN is among its floats
LONGEST_NOISE = 60.0  # of MAV_CMD_ROSS_NOISE [s]
LONGEST_ENROLMENT = 300.0  # of MAV_CMD_ROSS_ENROL [s]
MOST_NAMES = 9999  # numbers of names for voices, of the same

COMMAND_LONG = common.MAVLINK_MSG_ID_COMMAND_LONG
COMMAND_INT = common.MAVLINK_MSG_ID_COMMAND_INT
COMMAND_CANCEL = 80


class Result(IntEnum):
    """What becomes of a command: MAV_RESULT."""

    ACCEPTED = 0
    TEMPORARILY_REJECTED = 1  # not in this state
    DENIED = 2  # not with these numbers, or not by you
    UNSUPPORTED = 3
    FAILED = 4
    IN_PROGRESS = 5
    CANCELLED = 6
    COMMAND_LONG_ONLY = 7


@dataclass(frozen=True, slots=True)
class Command:
    """A command that arrived; the numbers are as on the wire."""

    number: int  # MAV_CMD
    numbers: tuple[float, ...]  # param1 to param7
    target: ComponentId
    long: bool  # COMMAND_LONG: all seven numbers are exact
    confirmation: int = 0  # above 0: sent again


@dataclass(frozen=True, slots=True)
class CancelRequest:
    """COMMAND_CANCEL: end a command that is in progress."""

    number: int  # MAV_CMD
    target: ComponentId


def is_stop(message: Any) -> bool:
    """Tell whether a message commands a stop, of whomever."""
    command = command_of(message)
    return isinstance(command, Command) and command.number == ross.MAV_CMD_ROSS_STOP


def command_of(message: Any) -> Command | CancelRequest | None:
    """Return the command that a message carries; None: it carries none.

    >>> message = common.MAVLink_command_int_message(1, 154, 0, 1000, 0, 0, 0.0, 30.0, 0.0, 0.0, NOT_TOLD, 0, 1.0)
    >>> command_of(message).numbers
    (0.0, 30.0, 0.0, 0.0, nan, 0, 1.0)
    """
    number = message.get_msgId()
    if number == COMMAND_LONG:
        numbers = tuple(getattr(message, f"param{i}") for i in range(1, 8))
        long, confirmation = True, message.confirmation
    elif number == COMMAND_INT:
        x, y = (math.nan if number == NOT_TOLD else number for number in (message.x, message.y))
        numbers = (message.param1, message.param2, message.param3, message.param4, x, y, message.z)
        long, confirmation = False, 0
    elif number == COMMAND_CANCEL:
        return CancelRequest(message.command, target_of(message))
    else:
        return None
    return Command(message.command, numbers, target_of(message), long=long, confirmation=confirmation)


def acknowledgement(number: int, result: Result, target: ComponentId, progress: float | None = None) -> Any:
    """Return the COMMAND_ACK to whoever sent command ``number``; ``progress`` is 0 to 1, None: not known."""
    percent = UNKNOWN_PROGRESS if progress is None else round(100 * min(max(progress, 0.0), 1.0))
    return common.MAVLink_command_ack_message(
        number,
        result,
        progress=percent if result is Result.IN_PROGRESS else 0,
        target_system=target.system,
        target_component=target.component,
    )


@dataclass(frozen=True, slots=True)
class Acknowledged:
    """A COMMAND_ACK that arrived."""

    number: int  # MAV_CMD
    result: Result
    progress: float | None  # 0 to 1, None: not known
    target: ComponentId


def acknowledged_of(message: Any) -> Acknowledged | None:
    """Return the acknowledgement that a message carries; None: none, or one with a result that nobody knows."""
    if message.get_msgId() != common.MAVLINK_MSG_ID_COMMAND_ACK or message.result not in list(Result):
        return None
    known = message.result == Result.IN_PROGRESS and message.progress <= 100
    progress = message.progress / 100 if known else None
    return Acknowledged(message.command, Result(message.result), progress, target_of(message))


def long_message(number: int, numbers: Sequence[float], target: ComponentId, confirmation: int = 0) -> Any:
    """Return the COMMAND_LONG to somebody; of its seven numbers those that are not given are 0."""
    seven = [*map(float, numbers), *[0.0] * 7][:7]
    return common.MAVLink_command_long_message(*target, number, confirmation, *seven)


def cancel_message(number: int, target: ComponentId) -> Any:
    """Return the COMMAND_CANCEL to somebody who has command ``number`` in progress."""
    return ross.MAVLink_command_cancel_message(*target, number)


def direction(degrees: float) -> float:
    """Return an azimuth or heading of a command [deg, clockwise] as inside [rad, counter-clockwise].

    >>> round(direction(90.0), 4)
    -1.5708
    """
    return clockwise(math.radians(degrees))
