"""Which of some go with which of others, when everybody goes with one at most."""

from __future__ import annotations

from collections.abc import Sequence


def marginals(weights: Sequence[Sequence[float]], alone: float) -> list[list[float]]:
    """Return the probability of every pair, over all assignments in which nobody is used twice.

    The weight of an assignment is the product of those of its pairs, and of ``alone`` for each row or column that is
    left over. Sums over assignments are done column by column over the sets of rows that are taken: 2^n of them.

    >>> [[round(share, 3) for share in row] for row in marginals([[1.0, 1.0], [1.0, 1.0]], alone=0.0)]
    [[0.5, 0.5], [0.5, 0.5]]
    >>> [[round(share, 3) for share in row] for row in marginals([[1.0, 0.5], [1.0, 0.0]], alone=0.0)]
    [[0.0, 1.0], [1.0, 0.0]]
    """
    rows, columns = len(weights), len(weights[0]) if weights else 0
    full = 1 << rows
    before = [_start(full)]  # weight of the columns so far, by the rows that they take
    for column in range(columns):
        before.append(_with(before[-1], weights, column, alone))
    after = [[alone ** (rows - taken.bit_count()) for taken in range(full)]]  # weight of the columns to come
    for column in reversed(range(columns)):
        after.insert(0, _without(after[0], weights, column, alone))
    total = after[0][0] if columns else 0.0
    return [
        [
            _worth(row, before[column], after[column + 1]) * weights[row][column] / (total or 1.0)
            for column in range(columns)
        ]
        for row in range(rows)
    ]


def _start(full: int) -> list[float]:
    return [1.0, *[0.0] * (full - 1)]


def _with(before: list[float], weights: Sequence[Sequence[float]], column: int, alone: float) -> list[float]:
    reached = [weight * alone for weight in before]
    for taken, weight in enumerate(before):
        for row in _free(taken, weights) if weight else ():
            reached[taken | 1 << row] += weight * weights[row][column]
    return reached


def _without(after: list[float], weights: Sequence[Sequence[float]], column: int, alone: float) -> list[float]:
    return [
        after[taken] * alone + sum(weights[row][column] * after[taken | 1 << row] for row in _free(taken, weights))
        for taken in range(len(after))
    ]


def _worth(row: int, before: list[float], after: list[float]) -> float:
    """Return the weight of all assignments around one pair."""
    return sum(before[taken] * after[taken | 1 << row] for taken in range(len(after)) if not taken >> row & 1)


def _free(taken: int, weights: Sequence[Sequence[float]]) -> list[int]:
    return [row for row in range(len(weights)) if not taken >> row & 1]
