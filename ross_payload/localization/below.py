"""What the height of the array says of talkers on the ground: how steeply below it they are, and so their delays.

A talker at elevation epsilon has the TDOA ``(d / v_p) cos(epsilon) cos(azimuth - heading)``: over the headings it
swings by an amplitude ``a = cos(epsilon)``. Nobody tells how far away somebody stands, so a is measured for every
source; the height h above the mouths bounds it. A talker further away than `FARTHEST` is not heard, so that
``sin(epsilon) >= h / FARTHEST``, and the distance along the ground is ``h / tan(epsilon)``.

Up there the walls are far: delays are short because talkers are below and not because a room reflects.
"""

from __future__ import annotations

import math

FARTHEST = 60.0  # somebody who is still heard [m]
AIRBORNE = 2.0  # above the mouths; lower, talkers may be about as high as the array [m]
STEEPEST = math.radians(87.0)  # below this, elevations have no azimuth
ALIKE = 2.0  # counts by which amplitudes are drawn to each other: people stand at different distances


def amplitudes(height: float) -> tuple[float, float]:
    """Least and greatest amplitude of somebody on the ground ``height`` [m] below.

    >>> [round(each, 3) for each in amplitudes(20.0)]
    [0.052, 0.943]
    """
    least = math.cos(STEEPEST)
    return least, max(math.sqrt(max(1 - (height / FARTHEST) ** 2, 0.0)), 2 * least)


def elevation(amplitude: float, sigma: float) -> tuple[float, float]:
    """Elevation [rad] of a source by its amplitude, negative, and one standard deviation by that of the amplitude.

    Where the amplitude is near 1 its slope is steep: the deviation is that to an amplitude smaller by ``sigma``.

    >>> [round(math.degrees(each), 2) for each in elevation(0.5, 0.01)]
    [-60.0, 0.66]
    """
    angle = math.acos(min(max(amplitude, 0.0), 1.0))
    return -angle, max(math.acos(max(amplitude - sigma, 0.0)) - angle, 1e-3)
