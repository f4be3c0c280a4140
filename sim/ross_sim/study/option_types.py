"""Values of the options of studies."""

from __future__ import annotations

import math
from argparse import ArgumentTypeError
from collections.abc import Callable
from typing import Any
from urllib.parse import urlsplit

import click

SCHEMES = {"dask": "tcp", "dask+tls": "tls"}  # of the address of a scheduler, and what Dask calls them
WORDS: dict[Any, str] = {str: "names", int: "whole numbers", float: "finite numbers"}  # for a kind of values


class CommaSeparated(click.ParamType[Any]):
    """Values separated by commas, each once.

    Parameters
    ----------
    kind
        Makes a value of its text; raises ValueError when that is none.
    what
        Says what the values are; default: as ``kind`` and limits tell.
    low, high
        Least and largest number; all must be finite.
    empty
        Whether there may be none.
    """

    name = "A,B,..."

    def __init__(
        self, kind: Any = str, what: str = "", *, low: float = -math.inf, high: float = math.inf, empty: bool = False
    ) -> None:
        self._kind, self._low, self._high, self._empty = kind, low, high, empty
        limits = ""
        if math.isfinite(low):
            limits = f" from {low:g} to {high:g}" if math.isfinite(high) else f" of at least {low:g}"
        self._what = what or f"{WORDS[kind]}{limits}"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Split and convert."""
        parts = [part.strip() for part in str(value).split(",") if part.strip()]
        try:
            found = tuple(map(self._value, parts))
        except UnicodeEncodeError:
            return self.fail(f"expected {self._what} in UTF-8, as the results are, got '{value}'", param, ctx)
        except ValueError:
            return self.fail(f"expected {self._what} separated by commas, got '{value}'", param, ctx)
        if not found and not self._empty:
            return self.fail(f"expected {self._what} separated by commas, got none", param, ctx)
        twice = next((part for part, each in zip(parts, found, strict=True) if found.count(each) > 1), None)
        if twice is not None:
            return self.fail(f"expected every value once, got '{twice}' more than once", param, ctx)
        return found

    def _value(self, part: str) -> Any:
        part.encode()  # a file name in another encoding
        value = self._kind(part)
        if isinstance(value, int | float) and not (self._low <= value <= self._high and abs(value) < math.inf):
            raise ValueError(part)
        return value


NATURAL, POSITIVE = click.IntRange(min=0), click.IntRange(min=1)


def argument(kind: click.ParamType[Any]) -> Callable[[str], Any]:
    """Make the ``type`` of an argument of `argparse` that reads, and refuses in the same words, what click does.

    >>> argument(NATURAL)("7")
    7
    """

    def read(text: str) -> Any:
        try:
            return kind.convert(text, None, None)
        except click.UsageError as error:
            raise ArgumentTypeError(error.message) from error

    return read


class ShardNumber(click.ParamType[Any]):
    """One of several shares: 2/5."""

    name = "I/N"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Read number and count."""
        from ross_sim.study.runs.study_design import Shard  # noqa: PLC0415  takes a second

        number, _, of = str(value).partition("/")
        if not (number.isdecimal() and of.isdecimal() and 1 <= int(number) <= int(of)):
            return self.fail(f"expected I/N with I from 1 to N, got '{value}'", param, ctx)
        return Shard(int(number), int(of))


class EngineName(click.ParamType[Any]):
    """Who does the tasks: processes, dask, or the scheduler of a cluster."""

    name = "processes|dask|dask://HOST:PORT"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Give what there is to know but the number of workers."""
        if value in ("processes", "dask"):
            return {"dask": value == "dask"}
        scheme, _, rest = str(value).partition("://")
        try:
            there = urlsplit(f"//{rest}")
            if scheme in SCHEMES and there.hostname and there.port and there.netloc == rest:
                return {"dask": True, "scheduler": f"{SCHEMES[scheme]}://{rest}"}
        except ValueError:  # a port that is none
            pass
        return self.fail(f"expected {self.name} (or dask+tls://HOST:PORT), got '{value}'", param, ctx)
