"""A flight's summary on the terminal."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from datetime import UTC, datetime
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from ross_payload.terminal_tables import with_whole_words
from ross_protocols.angle_text import frame, rounded

MOST = 40  # rows of one table
Row = dict[str, Any]


def show(flight: Row, console: Console) -> None:
    """Print a `summary`."""
    start = flight["start"]
    began = "" if start is None else f", began {datetime.fromtimestamp(start, UTC):%Y-%m-%d %H:%M:%S} UTC"
    _print(console, f"{flight['name']}: {span(flight['duration'])}, {flight['frames']} frames{began}")
    for note in flight["notes"]:
        _print(console, f"note: {note}", style="yellow")
    for payload in flight["payloads"]:
        _payload(console, payload)
    if flight["others"]:
        rows = ([each["who"], each["frames"], _lost(each["lost"]), _kinds(each["kinds"])] for each in flight["others"])
        _table(console, "Others", ("who", "frames", "lost", "most of them"), rows, len(flight["others"]))


def span(seconds: float) -> str:
    """Write a duration.

    >>> span(42.64), span(754.0), span(7325.0)
    ('42.6 s', '12:34', '2:02:05')
    """
    if seconds < 60:
        return f"{seconds:.1f} s"
    whole = round(seconds)
    hours, minutes = divmod(whole // 60, 60)
    return f"{hours}:{minutes:02}:{whole % 60:02}" if hours else f"{minutes}:{whole % 60:02}"


def _payload(console: Console, payload: Row) -> None:
    console.rule(f"payload {payload['who']}", style="default")
    about = [payload["actuator"], payload["version"] and f"version {payload['version']}"]
    counted = None if payload["earth"] is None else f"angles clockwise {frame(payload['earth'])}"
    way = "inside TUNNEL" if payload["tunnelled"] else None
    words = ", ".join(str(each) for each in (*about, counted, way) if each)
    lost = "loss unknown: they came through a router" if payload["lost"] is None else f"{payload['lost']} lost"
    _print(console, f"{words}. {payload['frames']} frames, {lost}" if words else "")
    for title, columns, rows in _parts(payload):
        _table(console, title, columns, iter(rows), len(rows))


def _lost(count: int | None) -> str:
    """Write how many frames were lost; None: they came through a router."""
    return "unknown" if count is None else str(count)


def _parts(payload: Row) -> Iterator[tuple[str, tuple[str, ...], list[list[Any]]]]:
    """Yield title, columns and rows of every table of a payload."""
    yield "States", ("at", "state", "for"), [
        [span(each["at"]), _words(each["state"]), span(each["duration"])] for each in payload["states"]
    ]  # fmt: skip
    for number, each in enumerate(payload["explorations"], 1):
        ways = " -> ".join(f"{k} at {span(at)}" for at, k in each["k"]) or "none"
        title = f"Exploration {number}: {span(each['duration'])}, {each['rotations']} rotations, K {ways}"
        yield title, SOURCES, [_source(source) for source in each["sources"]] or [["none", *[""] * 5]]
    if payload["sources"] and not payload["explorations"]:
        yield "Sources", SOURCES, [_source(source) for source in payload["sources"]]
    yield "Alignments", ("plan", "isolates", "heading [deg]", "gain [dB]", "as one", "rule", "became"), [
        [f"{each['plan']}.{each['candidate']}", each["source"], _bearing(each["heading"]), _number(each["gain"]),
         _listed(each["aliased"]), each["rule"], BECAME.get(each["state"], each["state"])]
        for each in payload["alignments"]
    ]  # fmt: skip
    yield "Separations", ("at", "phase", "method", "group", "sources", "score", "criterion", "is"), [
        [span(each["at"]), each["phase"], each["method"], group["group"], _listed(group["members"]),
         _number(group["score"]), _number(group["criterion"]), "target" if group["target"] else ""]
        for each in payload["separations"] for group in each["groups"]
    ]  # fmt: skip
    yield "Streams", ("at", "for", "stream", "carries", "to", "by", "is"), [
        [span(each["at"]), span(each["duration"]), each["number"], each["whom"], each["place"],
         ", ".join(filter(None, (each["sink"], each["codec"]))), each["words"]]
        for each in payload["streams"]
    ]  # fmt: skip
    yield "Events", ("at", "what"), [[span(each["at"]), each["text"]] for each in payload["events"]]
    yield "Orders", ("at", "from", "order", "answers"), [_order(each) for each in payload["commands"]]
    yield "Silence", ("at", "for"), [[span(each["at"]), span(each["duration"])] for each in payload["gaps"]]
    yield "Messages", ("message", "frames", "rate [Hz]"), [
        [each["name"], each["count"], _number(each["rate"], 2)] for each in payload["kinds"]
    ]  # fmt: skip


BECAME = {"planned": "not tried"}
SOURCES = ("source", "azimuth [deg]", "sigma [deg]", "mirror [deg]", "confidence", "score")


def _source(source: Row) -> list[Any]:
    name = f"{source['source']} target" if source["target"] else source["source"]
    angles = _bearing(source["azimuth"]), _number(source["sigma"]), _bearing(source["mirror"])
    return [name, *angles, f"{source['confidence']:.2f}", _number(source["score"])]


def _order(order: Row) -> list[Any]:
    numbers = " ".join("NaN" if number is None else f"{number:g}" for number in order["numbers"])
    answers = ", ".join(
        f"{_words(answer['result'])} at {span(answer['at'])}" for answer in order["answers"]
    )  # fmt: skip
    at = "not received" if order["at"] is None else span(order["at"])
    return [at, order["from"] or "", f"{order['command']} {numbers}".strip(), answers or "none"]


def _table(console: Console, title: str, columns: tuple[str, ...], rows: Iterable[list[Any]], count: int) -> None:
    """Print a table of ``count`` rows, cut to `MOST`; nothing when it is empty."""
    if not count:
        return
    table = Table(title=escape(_plain(title)), title_justify="left")
    for column in columns:
        table.add_column(escape(column), overflow="fold")
    for row, _ in zip(rows, range(MOST), strict=False):
        table.add_row(*(escape(_plain(cell)) for cell in row))
    console.print()
    console.print(with_whole_words(table))
    if count > MOST:
        _print(console, f"and {count - MOST} more: --json lists all")


def _print(console: Console, words: str, style: str = "") -> None:
    if words:
        console.print(_plain(words), style=style, markup=False, highlight=False, soft_wrap=True)


def _kinds(kinds: list[Row]) -> str:
    return ", ".join(f"{kind['name']} x {kind['count']}" for kind in kinds[:3]) + (", ..." if len(kinds) > 3 else "")


def _number(number: float | None, digits: int = 1) -> str:
    return "" if number is None else f"{number:.{digits}f}"


def _bearing(degrees: float | None) -> str:
    return "" if degrees is None else _number(rounded(degrees))


def _listed(indices: list[int]) -> str:
    return ", ".join(map(str, indices))


def _plain(cell: Any) -> str:
    """Write what a terminal does not obey: texts come from the air."""
    return "".join(letter if letter.isprintable() else "?" for letter in str(cell))


def _words(name: str) -> str:
    return name.replace("_", " ")
