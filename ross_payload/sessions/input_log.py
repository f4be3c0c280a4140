"""Inputs as lines of JSON: every float comes back as it was; the samples stand in the audio file.

What has its default is left out, so that a line has about 200 bytes. Whoever reads must expect a torn last line.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, astuple, replace
from typing import Any

from pydantic import TypeAdapter, ValidationError

from ross_payload import orders
from ross_payload.bounded_files import parsed_json
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Attitude, AudioBlock, AudioFlag, Input, Samples
from ross_payload.json_values import are_finite
from ross_payload.orders import Order
from ross_payload.pointing import BaseRate, Pointing

ATTITUDE = 6  # numbers of an attitude, before its height and the speeds of rotors
ORDERS: dict[str, type[Order]] = {
    name: kind for name, kind in vars(orders).items() if isinstance(kind, type) and issubclass(kind, Order)
}


def line(hop: Input, *, exact: bool = True) -> str:
    """Write an Input, without its samples, as one line; ``exact``: 24 bits hold the samples without rounding."""
    block, pointing = hop.block, hop.pointing
    values: dict[str, Any] = {
        "index": block.index,
        "n": block.samples.shape[1],
        "time": block.time,
        "heading": [hop.heading_start, pointing.heading],
        "joint": pointing.joint,
        "pointing": [pointing.time, pointing.base, pointing.offset, pointing.base_rate],
        "settled": bool(hop.settled),
        "attitude": astuple(hop.attitude)[:ATTITUDE],
    }
    rare = {
        "lost": block.lost,
        "flags": int(block.flags),
        "fault": hop.fault,
        "orders": [{"order": type(order).__name__, **asdict(order)} for order in hop.orders],
        "raw": block.raw is not None,
        "carried": block.carried,
        "rounded": not exact,
    }
    if hop.attitude.height is not None:
        values["height"] = hop.attitude.height
    if hop.attitude.rotor_speeds:
        values["rotors"] = hop.attitude.rotor_speeds
    return json.dumps(values | {name: value for name, value in rare.items() if value}, separators=(",", ":")) + "\n"


def parsed(text: bytes) -> dict[str, Any] | None:
    """Read a line; None when it is torn or damaged."""
    try:
        values = parsed_json(text)
        *angles, age, _ = values["attitude"]
        whole = are_finite(values["time"], values["joint"], *values["heading"], *angles)
        whole = whole and (age == math.inf or are_finite(age))  # that of an attitude which never came
        whole = whole and len(values["heading"]) == 2 and len(values["attitude"]) == ATTITUDE
        whole = whole and are_finite(values.get("height", 0.0), values.get("carried", 0.0))
        speeds = values.get("rotors", ())
        whole = whole and isinstance(speeds, list | tuple) and are_finite(*speeds)
        told = values.get("pointing", (0.0, 0.0, 0.0, 0.0))
        whole = whole and len(told) == 4 and are_finite(*told)
        whole = whole and isinstance(values["settled"], bool) and isinstance(values.get("fault", ""), str)
        counts = (values["n"], values["index"], values.get("lost", 0), values.get("flags", 0))
        whole = whole and all(type(count) is int and abs(count) < 2**53 for count in counts)
        whole = whole and 0 < values["n"] < 2**31
        orders = values.get("orders", [])
        whole = whole and isinstance(orders, list) and all(isinstance(order, dict) for order in orders)
    except (ValueError, KeyError, TypeError):
        return None
    return values if whole and text.endswith(b"\n") else None


def completed(lines: Iterable[dict[str, Any]], rate: int) -> Iterator[dict[str, Any]]:
    """Add to lines of an older version where the array pointed."""
    base_rate = BaseRate()
    for values in lines:
        if "pointing" not in values:
            time, (yaw, *_, known) = values["time"] + values["n"] / rate, values["attitude"]
            zero = values["heading"][1] - values["joint"]
            values["pointing"] = [time, yaw, zero - yaw, base_rate.update(time, zero, earth=known)]
        yield values


def input_of(values: Mapping[str, Any], samples: Samples, raw: Samples | None) -> Input:
    """Make the Input of a line and its samples (2, n).

    Raises
    ------
    ConfigError
        When it carries an order that this program does not know.
    """
    block = AudioBlock(
        samples,
        values["index"],
        values["time"],
        values.get("lost", 0),
        AudioFlag(values.get("flags", 0)),
        raw,
        carried=float(values.get("carried", 0.0)),
    )
    return Input(
        block=block,
        heading_start=values["heading"][0],
        pointing=_pointing_of(values),
        settled=values["settled"],
        attitude=_attitude_of(values),
        fault=values.get("fault", ""),
        orders=tuple(order_of(order) for order in values.get("orders", ())),
    )


def _attitude_of(values: Mapping[str, Any]) -> Attitude:
    attitude, speeds = Attitude(*values["attitude"]), tuple(values.get("rotors", ()))
    return replace(attitude, height=values.get("height"), rotor_speeds=speeds)


def _pointing_of(values: Mapping[str, Any]) -> Pointing:
    known = bool(values["attitude"][5])
    time, base, offset, base_rate = values["pointing"]
    return Pointing(time, values["joint"], base, offset, known, base_rate)


def order_of(values: Mapping[str, Any]) -> Order:
    """Make an order again.

    >>> order_of({"order": "ListenTo", "number": 3, "source": 1})
    ListenTo(number=3, source=1)
    """
    rest = dict(values)
    kind = ORDERS.get(str(rest.pop("order", None)))
    try:
        if kind is None:
            raise ConfigError(f"the recording contains a command that this program does not know: {values}")
        order: Order = TypeAdapter(kind).validate_python(rest)
    except ValidationError as error:
        raise ConfigError(f"the recording contains a command that this program cannot read: {values}") from error
    return order
