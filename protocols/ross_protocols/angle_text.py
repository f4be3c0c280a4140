"""Angles as people read them: degrees of a compass, clockwise, and the direction that they count from.

Inside the payload angles are radians, counter-clockwise. `ross_protocols.mavlink.field_converters.compass` turns them
around; whatever prints, draws or logs one for a person writes it with these functions.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from ross_protocols.mavlink.field_converters import compass

FRAMES = {True: "from north", False: "from the nose"}


def frame(earth: bool) -> str:
    """Say where angles count from: north when the attitude of the base is known, else the payload's own nose."""
    return FRAMES[earth]


def rounded(degrees: float, digits: int = 1) -> float:
    """Round a direction [deg] into [0, 360): what rounds up to a whole turn is 0.

    >>> rounded(-0.02), rounded(359.96), rounded(-80.04)
    (0.0, 0.0, 280.0)
    """
    return round(degrees % 360.0, digits) % 360.0


def bearing(angle: float, digits: int = 1) -> str:
    """Write a heading or azimuth [rad, counter-clockwise] in degrees of a compass, without the unit.

    >>> bearing(math.radians(-80)), bearing(math.radians(40), digits=0)
    ('80.0', '320')
    """
    return f"{rounded(compass(angle), digits):.{digits}f}"


def bearings(angles: Iterable[float], *, earth: bool, digits: int = 1) -> str:
    """Write some headings or azimuths [rad, counter-clockwise] and what they count from; none: nothing.

    >>> bearings([math.radians(-80), math.radians(40)], earth=False)
    '80.0, 320.0 deg from the nose'
    """
    listed = ", ".join(bearing(angle, digits) for angle in angles)
    return f"{listed} deg {frame(earth)}" if listed else ""


def rotation(angle: float, digits: int = 1) -> str:
    """Write a rotation or a joint angle [rad, counter-clockwise is positive] with its sense.

    >>> rotation(math.radians(12.0)), rotation(math.radians(-3.5)), rotation(0.0)
    ('12.0 deg counter-clockwise', '3.5 deg clockwise', '0.0 deg')
    """
    text = f"{abs(math.degrees(angle)):.{digits}f}"
    sense = "" if not float(text) else " counter-clockwise" if angle > 0 else " clockwise"
    return f"{text} deg{sense}"
