"""Events as plain values: one event is one line of events.jsonl, whoever writes it."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from ross_payload.events import Event
from ross_payload.json_values import named

PRIVATE = ("voices", "voiceprint")


def line(event: Event) -> str:
    r"""Write one event as a line of JSON.

    >>> line(Event(0.25))
    '{"event": "Event", "time": 0.25}\n'
    """
    return json.dumps(plain(event), allow_nan=False) + "\n"


def plain(event: Event) -> dict[str, Any]:
    """One event as plain values; numbers are rounded to 9 digits, arrays to 6, audio and voice prints are left out."""
    values: dict[str, Any] = {"event": type(event).__name__}
    for name in event.__dataclass_fields__:
        if name not in PRIVATE:
            values[name] = _plain(getattr(event, name))
    return values


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return [float(f"{number:.6g}") for number in value.ravel()] if value.ndim == 1 else [_plain(v) for v in value]
    return named(value, lambda number: float(f"{number:.9g}"))
