"""Intervals in which a rate or a mean lies with 95 % confidence."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.special import bdtr, stdtrit

LEVEL = 0.95
Z = 1.959964  # two-sided, 95 %


def wilson(successes: int, n: int) -> tuple[float, float]:
    """The score interval of a rate (Wilson 1927), which stays inside [0, 1]; all of it when nothing was tried.

    >>> tuple(round(end, 3) for end in wilson(9, 10))
    (0.596, 0.982)
    >>> wilson(0, 0)
    (0.0, 1.0)
    """
    if not n:
        return 0.0, 1.0
    rate, weight = successes / n, Z**2 / n
    middle = (rate + weight / 2) / (1 + weight)
    half = Z * math.sqrt(rate * (1 - rate) / n + weight / (4 * n)) / (1 + weight)
    return max(middle - half, 0.0), min(middle + half, 1.0)


def half_width(values: Sequence[float]) -> float:
    """Half the width of the interval of a mean by Student's t; not a number for less than two values.

    >>> round(half_width([1.0, 2.0, 3.0]), 3)
    2.484
    """
    n = len(values)
    if n < 2:
        return math.nan
    return float(stdtrit(n - 1, 0.975) * np.std(values, ddof=1) / math.sqrt(n))


def rate_cell(successes: int, n: int) -> str:
    """A rate and its interval as a cell of a table.

    >>> rate_cell(9, 10), rate_cell(0, 0)
    ('9/10 (60-98 %)', '-')
    """
    if not n:
        return "-"
    low, high = wilson(successes, n)
    return f"{successes}/{n} ({100 * low:.0f}-{100 * high:.0f} %)"


def mean_cell(values: Sequence[float], digits: int = 1) -> str:
    """A mean and half the width of its interval as a cell of a table.

    >>> mean_cell([1.0, 2.0, 3.0]), mean_cell([4.0]), mean_cell([])
    ('2.0 ± 2.5', '4.0', '-')
    """
    if not len(values):
        return "-"
    half = half_width(values)
    return f"{np.mean(values):.{digits}f}" + ("" if math.isnan(half) else f" ± {half:.{digits}f}")


def median_interval(values: Sequence[float]) -> tuple[float, float]:
    """The values between which a median lies by the binomial distribution of ranks; without end where they are few.

    >>> median_interval(list(range(1, 11)))
    (2, 9)
    >>> median_interval([1.0, 2.0])
    (-inf, inf)
    """
    ordered, n = sorted(values), len(values)
    below = [rank for rank in range(n // 2) if bdtr(rank, n, 0.5) <= (1 - LEVEL) / 2]
    return (ordered[len(below) - 1], ordered[-len(below)]) if below else (-math.inf, math.inf)


def median_cell(values: Sequence[float]) -> str:
    """A median and its interval as a cell of a table.

    >>> median_cell(list(range(1, 11))), median_cell([1.0, 2.0]), median_cell([])
    ('5.5 (2.0-9.0)', '1.5', '-')
    """
    if not len(values):
        return "-"
    low, high = median_interval(values)
    return f"{np.median(values):.1f}" + ("" if math.isinf(low) else f" ({low:.1f}-{high:.1f})")
