"""Rows of the study of live separation, and the tables of the page that are made from them."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from functools import partial
from pathlib import Path
from statistics import mean, median
from typing import Any

from ross_payload.atomic_files import replacing
from ross_payload.errors import ConfigError, OutputError, refused_as
from ross_sim.study.rows.row_files import csv_lines


@dataclass(frozen=True, slots=True)
class Row:
    """One live separator on one mixture; SI-SDR of the target in dB, None when it is silent."""

    setting: str
    k: int
    layout: int  # 0 is the paper's
    target: int
    rate: int  # [Hz]
    seed: int
    separator: str = ""
    wanted_ms: int = 0  # algorithmic latency, at most
    latency_ms: float = 0.0  # and truly
    batch_db: float | None = None  # the separator on the whole recording, after 4 s
    live_db: float | None = None
    first_batch_db: float | None = None  # the same in the first second
    first_live_db: float | None = None  # nothing known but directions
    first_room_db: float | None = None  # something learnt at another heading
    step_cpu: float = 0.0  # [s/s]
    learn_cpu: float = 0.0  # [s/s]

    @property
    def mixture(self) -> tuple[str, int, int, int, int, int]:
        """What names the mixture."""
        return self.setting, self.k, self.layout, self.target, self.rate, self.seed


def appended(path: Path, rows: Iterable[Row]) -> None:
    """Append all rows of a mixture at once, or none, with a heading to a new file.

    Raises
    ------
    OutputError
        When they cannot be written.
    """
    names, text = [field.name for field in fields(Row)], io.StringIO(newline="")
    writer = csv.DictWriter(text, names, lineterminator="\n")
    if not path.exists():
        writer.writeheader()
    writer.writerows(
        {name: round(value, 3) if isinstance(value, float) else value for name, value in asdict(row).items()}
        for row in rows
    )
    with refused_as(OutputError, f"{path}: cannot be written"):
        path.parent.mkdir(parents=True, exist_ok=True)
        before = path.read_bytes() if path.exists() else b""
        with replacing(path) as part:
            part.write_bytes(before + text.getvalue().encode())


def read_rows(path: Path) -> list[Row]:
    """Read what `appended` wrote.

    Raises
    ------
    ConfigError
        When it is something else.
    """
    try:
        return [_row(line) for line in csv_lines(path)[1]]
    except (OSError, ValueError, TypeError) as error:
        raise ConfigError(f"{path}: expected rows of the study of live separation: {error}") from error


def _row(line: dict[str, str]) -> Row:
    texts, whole = {"setting", "separator"}, {"k", "layout", "target", "rate", "seed", "wanted_ms"}
    kinds: dict[str, Callable[[str], Any]] = dict.fromkeys(texts, str) | dict.fromkeys(whole, int)
    values: dict[str, Any] = {name: kinds.get(name, float)(text) if text else None for name, text in line.items()}
    return Row(**values)


def _lost(rows: Iterable[Row], base: str, live: str) -> float | None:
    """Mean loss [dB] over the rows in which the target speaks."""
    pairs = [(getattr(row, base), getattr(row, live)) for row in rows]
    losses = [a - b for a, b in pairs if a is not None and b is not None]
    return mean(losses) if losses else None


def _cell(value: float | None) -> str:
    return "" if value is None else f"{value:.1f}"


def tables(rows: Sequence[Row]) -> str:
    """Markdown: the loss by room and number of talkers, in the first second, and the cost.

    >>> row = Row("S1", 3, 0, 0, 16000, 0, "auto", 100, 100.0, 12.0, 11.75, 9.0, 8.0, 8.5, 0.05, 0.03)
    >>> tables([row]).splitlines()[2]
    '| `auto` | 100.0 | 0.2 |'
    """
    rooms = sorted({(row.setting, row.k) for row in rows}, key=lambda room: (not room[0].startswith("S"), room))
    by_room = {f"{setting}, K = {k}": partial(_is_room, setting, k) for setting, k in rooms}
    cases = sorted({(row.rate, row.k) for row in rows})
    by_case = {f"{rate // 1000} kHz, K = {k}": partial(_is_case, rate, k) for rate, k in cases}
    return "\n".join(
        [
            *_table(rows, by_room, lambda some: _cell(_lost(some, "batch_db", "live_db"))),
            "\nIn the first second, nothing known but the directions / something learnt at another heading:\n",
            *_table(rows, by_room, _first_second_losses),
            "\nProcessor time per second of audio on one core, every frame with its transforms + learning:\n",
            *_table(rows, by_case, _cost),
            f"\nMixtures: {_mixtures(rows)}.",
        ]
    )


def _mixtures(rows: Sequence[Row]) -> str:
    """How many there are of every room, number of talkers and rate.

    >>> _mixtures([Row("S1", 3, 0, target, 16000, 0) for target in (0, 1)])
    '2 at 16 kHz (S1: K = 3, 3)'
    """
    parts = []
    for rate in sorted({row.rate for row in rows}):
        found: dict[str, list[int]] = {}
        for mixture in sorted({row.mixture for row in rows if row.rate == rate}):
            found.setdefault(mixture[0], []).append(mixture[1])
        each = "; ".join(f"{setting}: K = {', '.join(map(str, counts))}" for setting, counts in found.items())
        parts.append(f"{sum(map(len, found.values()))} at {rate // 1000} kHz ({each})")
    return ", ".join(parts)


def _is_room(setting: str, k: int, row: Row) -> bool:
    return (row.setting, row.k) == (setting, k)


def _is_case(rate: int, k: int, row: Row) -> bool:
    return (row.rate, row.k) == (rate, k)


def _first_second_losses(rows: Sequence[Row]) -> str:
    lost = (_lost(rows, "first_batch_db", name) for name in ("first_live_db", "first_room_db"))
    return " / ".join(map(_cell, lost))


def _cost(rows: Sequence[Row]) -> str:
    return f"{median(row.step_cpu for row in rows):.3f} + {median(row.learn_cpu for row in rows):.3f}"


def _table(
    rows: Sequence[Row], columns: Mapping[str, Callable[[Row], bool]], cell: Callable[[Sequence[Row]], str]
) -> list[str]:
    """One line for every separator and latency, one column for every kind of rows."""
    lines = [f"| separator | latency [ms] | {' | '.join(columns)} |", "| --- " * (2 + len(columns)) + "|"]
    for wanted, name in sorted({(row.wanted_ms, row.separator) for row in rows}):
        mine = [row for row in rows if (row.wanted_ms, row.separator) == (wanted, name)]
        groups = [[row for row in mine if fits(row)] for fits in columns.values()]
        cells = [cell(group) if group else "" for group in groups]
        lines.append(f"| `{name}` | {max(row.latency_ms for row in mine)} | {' | '.join(cells)} |")
    return lines
