"""Rows as Parquet; needs the extra ``study``."""

from __future__ import annotations

import dataclasses
import typing
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

PLAIN = {str: pa.string(), int: pa.int64(), float: pa.float64(), bool: pa.bool_()}


def schema(kind: type[Any]) -> Any:
    """Columns and their types, from the fields of a kind of row."""
    hints = typing.get_type_hints(kind)
    return pa.schema([(field.name, _type(hints[field.name])) for field in dataclasses.fields(kind)])


def _type(hint: Any) -> Any:
    if hint in PLAIN:
        return PLAIN[hint]
    first = typing.get_args(hint)[0]
    return pa.list_(PLAIN[first]) if typing.get_origin(hint) is tuple else PLAIN[first]


def write(path: Path, rows: Sequence[Any], kind: type[Any]) -> None:
    """Write one file."""
    table = pa.Table.from_pylist([dataclasses.asdict(row) for row in rows], schema=schema(kind))
    pq.write_table(table, path)
