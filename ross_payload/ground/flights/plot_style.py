"""How our pictures look: colours that are told apart by everybody (Okabe and Ito 2008), and matplotlib's settings."""

from __future__ import annotations

from typing import Any

from ross_protocols.angle_text import frame

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#999999")
STYLE: dict[Any, Any] = {
    "text.parse_math": False,
    "font.size": 8,
    "axes.titlesize": 9,
    "axes.titleweight": "bold",
    "svg.hashsalt": "ross",
}


def compass_rose(axes: Any, title: str, *, earth: bool) -> None:
    """Make polar axes a compass: 0 at the top, clockwise, labelled in degrees; the title says what 0 is.

    What is drawn on them is clockwise too: minus an azimuth [rad].
    """
    axes.set_theta_zero_location("N")
    axes.set_theta_direction(-1)
    axes.set_thetagrids(range(0, 360, 45), [f"{angle}" for angle in range(0, 360, 45)])
    axes.set_yticks([])
    axes.set_title(f"{title}\ndegrees clockwise {frame(earth)}")


def parts(colour: str) -> tuple[float, float, float]:
    """Return red, green and blue, each from 0 to 1.

    >>> parts("#00ff33")
    (0.0, 1.0, 0.2)
    """
    red, green, blue = bytes.fromhex(colour.removeprefix("#"))
    return red / 255, green / 255, blue / 255
