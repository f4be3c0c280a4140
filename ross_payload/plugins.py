"""Plug-ins are entry points, built-ins included: only the one asked for is imported."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from ross_payload.errors import PluginError, unknown
from ross_payload.extras import EXTRA_OF, install_line


def available(group: str) -> Mapping[str, EntryPoint]:
    """Return the entry points of a group by name, sorted; nothing is imported."""
    return _along(group, tuple(sys.path))


@cache
def _along(group: str, path: tuple[str, ...]) -> Mapping[str, EntryPoint]:
    """Ask every package along a path, which takes several milliseconds."""
    return {point.name: point for point in sorted(entry_points(group=group), key=lambda point: point.name)}


def load(group: str, name: str) -> Any:
    """Import one plug-in.

    Raises
    ------
    PluginError
        When the name is unknown (lists those that exist), a dependency is missing (names the extra) or the plug-in
        is broken (says how).
    """
    points = available(group)
    if name not in points:
        kind = group.rpartition(".")[2].removesuffix("s").replace("_", " ")
        raise PluginError(unknown(kind, name, points))
    try:
        return points[name].load()
    except ModuleNotFoundError as error:
        raise PluginError(_missing(name, error)) from error
    except Exception as error:  # a broken plug-in must not take the others with it
        raise PluginError(f"plug-in '{name}' ({points[name].value}) is broken: {error!r}") from error


def _missing(name: str, error: ModuleNotFoundError) -> str:
    module = (error.name or "").partition(".")[0]
    if module in EXTRA_OF:
        return f"'{name}' needs the package {module}: {install_line(EXTRA_OF[module])}"
    return f"plug-in '{name}' cannot be imported: {error}"
