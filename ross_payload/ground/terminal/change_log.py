"""What changed, for logs and for other programs: one line in words or one JSON object per change, with its time."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from datetime import datetime
from typing import Any

import click

from ross_payload.ground.model.health import LEVELS
from ross_payload.ground.model.payload_state import PayloadState
from ross_payload.ground.model.state_reducer import MOST_SOURCES
from ross_payload.ground.terminal.blocks import SILENT_S, safe_view
from ross_protocols.angle_text import frame, rounded
from ross_protocols.mavlink.component_id import ComponentId

UNFINISHED = object()  # an estimate of which not all messages have come
UNSTEADY = ("level_db", "delay", "lost", "packets_lost", "azimuth", "group")  # of a stream: numbers that never rest
MOVED_DEG = 5.0  # from which a source has moved
View = dict[str, Any]


class ChangeLog:
    """Keeps what was logged about one payload; returns what is new, in words or as sections."""

    def __init__(self) -> None:
        self.present = True
        self.known: PayloadState | None = None  # at the last look
        self._logged: dict[str, Any] = {}
        self._events: list[dict[str, Any]] = []

    def presence(self, last: float, now: float) -> list[str]:
        """Return what to say when a payload falls silent, or is heard again."""
        age = now - last
        if (age <= SILENT_S) is self.present:
            return []
        self.present = not self.present
        return ["telemetry resumed" if self.present else f"no telemetry for {age:.1f} s"]

    def words(self, view: View) -> list[str]:
        """Return what is new, in words."""
        said = []
        for name, (key, describe) in SECTIONS.items():
            value = key(view)
            if value is UNFINISHED:
                continue
            if name not in self._logged or not _alike(self._logged[name], value):
                self._logged[name] = value
                said += describe(view)
        return said + [each["text"] for each in self._news(view)]

    def sections(self, view: View) -> list[tuple[str, Any]]:
        """Return the sections that are new; without history and trails: the lines are that."""
        said = []
        for name, section in view.items():
            if name in ("history", "events"):
                continue
            value = _steady(name, section)
            if name not in self._logged or self._logged[name] != value:
                self._logged[name] = value
                said.append((name, value))
        return said + [("event", each) for each in self._news(view)]

    def _news(self, view: View) -> list[dict[str, Any]]:
        events = view["events"]
        last = self._events[-1] if self._events else None
        start = max((place + 1 for place, each in enumerate(events) if each == last), default=0)
        self._events = events
        return list(events[start:])


def _alike(before: Any, after: Any) -> bool:
    """Whether nothing worth a line has changed; places of sources may tremble."""
    if not isinstance(after, dict) or before.keys() != after.keys():
        return bool(before == after)
    return all(_near(before[index], place) for index, place in after.items())


def _near(before: tuple[Any, ...], after: tuple[Any, ...]) -> bool:
    apart = abs((after[0] - before[0] + 180.0) % 360.0 - 180.0)
    return apart < MOVED_DEG and before[1:] == after[1:]


def _steady(name: str, section: Any) -> Any:
    """A section without what changes with every message and means nothing new."""
    if name == "standing":
        return {key: value for key, value in section.items() if key != "last"}
    if name == "sources":
        return [{key: value for key, value in each.items() if key != "trail"} for each in section]
    if name == "streams":
        return [{key: value for key, value in each.items() if key not in UNSTEADY} for each in section]
    if name == "health":
        return {
            key: [_level(each) for each in part] if isinstance(part, list) else _level(part)
            for key, part in section.items()
        }
    return section


def _level(part: dict[str, Any]) -> dict[str, Any]:
    return {key: part[key] for key in ("level", "words", "url") if key in part}


def _standing(view: View) -> list[str]:
    standing = view["standing"]
    outcome = f", {standing['outcome'].replace('_', ' ')}" if standing["outcome"] else ""
    return [f"state {(standing['state'] or 'unknown').replace('_', ' ')}{outcome}: {standing['state_meaning']}"]


def _oddity(view: View) -> list[str]:
    """Starts, and what is odd about the messages."""
    standing = view["standing"]
    starts = [f"restarted, {standing['boots']} starts so far"] if standing["boots"] > 1 else []
    return starts + [f"warning: {flaw}" for flaw in standing["flaws"][-1:]]


def _goal_key(view: View) -> Any:
    goal = view["pointing"]["goal"]
    return None if goal is None else rounded(goal, 0)


def _goal(view: View) -> list[str]:
    pointing = view["pointing"]
    if pointing["heading"] is None:
        return []
    if pointing["goal"] is None:
        return [f"axis at {rounded(pointing['heading']):.1f} deg"]
    return [f"axis at {rounded(pointing['heading']):.1f} deg, turning to {rounded(pointing['goal']):.1f} deg"]


def _mission(view: View) -> list[str]:
    mission = view["mission"]
    if mission["k"] is None:
        return []
    target = "" if mission["target"] is None else f", target {mission['target']}"
    return [f"K {mission['k']}{' final' if mission.get('certain') else ''}{target}"]


def _sources_key(view: View) -> Any:
    announced = max((each["announced"] for each in view["sources"]), default=0)
    if len(view["sources"]) < min(announced, MOST_SOURCES):
        return UNFINISHED
    return {
        each["source"]: (each["azimuth"], each["target"], each["resolved"], each["final"]) for each in view["sources"]
    }


def _sources(view: View) -> list[str]:
    told = [
        f"{each['source']}{'*' if each['target'] else ''} at {rounded(each['azimuth'], 0):.0f}"
        + ("" if each["sigma"] is None else f" +- {each['sigma']:.0f}")
        + " deg"
        + ("" if each["mirror"] is None else f" or {rounded(each['mirror'], 0):.0f}")
        for each in view["sources"]
    ]
    return [f"sources {', '.join(told)}, {frame(view['sources'][0]['earth'])}"] if told else []


def _plan(view: View) -> list[str]:
    told = [
        f"{rounded(each['heading'], 0):.0f} deg ({each['state']}) isolates {each['source']}"
        for each in view["plan"]["candidates"]
    ]
    return [f"alignment candidates {', '.join(told)}"] if told else []


def _groups(view: View) -> list[str]:
    told = []
    for each in view["groups"]:
        score = "" if each["score"] is None else f" score {each['score']:.2f}"
        told.append(f"{'+'.join(map(str, each['members'])) or 'unknown'}{score}{' accepted' * each['accepted']}")
    return [f"separated ({view['groups'][0]['phase']}) {', '.join(told)}"] if told else []


def _streams(view: View) -> list[str]:
    return [f"stream {each['number']}: {each['whom']} to {each['place']}, {each['words']}" for each in view["streams"]]


def _health(view: View) -> list[str]:
    return [
        f"health {name}: {LEVELS[each['level']].lower()}, {each['words']}"
        for name, each in _parts(view)
        if each["level"] in ("act", "watch")
    ] or ["health: good"]


def _parts(view: View) -> list[tuple[str, dict[str, Any]]]:
    return [
        (name, each) for name, part in view["health"].items() for each in (part if isinstance(part, list) else [part])
    ]


def _picked(rows: list[dict[str, Any]], *names: str) -> list[list[Any]]:
    return [[row[name] for name in names] for row in rows]


SECTIONS: dict[str, tuple[Callable[[View], Any], Callable[[View], list[str]]]] = {  # when to say something, and what
    "standing": (lambda view: (view["standing"]["state"], view["standing"]["outcome"]), _standing),
    "oddity": (lambda view: (view["standing"]["boots"], view["standing"]["flaws"]), _oddity),
    "goal": (_goal_key, _goal),
    "mission": (lambda view: [view["mission"].get(each) for each in ("k", "target", "certain")], _mission),
    "sources": (_sources_key, _sources),
    "plan": (lambda view: (view["plan"]["current"], _picked(view["plan"]["candidates"], "heading", "state")), _plan),
    "groups": (lambda view: _picked(view["groups"], "phase", "members", "score"), _groups),
    "streams": (_streams, _streams),
    "health": (lambda view: [(name, each["level"]) for name, each in _parts(view)], _health),
}


class LineWriter:
    """Writes to standard output, in words or as JSON."""

    def __init__(self, *, as_json: bool) -> None:
        self._as_json = as_json
        self._logs: dict[ComponentId, ChangeLog] = {}
        self._links: dict[str, str] = {}
        self._advice = ""

    def look(self, known: PayloadState, now: float) -> None:
        """Write what is new about a payload."""
        log = self._logs.setdefault(known.who, ChangeLog())
        for words in log.presence(known.last, now):
            self._write(known.who, "heard", log.present, words)
        if log.known is known:
            return
        log.known, view = known, safe_view(known)
        if self._as_json:
            for name, value in log.sections(view):
                self._write(known.who, name, value, "")
        else:
            for line in log.words(view):
                self._write(known.who, "", None, line)

    def link(self, url: str, words: str) -> None:
        """Write how a link is when that changes; empty: it is up."""
        if self._links.get(url) != words:
            self._links[url] = words
            value = {"url": url, "up": not words, "error": words}
            self._write(None, "link", value, f"link {url} {words or 'is open'}")

    def advise(self, advice: str) -> None:
        """Write what is wrong, once."""
        if advice and not self._advice:
            self._write(None, "advice", advice, advice)
        self._advice = advice

    def _write(self, who: ComponentId | None, section: str, value: Any, words: str) -> None:
        at = time.time()
        if self._as_json:
            name = None if who is None else str(who)
            click.echo(json.dumps({"time": round(at, 3), "payload": name, "section": section, "value": value}))
        else:
            stamp = datetime.fromtimestamp(at).astimezone().isoformat(timespec="milliseconds")
            click.echo(f"{stamp} {who or '-'} {words}")
