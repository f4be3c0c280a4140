"""Numbers as options of the command line: neither NaN, which no range of click refuses, nor infinity, unless told."""

from __future__ import annotations

import math
from typing import Any

import click


class Number(click.types.FloatParamType):
    """A finite number."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Read it, or refuse it."""
        number = float(super().convert(value, param, ctx))
        return number if math.isfinite(number) else self.fail(f"expected a finite number, got {number}", param, ctx)


class NumberRange(click.FloatRange):
    """A finite number within limits; if ``infinite`` and they allow it, infinity too, for what never ends."""

    def __init__(
        self, least: float, most: float | None = None, *, min_open: bool = False, infinite: bool = False
    ) -> None:
        super().__init__(least, most, min_open=min_open)
        self._infinite = infinite

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Read it, or refuse it."""
        number = float(super().convert(value, param, ctx))
        if math.isfinite(number) or (self._infinite and math.isinf(number)):
            return number
        return self.fail(f"expected a {'' if self._infinite else 'finite '}number, got {number}", param, ctx)
