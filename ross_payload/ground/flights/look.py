"""How our pictures look: colours that are told apart by everybody (Okabe and Ito 2008), and matplotlib's settings."""

from __future__ import annotations

from typing import Any

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#999999")
STYLE: dict[Any, Any] = {
    "text.parse_math": False,
    "font.size": 8,
    "axes.titlesize": 9,
    "axes.titleweight": "bold",
    "svg.hashsalt": "ross",
}


def parts(colour: str) -> tuple[float, float, float]:
    """Return red, green and blue, each from 0 to 1.

    >>> parts("#00ff33")
    (0.0, 1.0, 0.2)
    """
    red, green, blue = bytes.fromhex(colour.removeprefix("#"))
    return red / 255, green / 255, blue / 255
