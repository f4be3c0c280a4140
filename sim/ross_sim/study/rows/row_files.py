"""Rows of a study as files: CSV, and Parquet where its package is installed."""

from __future__ import annotations

import csv
import io
import os
import types
import typing
from collections.abc import Iterable, Sequence
from dataclasses import asdict, fields
from importlib.util import find_spec
from itertools import islice
from pathlib import Path
from typing import Any, TextIO

from ross_payload.bounded_files import open_regular
from ross_payload.errors import ConfigError, shown
from ross_payload.plugins import install_line
from ross_sim.study.rows.result_rows import columns

BATCH = 10_000  # rows that are plain values at a time, on the way into a Parquet file


def as_csv(rows: Iterable[Any], kind: type[Any]) -> bytes:
    """Rows as CSV; lists are separated by spaces, and what is not known is empty."""
    text = io.StringIO()
    write_csv(text, rows, kind)
    return text.getvalue().encode()


def write_csv(file: TextIO, rows: Iterable[Any], kind: type[Any]) -> None:
    """Write rows as CSV, one after the other; see `as_csv`."""
    writer, names = csv.writer(file, lineterminator="\n"), columns(kind)
    writer.writerow(names)
    writer.writerows([_cell(getattr(row, name)) for name in names] for row in rows)


def _cell(value: Any) -> str:
    if isinstance(value, tuple):
        return " ".join(map(_cell, value))
    if isinstance(value, bool):
        return str(value).lower()
    return "" if value is None else str(value)


def read_rows(path: Path, kinds: Sequence[type[Any]]) -> tuple[type[Any], list[Any]]:
    """Read rows of one of these kinds, which the columns tell: CSV as `as_csv` writes it, or Parquet.

    Raises
    ------
    ConfigError
        When it cannot be read, or is something else.
    """
    try:
        os.close(open_regular(path))  # neither waits for a named pipe nor reads a device without end
        if path.suffix == ".parquet":
            names, lines = _parquet(path)
        else:
            names, lines = csv_lines(path)
        kind = next((kind for kind in kinds if columns(kind) == names), None)
        if kind is None:
            raise ConfigError(f"{path}: expected the rows of a study, got columns {', '.join(names[:4]) or 'none'} ...")
        hints = typing.get_type_hints(kind)
        return kind, [kind(**{name: _value(hints[name], line[name]) for name in names}) for line in lines]
    except UnicodeError as error:
        raise ConfigError(f"{path}: expected the rows of a study, got no UTF-8 text") from error
    except (OSError, ValueError, TypeError) as error:
        why = error.strerror if isinstance(error, OSError) and error.strerror else error
        raise ConfigError(f"{path}: expected the rows of a study: {why}") from error


def csv_lines(path: Path) -> tuple[tuple[str, ...], list[dict[str, str]]]:
    """Names of the columns of a CSV file, and its cells by name, one mapping for every row.

    Raises
    ------
    ConfigError
        When a column is there twice, or it was cut short: a row has not as many cells as there are names, or the last
        one does not end.
    OSError, UnicodeError, ValueError
        When it cannot be read.
    """
    text, lines = path.read_bytes().decode("utf-8"), []
    reader = csv.reader(io.StringIO(text, newline=""), strict=True)
    try:
        names = tuple(next(reader, ()))
        if len(set(names)) < len(names):
            twice = next(name for name in names if names.count(name) > 1)
            raise ConfigError(f"{path}: expected one column {shown(twice)}, got {names.count(twice)}")
        for cells in filter(None, reader):
            if len(cells) != len(names):
                where = f"{path}, line {reader.line_num}"
                raise ConfigError(f"{where}: expected {len(names)} cells, got {len(cells)}; was the file cut short?")
            lines.append(dict(zip(names, cells, strict=True)))
    except csv.Error as error:
        raise ValueError(f"line {reader.line_num}: {error}") from error
    if text and not text.endswith("\n"):
        raise ConfigError(f"{path}: expected a line feed after the last row, got none; was the file cut short?")
    return names, lines


def _parquet(path: Path) -> tuple[tuple[str, ...], list[dict[str, Any]]]:
    if not has_parquet():
        raise ConfigError(f"{path}: Parquet needs the package pyarrow: {install_line('study')}")
    import pyarrow.parquet as pq

    table = pq.read_table(path)
    return tuple(table.column_names), table.to_pylist()


def _value(hint: Any, cell: Any) -> Any:
    """What stands in a cell, as the type of its column: text, a list with spaces, nothing where nothing is known."""
    if not isinstance(cell, str):
        return tuple(cell) if isinstance(cell, list) else cell
    if typing.get_origin(hint) is tuple:
        return tuple(_value(typing.get_args(hint)[0], part) for part in cell.split())
    if isinstance(hint, types.UnionType):
        return None if cell == "" else _value(typing.get_args(hint)[0], cell)
    if hint is bool:
        if cell not in ("true", "false"):
            raise ValueError(f"expected true or false, got '{cell}'")
        return cell == "true"
    return hint(cell)


def has_parquet() -> bool:
    """Whether the package that writes Parquet is here."""
    return find_spec("pyarrow") is not None


def parquet_schema(kind: type[Any]) -> Any:
    """Columns and their types, from the fields of a kind of row; needs the extra ``study``."""
    import pyarrow as pa

    plain = {str: pa.string(), int: pa.int64(), float: pa.float64(), bool: pa.bool_()}

    def type_of(hint: Any) -> Any:
        if hint in plain:
            return plain[hint]
        first = typing.get_args(hint)[0]
        return pa.list_(plain[first]) if typing.get_origin(hint) is tuple else plain[first]

    hints = typing.get_type_hints(kind)
    return pa.schema([(field.name, type_of(hints[field.name])) for field in fields(kind)])


def write_parquet(path: Path, rows: Iterable[Any], kind: type[Any]) -> None:
    """Write rows as one Parquet file, some thousands at a time; needs the extra ``study``."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    schema, left = parquet_schema(kind), iter(rows)
    with path.open("wb") as file, pq.ParquetWriter(file, schema) as writer:  # of a path it takes UTF-8 only
        while batch := [asdict(row) for row in islice(left, BATCH)]:
            writer.write_table(pa.Table.from_pylist(batch, schema=schema))
