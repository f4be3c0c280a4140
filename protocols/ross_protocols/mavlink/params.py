"""The parameter protocol: every parameter is a REAL32, and whatever a client makes of that is understood."""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

from ross_protocols.mavlink.component_id import ComponentId, target_of
from ross_protocols.mavlink.dialect import common

NAME_SIZE = 16  # characters
NO_INDEX = 65535  # of a PARAM_VALUE that nobody asked for by index
REAL32 = common.MAV_PARAM_TYPE_REAL32
INTEGERS = {
    common.MAV_PARAM_TYPE_UINT8: "<B3x",
    common.MAV_PARAM_TYPE_INT8: "<b3x",
    common.MAV_PARAM_TYPE_UINT16: "<H2x",
    common.MAV_PARAM_TYPE_INT16: "<h2x",
    common.MAV_PARAM_TYPE_UINT32: "<I",
    common.MAV_PARAM_TYPE_INT32: "<i",
}  # of what fits into the four bytes of a float
REQUESTS: tuple[int, ...] = (
    common.MAVLINK_MSG_ID_PARAM_REQUEST_LIST,
    common.MAVLINK_MSG_ID_PARAM_REQUEST_READ,
    common.MAVLINK_MSG_ID_PARAM_SET,
)


class ParamError(IntEnum):
    """Why a request is not fulfilled: MAV_PARAM_ERROR."""

    DOES_NOT_EXIST = 1
    VALUE_OUT_OF_RANGE = 2
    PERMISSION_DENIED = 3
    COMPONENT_NOT_FOUND = 4
    READ_ONLY = 5


@dataclass(frozen=True, slots=True)
class ListRequest:
    """PARAM_REQUEST_LIST: every parameter."""

    target: ComponentId


@dataclass(frozen=True, slots=True)
class ReadRequest:
    """PARAM_REQUEST_READ: one parameter, by its index or, when that is negative, by its name."""

    target: ComponentId
    name: str
    index: int


@dataclass(frozen=True, slots=True)
class SetRequest:
    """PARAM_SET: change one parameter."""

    target: ComponentId
    name: str
    value: float


@dataclass(frozen=True, slots=True)
class ParamValue:
    """PARAM_VALUE: what one of ``count`` parameters is."""

    name: str
    value: float
    index: int | None  # None: not told
    count: int


@dataclass(frozen=True, slots=True)
class Refused:
    """PARAM_ERROR: a request was not fulfilled."""

    target: ComponentId
    name: str
    error: int  # MAV_PARAM_ERROR


def answer_of(message: Any) -> ParamValue | Refused | None:
    """Return what a message answers about parameters; None: nothing.

    >>> answer_of(value_message("EXP_UNIT", 2.3, 4, 30))
    ParamValue(name='EXP_UNIT', value=2.3, index=4, count=30)
    """
    number = message.get_msgId()
    if number == common.MAVLINK_MSG_ID_PARAM_VALUE:
        value = number_meant(message.param_value, message.param_type)
        index = None if message.param_index == NO_INDEX else message.param_index
        return ParamValue(_name(message.param_id), value, index, message.param_count)
    if number == common.MAVLINK_MSG_ID_PARAM_ERROR:
        return Refused(target_of(message), _name(message.param_id), message.error)
    return None


def list_message(target: ComponentId) -> Any:
    """Return the PARAM_REQUEST_LIST to somebody."""
    return common.MAVLink_param_request_list_message(*target)


def read_message(index: int, target: ComponentId) -> Any:
    """Return the PARAM_REQUEST_READ of one parameter of somebody."""
    return common.MAVLink_param_request_read_message(*target, b"", index)


def set_message(name: str, value: float, target: ComponentId) -> Any:
    """Return the PARAM_SET to somebody."""
    return common.MAVLink_param_set_message(*target, name.encode("ascii"), value, REAL32)


def same_on_the_wire(number: float, other: float) -> bool:
    """Whether two numbers are one float on the wire.

    >>> same_on_the_wire(2.3, 2.2999999523162842), same_on_the_wire(2.3, 2.31)
    (True, False)
    """
    return _float32(number) == _float32(other)


def _name(wire: str | bytes) -> str:
    return wire if isinstance(wire, str) else wire.split(b"\0")[0].decode("ascii", "replace")


def request_of(message: Any) -> ListRequest | ReadRequest | SetRequest | None:
    """Return what a message asks about parameters; None: nothing."""
    number = message.get_msgId()
    if number == common.MAVLINK_MSG_ID_PARAM_REQUEST_LIST:
        return ListRequest(target_of(message))
    if number == common.MAVLINK_MSG_ID_PARAM_REQUEST_READ:
        return ReadRequest(target_of(message), str(message.param_id), message.param_index)
    if number == common.MAVLINK_MSG_ID_PARAM_SET:
        value = number_meant(message.param_value, message.param_type)
        return SetRequest(target_of(message), str(message.param_id), value)
    return None


def value_message(name: str, value: float, index: int, count: int) -> Any:
    """Return the PARAM_VALUE of one of ``count`` parameters."""
    return common.MAVLink_param_value_message(name.encode("ascii"), value, REAL32, count, index)


def error_message(request: ReadRequest | SetRequest, error: ParamError, target: ComponentId) -> Any:
    """Return the PARAM_ERROR that tells a sender why its request is not fulfilled."""
    index = request.index if isinstance(request, ReadRequest) else -1
    return common.MAVLink_param_error_message(*target, request.name.encode("ascii", "replace"), index, error)


def number_meant(value: float, kind: int) -> float:
    """Return the number that the float of a PARAM_SET stands for; ``kind`` is its MAV_PARAM_TYPE.

    A client that takes the parameter for an integer sends the integer as a float, or its bytes in the place of a float;
    the bytes of a small integer are a float next to nothing, and those of a small negative one no number.

    >>> [number_meant(wire, common.MAV_PARAM_TYPE_INT32) for wire in (12.0, 1.6815581571897805e-44, -math.nan)]
    [12.0, 12.0, -4194304.0]
    >>> number_meant(0.10000000149011612, REAL32)
    0.1
    """
    layout = INTEGERS.get(kind)
    if layout is not None and (0 < abs(value) < 1 or math.isnan(value)):
        return float(struct.unpack(layout, struct.pack("<f", value))[0])
    return shortest(value)


def shortest(value: float) -> float:
    """Return the shortest decimal number that is this float on the wire.

    >>> shortest(2.2999999523162842)
    2.3
    """
    if not math.isfinite(value):
        return value
    digits = (float(f"{value:.{size}g}") for size in range(6, 10))
    return next((number for number in digits if _float32(number) == value), value)


def _float32(number: float) -> float:
    try:
        return float(struct.unpack("<f", struct.pack("<f", number))[0])
    except OverflowError:  # rounded up beyond the greatest float
        return math.inf
