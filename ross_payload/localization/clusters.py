"""K-means of directions: the exact optimum on the circle, and K by inertia.

Points on a line have their optimal clusters in order, so dynamic programming finds the global optimum for every K at
once (Wang and Song 2011): no random start, the same result every time. The circle is cut at its widest gap first.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ross_payload.interfaces import Real


@dataclass(frozen=True, slots=True)
class Cluster:
    """Directions that belong together."""

    mean: float  # [rad], not wrapped
    spread: float  # weighted standard deviation [rad]
    weight: float  # sum of the weights
    members: tuple[int, ...]  # indices of the directions


def unwrapped(angles: Real) -> tuple[Real, np.ndarray[tuple[int], np.dtype[np.intp]]]:
    """Angles [rad] in ascending order from the far side of the widest gap on, and where each was, both (n,).

    >>> np.rad2deg(unwrapped(np.deg2rad([170.0, -170.0, 160.0]))[0]).round(6).tolist()
    [160.0, 170.0, 190.0]
    """
    turned = np.mod(angles, 2 * np.pi)
    order = np.argsort(turned, kind="stable")
    gaps = np.diff(turned[order], append=turned[order[0]] + 2 * np.pi)
    first = (int(gaps.argmax()) + 1) % len(order)
    order = np.roll(order, -first)
    line = turned[order]
    return np.where(line < line[0], line + 2 * np.pi, line), order


def best_cuts(line: Real, weights: Real, most: int) -> tuple[Real, list[list[int]]]:
    """Least inertia [rad^2] of 1 .. ``most`` clusters of a sorted line, and where each cluster of each begins.

    Inertia is the weighted sum of squared distances to the cluster means.

    >>> inertia, starts = best_cuts(np.array([0.0, 1.0, 5.0]), np.ones(3), 3)
    >>> inertia.round(6).tolist(), starts
    ([14.0, 0.5, 0.0], [[0], [0, 2], [0, 1, 2]])
    """
    n = len(line)
    inertia = _inertias(line, weights)
    best, begins = inertia[0], []
    least, found = [best[-1]], [[0]]
    for k in range(1, min(most, n)):
        ways = np.full((n, n), np.inf)  # [begin of the last cluster, end]
        ways[k:] = best[k - 1 : n - 1, None] + inertia[k:]
        begins.append(ways.argmin(axis=0))
        best = ways.min(axis=0)
        least.append(best[-1])
        found.append(_trace(begins, n))
    return np.array(least), found


def k_means(angles: Real, weights: Real, penalty: float, most: int) -> list[Cluster]:
    """Clusters of directions [rad], with the K that minimises inertia + ``penalty`` K, in ascending order.

    ``penalty`` [rad^2, times weight] is the inertia that one more cluster must save.

    >>> found = k_means(np.deg2rad([179.0, -179.0, 10.0]), np.ones(3), 0.01, 5)
    >>> [round(float(np.rad2deg(cluster.mean))) % 360 for cluster in found]
    [10, 180]
    """
    if not len(angles):
        return []
    line, order = unwrapped(angles)
    inertia, starts = best_cuts(line, weights[order], most)
    chosen = starts[int((inertia + penalty * np.arange(1, len(inertia) + 1)).argmin())]
    ends = [*chosen[1:], len(line)]
    return [_cluster(line, weights[order], order, a, b) for a, b in zip(chosen, ends, strict=True)]


def _inertias(line: Real, weights: Real) -> Real:
    """Inertia of one cluster from every begin to every end, (n, n); infinite where it ends before it begins."""
    centred = line - line.mean()
    mass, first, second = (np.concatenate([[0.0], np.cumsum(weights * centred**power)]) for power in range(3))
    m, f, s = (total[None, 1:] - total[:-1, None] for total in (mass, first, second))
    ordered = np.tri(len(line), dtype=bool).T
    return np.where(ordered, np.maximum(s - f**2 / np.where(ordered, m, 1.0), 0), np.inf)


def _trace(begins: list[Real], n: int) -> list[int]:
    """Begin of every cluster, followed back from the last."""
    cuts, end = [], n - 1
    for begin in reversed(begins):
        cuts.append(int(begin[end]))
        end = cuts[-1] - 1
    return [0, *reversed(cuts)]


def _cluster(
    line: Real, weights: Real, order: np.ndarray[tuple[int], np.dtype[np.intp]], begin: int, end: int
) -> Cluster:
    angles, weight = line[begin:end], weights[begin:end]
    mean = float(np.average(angles, weights=weight))
    spread = float(np.sqrt(np.average((angles - mean) ** 2, weights=weight)))
    return Cluster(mean, spread, float(weight.sum()), tuple(int(i) for i in order[begin:end]))
