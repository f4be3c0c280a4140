"""Angles: wrapping, axes (modulo pi) and circular means. Radians, counter-clockwise, as in the paper."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Real = NDArray[np.floating[Any]]


def wrap(angle: float) -> float:
    """Wrap an angle [rad] into (-pi, pi].

    >>> round(wrap(4.0), 6)
    -2.283185
    >>> wrap(-np.pi) == np.pi
    True
    """
    wrapped = (angle + np.pi) % (2 * np.pi) - np.pi
    return float(np.pi if wrapped == -np.pi else wrapped)


def wrap_axis(angle: float) -> float:
    """Wrap an axis [rad], a heading modulo pi, into (-pi/2, pi/2]: two microphones have no front.

    >>> round(wrap_axis(3.0), 6)
    -0.141593
    """
    return wrap(2 * angle) / 2


def difference(angle: ArrayLike, other: ArrayLike) -> Real:
    """Signed difference ``angle - other`` [rad], wrapped into [-pi, pi), with broadcasting.

    >>> float(np.rad2deg(difference(np.deg2rad(170), np.deg2rad(-170))).round(6))
    -20.0
    """
    return np.asarray((np.asarray(angle) - np.asarray(other) + np.pi) % (2 * np.pi) - np.pi)


def circular_mean(angles: ArrayLike) -> float:
    """Mean direction [rad] of angles [rad].

    >>> round(float(np.rad2deg(circular_mean(np.deg2rad([170, -150])))), 6)
    -170.0
    """
    return float(np.angle(np.mean(np.exp(1j * np.asarray(angles)))))
