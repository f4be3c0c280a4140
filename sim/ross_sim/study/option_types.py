"""Values of the options of studies."""

from __future__ import annotations

from typing import Any
from urllib.parse import urlsplit

import click

SCHEMES = {"dask": "tcp", "dask+tls": "tls"}  # of the address of a scheduler, and what Dask calls them


class CommaSeparated(click.ParamType[Any]):
    """Values separated by commas."""

    name = "A,B,..."

    def __init__(self, kind: Any = str) -> None:
        self._kind = kind

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Split and convert."""
        parts = [part.strip() for part in str(value).split(",") if part.strip()]
        try:
            return tuple(self._kind(part) for part in parts)
        except ValueError:
            return self.fail(f"'{value}' is not a list of {self._kind.__name__} separated by commas", param, ctx)


class ShardNumber(click.ParamType[Any]):
    """One of several shares: 2/5."""

    name = "I/N"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Read number and count."""
        from ross_sim.study.study_design import Shard  # noqa: PLC0415  takes a second

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
