"""Where a source is, as a delay and as a steering vector; sources that pose as one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ross_payload.errors import ConfigError
from ross_payload.interfaces import Complex, Real, Scene

ALIAS = 0.1  # TDOAs closer than this part of d / v_p are one source to the array


def tdoa(
    azimuth: ArrayLike, heading: ArrayLike, spacing: float, speed_of_sound: float, elevation: ArrayLike = 0.0
) -> Real:
    """TDOA [s] of plane waves: tau = (d / v_p) cos(elevation) cos(azimuth - heading), > 0 when microphone 2 leads.

    Parameters
    ----------
    azimuth, heading, elevation
        [rad], counter-clockwise, broadcast together.
    spacing
        d [m].
    speed_of_sound
        v_p [m/s].

    Examples
    --------
    A source on the axis, on the side of microphone 2, 34.3 cm of spacing:

    >>> float(tdoa(0.5, 0.5, 0.343, 343.0))
    0.001
    """
    angle = np.asarray(azimuth) - np.asarray(heading)
    return np.asarray(spacing / speed_of_sound * np.cos(elevation) * np.cos(angle))


def steering_vectors(frequencies: Real, tau: ArrayLike) -> Complex:
    """Steering vectors a(f) = [1, exp(j 2 pi f tau)] relative to microphone 1, (n_freqs, 2, n_sources).

    >>> steering_vectors(np.array([1000.0]), [0.25e-3]).round(6).ravel().tolist()
    [(1+0j), 1j]
    """
    phase = 2j * np.pi * frequencies[:, None] * np.atleast_1d(np.asarray(tau, float))
    return np.stack([np.ones_like(phase), np.exp(phase)], axis=1)


def groups_of(tau: ArrayLike, tolerance: float) -> tuple[tuple[int, ...], ...]:
    """Group the sources whose TDOAs [s] lie within ``tolerance`` [s] of the next one: to the array they are one.

    Members are in rising order; groups are in the order of their first member.

    >>> groups_of([1e-4, -5e-5, 0.99e-4], tolerance=1e-5)
    ((0, 2), (1,))
    """
    values = np.atleast_1d(np.asarray(tau, float))
    if not values.size:
        return ()
    order = np.argsort(values, kind="stable")
    cuts = np.flatnonzero(np.diff(values[order]) > tolerance) + 1
    return tuple(sorted(tuple(sorted(int(i) for i in part)) for part in np.split(order, cuts)))


def directions_of(scene: Scene, who: str) -> tuple[tuple[tuple[int, ...], ...], Real]:
    """Members of every group of sources that pose as one, and the mean TDOA [s] of each, (n_groups,).

    Raises
    ------
    ConfigError
        When the scene has no TDOAs; ``who`` needs them.
    """
    if scene.tau is None:
        raise ConfigError(f"{who}: expected the TDOA of every source, got none")
    tau = np.asarray(scene.tau, float)
    members = groups_of(tau, ALIAS * scene.spacing / scene.speed_of_sound)
    return members, delays_of(members, tau)


def delays_of(members: Sequence[tuple[int, ...]], tau: Real) -> Real:
    """Mean TDOA [s] of every group, (n_groups,)."""
    return np.array([tau[list(group)].mean() for group in members])
