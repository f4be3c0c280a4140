"""What is known of a payload as JSON text, section by section; each is drawn when somebody watches and it changed.

The text is made once per change, however many browsers get it.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from typing import Any

from ross_payload.ground.model.payload_state import PayloadState
from ross_payload.ground.model.view import SECTIONS
from ross_payload.json_values import finite

DRAWN_FROM: dict[str, tuple[str, ...]] = {
    "standing": (
        "who", "last", "boots", "twin", "tunnelled", "mirrors", "status", "heartbeat", "state", "information", "flaws",
    ),
    "pointing": ("status", "mirrors", "information"),
    "mission": ("status", "began", "ended", "mirrors", "separations", "alignments"),
    "sources": ("status", "sources", "trails", "announced", "azimuths"),
    "plan": ("alignments",),
    "densities": ("densities",),
    "isolation": ("isolations",),
    "groups": ("separations",),
    "streams": ("streams",),
    "history": ("history",),
    "events": ("texts",),
    "health": ("who", "twin", "counts", "status", "status_at", "audio", "recording", "links", "computer", "streams"),
}  # fmt: skip
"""Attributes of `PayloadState` that each section of `view` reads; the settings change all."""


class ViewCache:
    """Sections of one payload as JSON text; ``number`` counts changes, and each section has that of its latest.

    ``pace`` is how far apart the payload is heard between two drawings of its history [s]: that is long, and grows all
    the time.
    """

    def __init__(self, pace: float = 0.0) -> None:
        self.number = 0
        self._pace = pace
        self._texts: dict[str, str] = {}
        self._changed: dict[str, int] = {}
        self._settings: dict[str, float] = {}
        self._drawn_from: dict[str, tuple[Any, ...]] = {}
        self._grown = -math.inf  # when the payload was heard whose history was drawn [s]
        self._keys: dict[str, Any] = {}

    def update(self, known: PayloadState, settings: Mapping[str, float]) -> None:
        """Draw what has changed since the last call."""
        changed, self._settings = settings != self._settings, dict(settings)
        soon = abs(known.last - self._grown) < self._pace and len(known.history) > 1
        for name, attributes in DRAWN_FROM.items():
            shown = tuple(getattr(known, each) for each in attributes)
            before = self._drawn_from.get(name)
            same = before is not None and all(new is old for new, old in zip(shown, before, strict=True))
            if changed or not (same or (name == "history" and soon)):
                self._drawn_from[name] = shown
                self.put(name, SECTIONS[name](known, settings))
                self._grown = known.last if name == "history" else self._grown

    def offer(self, name: str, key: Any, draw: Callable[[], Any]) -> None:
        """Draw one more section when its key is another than before."""
        if name not in self._keys or self._keys[name] != key:
            self._keys[name] = key
            self.put(name, draw())

    def put(self, name: str, section: Any) -> None:
        """Keep a section."""
        text = to_json(section)
        if self._texts.get(name) != text:
            self.number += 1
            self._texts[name], self._changed[name] = text, self.number

    def since(self, number: int) -> str:
        """Return the sections that changed after a number, as the text of one JSON object; empty: none."""
        parts = [f'"{name}":{self._texts[name]}' for name, changed in self._changed.items() if changed > number]
        return "{" + ",".join(parts) + "}" if parts else ""


def to_json(thing: Any) -> str:
    """Return compact JSON; a number that is none becomes null.

    >>> to_json({"gain": math.inf, "k": 3})
    '{"gain":null,"k":3}'
    """
    try:
        return json.dumps(thing, separators=(",", ":"), allow_nan=False)
    except ValueError:
        return json.dumps(finite(thing), separators=(",", ":"), allow_nan=False)
