"""Averages over neighbouring bins."""

from __future__ import annotations

import numpy as np

from ross_payload.interfaces import Real


def average(values: Real) -> Real:
    """3 x 3 average over frequency (first axis) and time (last axis); edges are repeated.

    >>> average(np.array([[0.0, 9, 0], [0, 0, 0], [0, 0, 0]])).tolist()
    [[2.0, 2.0, 2.0], [1.0, 1.0, 1.0], [0.0, 0.0, 0.0]]
    """
    return averaged_rows(values, 0, len(values))


def averaged_rows(values: Real, low: int, high: int) -> Real:
    """The rows ``low`` to ``high`` of `average`, without the work on the others.

    >>> averaged_rows(np.array([[0.0, 9, 0], [0, 0, 0], [0, 0, 0]]), 1, 3).tolist()
    [[1.0, 1.0, 1.0], [0.0, 0.0, 0.0]]
    """
    high = min(high, len(values))
    first, last = max(low - 1, 0), min(high + 1, len(values))
    padded = values[first:last]
    if low == 0 or high == len(values):
        padded = padded[np.clip(np.arange(low - 1, high + 1), 0, len(values) - 1) - first]
    rows = padded[1:-1] + padded[:-2]
    rows += padded[2:]
    rows *= values.dtype.type(1 / 9)
    result: Real = rows.copy()
    summed, given = result.reshape(-1), rows.reshape(-1)  # one long loop: what crosses an edge is put right below
    summed[1:] += given[:-1]
    summed[:-1] += given[1:]
    n = rows.shape[-1]
    if not n:
        return result
    for edge, inner in ((0, min(1, n - 1)), (n - 1, max(n - 2, 0))):
        result[..., edge] = rows[..., edge] + rows[..., inner] + rows[..., edge]
    return result
