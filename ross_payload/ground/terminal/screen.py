"""The whole screen: blocks and polar view, put together for any size."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from textwrap import wrap
from typing import Any

from rich.text import Text

from ross_payload.ground.terminal import blocks
from ross_payload.ground.terminal.polar_plot import LEGEND, polar_plot

SIDE_BY_SIDE = 60  # columns, from which the polar view stands beside the tables
MIN_PLOT_ROWS = 9  # rows, below which it is left out
TALL = 40  # rows, from which there is a legend and more room for what was said
KEYS = "s STOP  e explore  l listen  v voice  c cancel  r rearm  <-> source  q quit"
HEARING_KEYS = "s STOP e explore l listen v voice h hear m mixture x end c cancel r rearm q quit"


@dataclass(frozen=True, slots=True)
class ScreenState:
    """What goes on the screen."""

    view: dict[str, Any] | None  # its sections; None: nothing was received
    now: float  # [s]
    advice: str = ""  # when nothing, or too little, is heard
    links: Sequence[Any] = ()  # `LinkState`
    doings: Sequence[Any] = ()  # `CommandStatus`
    others: Sequence[tuple[str, bool, str]] = ()  # every payload: its name, whether it is this one, its state
    chosen: int | None = None  # source
    note: str = ""  # to the user
    hearing: bool = False  # the keys for live listening are of use


def compose(shown: ScreenState, width: int, height: int, *, braille: bool = True, keys: bool = True) -> list[Text]:
    """Return exactly ``height`` lines, none wider than ``width``."""
    foot = _foot(shown, height, keys=keys)
    if shown.view is None:
        top, body = _advice(shown, width), []
    else:
        top = _top(shown.view, shown.now) + [Text(line, "yellow") for line in wrap(shown.advice, max(width, 10))[:2]]
        room = max(height - len(top) - len(foot), 0)
        body = _body(shown, shown.view, width, room, braille=braille)[:room]
    blank = max(height - len(top) - len(body) - len(foot), 0)
    lines = [*top, *body, *([Text("")] * blank), *foot]
    return [_fit(line, width, dots=braille) for line in lines[:height]]


def _fit(line: Text, width: int, *, dots: bool) -> Text:
    """Cut what is too long, with dots where they can be shown."""
    line = line.copy()
    line.truncate(width, overflow="ellipsis" if dots else "crop")
    return line


def _top(view: dict[str, Any], now: float) -> list[Text]:
    flaws = [Text(f"WARNING: {flaw}", "bold red") for flaw in view["standing"]["flaws"][-1:]]
    return blocks.head(view, now) + flaws + blocks.strip(view)


def _advice(shown: ScreenState, width: int) -> list[Text]:
    words = [Text(line) for line in wrap(shown.advice, max(width, 10))]
    return [Text("RoSS  no telemetry yet", "bold yellow"), *words, *blocks.links(shown.links)]


def _foot(shown: ScreenState, height: int, *, keys: bool) -> list[Text]:
    """What was said and ordered, every payload if there are several, and the keys."""
    tall = height >= TALL
    rows = blocks.events(shown.view, shown.now, 8 if tall else 3) if shown.view else []
    rows += blocks.orders(shown.doings, 4 if tall else 2)
    if len(shown.others) > 1:
        rows.append(_others(shown.others))
    if tall and shown.view is not None:
        rows.insert(0, Text(LEGEND, "dim"))
    if keys:
        help_line = HEARING_KEYS if shown.hearing else KEYS
        rows.append(Text(shown.note, "bold yellow") if shown.note else Text(help_line, "reverse"))
    return rows


def _others(others: Sequence[tuple[str, bool, str]]) -> Text:
    line = Text()
    for index, (name, this, state) in enumerate(others, 1):
        line.append(f" {index} {name} {state} ", "reverse" if this else "").append(" ")
    return line


def _body(shown: ScreenState, view: dict[str, Any], width: int, room: int, *, braille: bool) -> list[Text]:
    columns = min(2 * room, width // 2)
    rows = columns // 2
    if width < SIDE_BY_SIDE or rows < MIN_PLOT_ROWS:
        return _tables(shown, view, width, room, braille=braille)
    left = polar_plot(view, columns, rows, chosen=shown.chosen, braille=braille)
    right = _tables(shown, view, width - columns - 1, room, braille=braille)
    lines = []
    for index in range(room):
        line = left[index].copy() if index < rows else Text(" " * columns)
        lines.append(line.append(" ").append_text(right[index] if index < len(right) else Text("")))
    return lines


def _tables(shown: ScreenState, view: dict[str, Any], width: int, room: int, *, braille: bool) -> list[Text]:
    """Return as many blocks as there is room for, the important ones first; a long one leaves room for others."""
    wanted = (
        (blocks.sources(view, chosen=shown.chosen), room // 2),
        (blocks.streams(view), room // 4),
        (blocks.health(view), room // 2),
        (blocks.plan(view), room // 3),
        (blocks.links(shown.links), 4),
        (blocks.groups(view), room // 4),
        (blocks.curves(view, width, braille=braille), room),
    )
    lines: list[Text] = []
    for block, most in wanted:
        fits = min(most, room - len(lines))
        if block and fits > 0:
            more = Text(f" and {len(block) - fits + 1} more", "dim")
            lines += block if len(block) <= fits else [*block[: fits - 1], more]
            if room >= TALL // 2 and len(lines) < room:
                lines.append(Text(""))
    return lines
