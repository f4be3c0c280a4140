"""Rows of the study of live separation, and the tables of the page that are made from them."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from statistics import mean, median
from typing import Any

from ross_payload.errors import ConfigError

BEGIN, END = "<!-- live separation: begin -->", "<!-- live separation: end -->"


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
    """Append all rows of a mixture at once, with a heading to a new file."""
    made, names = list(rows), [field.name for field in fields(Row)]
    new = not path.exists()
    with path.open("a", newline="") as file:
        writer = csv.DictWriter(file, names, lineterminator="\n")
        if new:
            writer.writeheader()
        writer.writerows(
            {name: round(value, 3) if isinstance(value, float) else value for name, value in asdict(row).items()}
            for row in made
        )


def read_rows(path: Path) -> list[Row]:
    """Read what `appended` wrote.

    Raises
    ------
    ConfigError
        When it is something else.
    """
    try:
        with path.open(newline="") as file:
            return [_row(line) for line in csv.DictReader(file)]
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
    kinds = sorted({(row.wanted_ms, row.separator) for row in rows})
    columns = sorted({(row.setting, row.k) for row in rows}, key=lambda each: (each[0] != "S1", each[0] != "S2", each))
    heading = " | ".join(f"{setting}, K = {k}" for setting, k in columns)
    parts = [f"| separator | latency [ms] | {heading} |", "| --- " * (2 + len(columns)) + "|"]
    parts += _by_room(rows, kinds, columns, "batch_db", "live_db")
    parts += ["", "In the first second, nothing known but the directions / something learnt at another heading:", ""]
    parts += [f"| separator | latency [ms] | {heading} |", "| --- " * (2 + len(columns)) + "|"]
    begun = _by_room(rows, kinds, columns, "first_batch_db", "first_live_db")
    known = _by_room(rows, kinds, columns, "first_batch_db", "first_room_db")
    parts += [_both(a, b) for a, b in zip(begun, known, strict=True)]
    counts, rates = sorted({row.k for row in rows}), sorted({row.rate for row in rows})
    cases = [(rate, k) for rate in rates for k in counts]
    parts += ["", "Processor time per second of audio on one core, every frame with its transforms + learning:", ""]
    parts.append(f"| separator | latency [ms] | {' | '.join(f'{rate // 1000} kHz, K = {k}' for rate, k in cases)} |")
    parts.append("| --- " * (2 + len(cases)) + "|")
    for wanted, name in kinds:
        mine = [row for row in rows if (row.wanted_ms, row.separator) == (wanted, name)]
        costs = [[row for row in mine if (row.rate, row.k) == case] for case in cases]
        cells = [
            f"{median(row.step_cpu for row in each):.3f} + {median(row.learn_cpu for row in each):.3f}" if each else ""
            for each in costs
        ]
        parts.append(f"| `{name}` | {max(row.latency_ms for row in mine)} | {' | '.join(cells)} |")
    return "\n".join(parts)


def _by_room(
    rows: Sequence[Row], kinds: Sequence[tuple[int, str]], columns: Sequence[tuple[str, int]], base: str, live: str
) -> list[str]:
    lines = []
    for wanted, name in kinds:
        mine = [row for row in rows if (row.wanted_ms, row.separator) == (wanted, name)]
        cells = [
            _cell(_lost([row for row in mine if (row.setting, row.k) == column], base, live)) for column in columns
        ]
        lines.append(f"| `{name}` | {max(row.latency_ms for row in mine)} | {' | '.join(cells)} |")
    return lines


def _both(first: str, second: str) -> str:
    """Cells of two lines beside each other, after the two that they share.

    >>> _both("| a | 1 | 2.0 |", "| a | 1 | 3.0 |")
    '| a | 1 | 2.0 / 3.0 |'
    """
    one, other = (line.strip("| ").split(" | ") for line in (first, second))
    cells = [f"{a} / {b}" for a, b in zip(one[2:], other[2:], strict=True)]
    return f"| {' | '.join([*one[:2], *cells])} |"


def with_tables(page: str, rows: Sequence[Row]) -> str:
    """The page with the tables between its two marks.

    Raises
    ------
    ConfigError
        When it has no marks.

    >>> with_tables("a", [])
    Traceback (most recent call last):
    ross_payload.errors.ConfigError: page: expected the marks of the study of live separation, got none
    """
    before, begin, rest = page.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise ConfigError("page: expected the marks of the study of live separation, got none")
    return f"{before}{BEGIN}\n{tables(rows)}\n{END}{after}"
