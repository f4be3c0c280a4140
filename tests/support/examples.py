"""How many random examples a test draws: a tenth in `make test`, always the same; all, and others, in `make soak`."""

from __future__ import annotations

import pytest
from hypothesis import settings

TEST, SOAK = "test", "soak"  # profiles; pytest's --hypothesis-profile chooses another than the first

settings.register_profile(TEST, deadline=None, derandomize=True, max_examples=10)
settings.register_profile(SOAK, deadline=None, max_examples=100)  # a busy machine makes no example wrong


def examples(full: int) -> int:
    """The examples of a test that looks at ``full`` of them in `make soak`, at least 2."""
    return max(2, full * settings.default.max_examples // 100)


def in_soak(*values: object) -> list[object]:
    """More values of a parameter, which only `make soak` looks at."""
    return [pytest.param(value, marks=pytest.mark.soak) for value in values]


def rows_in_soak(*rows: tuple[object, ...]) -> list[object]:
    """More rows of several parameters, which only `make soak` looks at."""
    return [pytest.param(*row, marks=pytest.mark.soak) for row in rows]
