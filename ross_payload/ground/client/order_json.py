"""Orders from JSON objects, as the page sends them and as the words of a command line become."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from ross_payload.ground.client import command_types
from ross_payload.ground.client.stream_orders import SELECTIONS, Enrol, StopStream, Stream
from ross_protocols.mavlink.stream_command import MOST_DB, MOST_NUMBER, MUTED_DB

LONGEST_NOISE = 60.0  # [s]
LONGEST_ENROLMENT = 300.0  # [s]
MOST_NAMES = 9999

PLAIN: dict[str, type[command_types.Order]] = {
    "explore": command_types.Explore,
    "stop": command_types.Stop,
    "cancel": command_types.Cancel,
    "park": command_types.Park,
    "home": command_types.Home,
    "rearm": command_types.Rearm,
}


def order_of(mapping: Mapping[str, Any]) -> command_types.Order:
    """Return the order that a JSON object asks for.

    >>> order_of({"kind": "turn", "heading": 40}), order_of({"kind": "listen"}).words
    (Turn(heading=40.0), 'find the enrolled voice')

    Raises
    ------
    ValueError
        When it asks for none, or with a number that cannot be meant.
    """
    kind = mapping.get("kind")
    if not isinstance(kind, str) or kind not in READERS:
        raise ValueError(f"kind: expected one of {', '.join(READERS)}, got {_short(kind)}")
    return READERS[kind](mapping)


def _listen(mapping: Mapping[str, Any]) -> command_types.Order:
    source, azimuth = mapping.get("source"), mapping.get("azimuth")
    if source is not None and azimuth is not None:
        raise ValueError("listen: expected a source or an azimuth, got both")
    if source is not None:
        return command_types.Listen(source=_whole(mapping, "source", 0, 255))
    return (
        command_types.Listen()
        if azimuth is None
        else command_types.Listen(azimuth=_number(mapping, "azimuth", -360, 360))
    )


def _record(mapping: Mapping[str, Any]) -> command_types.Order:
    on = mapping.get("on")
    if not isinstance(on, bool):
        raise ValueError(f"on: expected true or false, got {_short(on)}")
    return command_types.Record(on)


def _stream(mapping: Mapping[str, Any]) -> command_types.Order:
    what = mapping.get("what")
    if what is not None and what not in SELECTIONS:
        raise ValueError(f"what: expected one of {', '.join(SELECTIONS)}, got {_short(what)}")
    muted = mapping.get("muted")
    if muted is not None and not isinstance(muted, bool):
        raise ValueError(f"muted: expected true or false, got {_short(muted)}")
    address, port = _place(mapping)
    return Stream(
        stream=_stream_number(mapping),
        what=what,
        source=_whole(mapping, "source", 0, 255) if what == "source" else 0,
        azimuth=_number(mapping, "azimuth", -360, 360) if what == "azimuth" else 0.0,
        address=address,
        port=port,
        codec=_text(mapping, "codec"),
        gain=None if mapping.get("gain") is None else _number(mapping, "gain", MUTED_DB, MOST_DB),
        muted=muted,
    )


def _place(mapping: Mapping[str, Any]) -> tuple[str, int]:
    port = _whole(mapping, "port", 1, 65535) if mapping.get("port") is not None else 0
    return _text(mapping, "address"), port


def _stream_number(mapping: Mapping[str, Any]) -> int | None:
    return None if mapping.get("stream") is None else _whole(mapping, "stream", 0, MOST_NUMBER)


def _enrol(mapping: Mapping[str, Any]) -> command_types.Order:
    return Enrol(
        source=None if mapping.get("source") is None else _whole(mapping, "source", 0, 255),
        azimuth=None if mapping.get("azimuth") is None else _number(mapping, "azimuth", -360, 360),
        seconds=_number(mapping, "seconds", 0, LONGEST_ENROLMENT) if mapping.get("seconds") is not None else 0.0,
        consent=mapping.get("consent") is True,
        voice=_whole(mapping, "voice", 0, MOST_NAMES) if mapping.get("voice") is not None else 0,
    )


def _text(mapping: Mapping[str, Any], name: str) -> str:
    value = mapping.get(name, "")
    if not isinstance(value, str):
        raise ValueError(f"{name}: expected a text, got {_short(value)}")
    return value


def _whole(mapping: Mapping[str, Any], name: str, lower: float, upper: float) -> int:
    value = _number(mapping, name, lower, upper)
    if value % 1:
        raise ValueError(f"{name}: expected a whole number, got {value:g}")
    return int(value)


def _number(mapping: Mapping[str, Any], name: str, lower: float, upper: float) -> float:
    value = mapping.get(name)
    if isinstance(value, bool) or not isinstance(value, int | float) or not lower <= value <= upper:
        raise ValueError(f"{name}: expected {lower:g} to {upper:g}, got {_short(value)}")
    return float(value)


def _short(value: Any) -> str:
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return "nothing" if value is None else "NaN"
    return repr(value)[:40]


READERS: dict[str, Callable[[Mapping[str, Any]], command_types.Order]] = {
    **{kind: lambda mapping, plain=plain: plain() for kind, plain in PLAIN.items()},  # type: ignore[misc]
    "listen": _listen,
    "turn": lambda mapping: command_types.Turn(_number(mapping, "heading", -360, 360)),
    "record": _record,
    "noise": lambda mapping: command_types.Noise(_number(mapping, "seconds", 0, LONGEST_NOISE)),
    "stream": _stream,
    "stop_stream": lambda mapping: StopStream(_stream_number(mapping), *_place(mapping)),
    "enrol": _enrol,
}
