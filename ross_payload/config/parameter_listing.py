"""Every key that is in force, with its origin, as a TOML file that could be read again."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from ross_payload.bounded_files import printable
from ross_payload.config import Config, Table
from ross_payload.config.parameter_persistence import StoredValue, Unusable, read
from ross_payload.config.parameter_store import Check, Origin, any_serves, recall
from ross_payload.config.parameter_table import TABLE

WIDTH = 40  # of key and value, in front of the origin


def listing(config: Config, path: Path, check: Check = any_serves) -> Iterator[str]:
    """Give the lines: what the file of a configuration says, the defaults, and what ``path`` keeps; it is only read.

    ``check`` refuses what is kept as `Parameters` does.
    """
    kept, notes = _looked_at(path)
    in_force, held, more = recall(config, kept, check)
    yield from (f"# {printable(note)}" for note in [*notes, *more])
    origins = {TABLE[name].place: f"{Origin.IN_FLIGHT}, instead of {entry.replaced:g}" for name, entry in held.items()}
    values = {name: getattr(in_force, name) for name in Config.model_fields}
    yield from _plain(config, {name: value for name, value in values.items() if not isinstance(value, (Table, tuple))})
    for name, value in values.items():
        if isinstance(value, Table):
            own = {key: origin for (table, key), origin in origins.items() if table == name}
            plain = {key: each for key, each in value if not _is_rows(each)}
            yield from ("", f"[{name}]", *_plain(getattr(config, name), plain, own))
            for key, each in value:
                yield from _rows(f"{name}.{key}", each)
        else:
            yield from _rows(name, value)


def _is_rows(value: Any) -> bool:
    """Whether a value is an array of tables that has any."""
    return isinstance(value, tuple) and any(isinstance(row, Table) for row in value)


def _rows(name: str, value: Any) -> Iterator[str]:
    """Give the lines of an array of tables; none of anything else."""
    for row in value if _is_rows(value) else ():
        yield from ("", f"[[{name}]]", *_plain(row, dict(row)))


def _looked_at(path: Path) -> tuple[dict[str, StoredValue], list[str]]:
    try:
        return read(path), []
    except Unusable as unusable:
        return {}, [str(unusable)]


def _plain(options: Table, values: Mapping[str, Any], in_flight: Mapping[str, str] | None = None) -> Iterator[str]:
    """Give the lines of one table; ``options`` is what the file says."""
    for key, value in values.items():
        origin = Origin.FILE if key in options.model_fields_set else Origin.DEFAULT
        line = f"# {key} is absent" if value is None else f"{key} = {toml(value)}"
        yield f"{line:<{WIDTH}} # {(in_flight or {}).get(key, origin)}"


def toml(value: Any) -> str:
    """Return a value as TOML.

    >>> print(toml({"port": "can0", "ids": (1, 2), "wrap": True}))
    { port = "can0", ids = [1, 2], wrap = true }
    """
    if isinstance(value, Mapping):
        pairs = ", ".join(f"{k if _is_bare(k) else _quoted(k)} = {toml(v)}" for k, v in value.items())
        return f"{{ {pairs} }}" if pairs else "{}"
    if isinstance(value, (tuple, list)):
        return f"[{', '.join(map(toml, value))}]"
    return _quoted(value) if isinstance(value, (str, bool)) else repr(value)


def _quoted(value: str | bool) -> str:
    """Return a text as TOML, with nothing in it that a terminal obeys."""
    text = json.dumps(value, ensure_ascii=False)
    return "".join(each if each.isprintable() else f"\\U{ord(each):08x}" for each in text)


def _is_bare(key: str) -> bool:
    return key.isascii() and key.isidentifier()
