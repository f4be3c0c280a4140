"""Where a talker walks: a broken line of azimuth, distance and height over time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from ross_payload.errors import ConfigError
from ross_payload.interfaces import Real

LONGEST = 10_000.0  # [m]
GRID = 0.02  # walked between two neighbours of the grid, at most [m]: a reflection shifts by 90 deg of phase at 4.3 kHz


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """A walk, linear in time between way points in polar coordinates; at rest before the first and after the last.

    Positions of a *grid* lie at most 2 cm apart along the walk, evenly between neighbouring way points. `grid_place`
    tells where on it the talker is, as a broken number: 3.25 is a quarter of the way from node 3 to node 4.

    Parameters
    ----------
    times
        Of the way points [s], rising, (n,).
    azimuths
        [rad], counter-clockwise, not wrapped: a walk of two turns is 4 pi long, (n,).
    distances
        From the centre of the array, along the floor [m], (n,).
    heights
        Above the floor [m], (n,); 0 in a plane.

    Examples
    --------
    A tenth of a radian in two seconds at 1 m is five steps of 2 cm:

    >>> walk = Path.through([(1.0, 0.0, 1.0, 0.0), (3.0, 0.1, 1.0, 0.0)])
    >>> walk.place(2.0).round(3).tolist()
    [0.05, 1.0, 0.0]
    >>> walk.grid_place([0.0, 1.8, 9.0]).round(3).tolist()
    [0.0, 2.0, 5.0]
    >>> walk.node(2).round(3).tolist()
    [0.04, 1.0, 0.0]
    """

    times: Real
    azimuths: Real
    distances: Real
    heights: Real
    nodes: Real  # of every way point on the grid, (n,)

    @classmethod
    def through(cls, points: ArrayLike) -> Self:
        """Make one through way points (time [s], azimuth [rad], distance [m], height [m]), (n, 4).

        Raises
        ------
        ConfigError
            When it is longer than `LONGEST`.
        """
        times, azimuths, distances, heights = np.asarray(points, dtype=float).reshape(-1, 4).T
        wider = np.maximum(distances[1:], distances[:-1])
        steps = [np.diff(azimuths) * wider, np.diff(distances), np.diff(heights)]
        with np.errstate(over="ignore"):
            counts = np.maximum(np.ceil(np.linalg.norm(steps, axis=0) / GRID - 1e-9), 0)
        if not counts.sum() <= LONGEST / GRID:
            raise ConfigError(f"talkers.path: expected a way of at most {LONGEST:g} m, got a longer one")
        return cls(times, azimuths, distances, heights, np.concatenate([[0.0], np.cumsum(counts)]))

    @property
    def moves(self) -> bool:
        """Whether the talker ever leaves its first place."""
        return bool(self.nodes[-1] > 0)

    @property
    def n_nodes(self) -> int:
        """Positions on the grid."""
        return int(self.nodes[-1]) + 1

    def place(self, time: ArrayLike) -> Real:
        """Azimuth [rad], distance [m] and height [m] at times [s], (..., 3)."""
        at = np.asarray(time, dtype=float)
        values = (self.azimuths, self.distances, self.heights)
        return np.stack([np.interp(at, self.times, value) for value in values], axis=-1)

    def grid_place(self, time: ArrayLike) -> Real:
        """Place on the grid at times [s], (...)."""
        return np.asarray(np.interp(np.asarray(time, dtype=float), self.times, self.nodes))

    def node(self, number: ArrayLike) -> Real:
        """Azimuth [rad], distance [m] and height [m] of positions of the grid, (..., 3)."""
        numbers, last = np.asarray(number, dtype=float), len(self.nodes) - 1
        after = np.maximum(np.searchsorted(self.nodes, numbers), 1)  # the way point at, or next after, the node
        begin, end = self.nodes[after - 1], self.nodes[np.minimum(after, last)]
        share = np.where(end == begin, 0.0, (numbers - begin) / np.where(end == begin, 1.0, end - begin))
        first, second = self.place(self.times[after - 1]), self.place(self.times[np.minimum(after, last)])
        return np.asarray(first + share[..., None] * (second - first))
