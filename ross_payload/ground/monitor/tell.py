"""What changed, for logs: one line in words or one JSON object per change."""

from __future__ import annotations

from typing import Any

from ross_payload.ground.monitor.blocks import SILENT
from ross_payload.ground.picture.condition import LEVELS
from ross_payload.ground.picture.learning import MOST_SOURCES
from ross_protocols.angle_text import frame, rounded

UNFINISHED = object()  # an estimate of which not all messages have come
MOVED = 5.0  # [deg] from which a source has moved
Picture = dict[str, Any]


class Teller:
    """Knows what was told about one payload; tells what is new, in words or as sections."""

    def __init__(self) -> None:
        self.present = True
        self._told: dict[str, Any] = {}
        self._events: list[dict[str, Any]] = []

    def presence(self, last: float, now: float) -> list[str]:
        """Return what to say when a payload falls silent, or is heard again."""
        age = now - last
        if (age <= SILENT) is self.present:
            return []
        self.present = not self.present
        return ["telemetry resumed" if self.present else f"no telemetry for {age:.1f} s"]

    def words(self, picture: Picture) -> list[str]:
        """Return what is new, in words."""
        said = []
        for name, (key, describe) in SECTIONS.items():
            value = key(picture)
            if value is UNFINISHED:
                continue
            if name not in self._told or not _alike(self._told[name], value):
                self._told[name] = value
                said += describe(picture)
        return said + [each["text"] for each in self._news(picture)]

    def sections(self, picture: Picture) -> list[tuple[str, Any]]:
        """Return the sections that are new; without history and trails: the lines are that."""
        said = []
        for name, section in picture.items():
            if name in ("history", "events"):
                continue
            value = _steady(name, section)
            if name not in self._told or self._told[name] != value:
                self._told[name] = value
                said.append((name, value))
        return said + [("event", each) for each in self._news(picture)]

    def _news(self, picture: Picture) -> list[dict[str, Any]]:
        events = picture["events"]
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
    return apart < MOVED and before[1:] == after[1:]


def _steady(name: str, section: Any) -> Any:
    """A section without what changes with every message and means nothing new."""
    if name == "standing":
        return {key: value for key, value in section.items() if key != "last"}
    if name == "sources":
        return [{key: value for key, value in each.items() if key != "trail"} for each in section]
    if name == "health":
        return {
            key: [_level(each) for each in part] if isinstance(part, list) else _level(part)
            for key, part in section.items()
        }
    return section


def _level(part: dict[str, Any]) -> dict[str, Any]:
    return {key: part[key] for key in ("level", "words", "url") if key in part}


def _standing_key(picture: Picture) -> Any:
    return picture["standing"]["state"], picture["standing"]["outcome"]


def _standing(picture: Picture) -> list[str]:
    standing = picture["standing"]
    outcome = f", {standing['outcome'].replace('_', ' ')}" if standing["outcome"] else ""
    return [f"state {(standing['state'] or 'unknown').replace('_', ' ')}{outcome}: {standing['state_meaning']}"]


def _oddity_key(picture: Picture) -> Any:
    return picture["standing"]["boots"], tuple(picture["standing"]["flaws"])


def _oddity(picture: Picture) -> list[str]:
    """Starts, and what is odd about the messages."""
    standing = picture["standing"]
    starts = [f"restarted, {standing['boots']} starts so far"] if standing["boots"] > 1 else []
    return starts + [f"warning: {flaw}" for flaw in standing["flaws"][-1:]]


def _goal_key(picture: Picture) -> Any:
    goal = picture["pointing"]["goal"]
    return None if goal is None else round(goal)


def _goal(picture: Picture) -> list[str]:
    pointing = picture["pointing"]
    if pointing["heading"] is None:
        return []
    if pointing["goal"] is None:
        return [f"axis at {pointing['heading']:.1f} deg"]
    return [f"axis at {pointing['heading']:.1f} deg, turning to {pointing['goal']:.1f} deg"]


def _mission_key(picture: Picture) -> Any:
    mission = picture["mission"]
    return mission["k"], mission["target"], mission.get("certain")


def _mission(picture: Picture) -> list[str]:
    mission = picture["mission"]
    if mission["k"] is None:
        return []
    target = "" if mission["target"] is None else f", target {mission['target']}"
    return [f"K {mission['k']}{' final' if mission.get('certain') else ''}{target}"]


def _sources_key(picture: Picture) -> Any:
    announced = max((each["announced"] for each in picture["sources"]), default=0)
    if len(picture["sources"]) < min(announced, MOST_SOURCES):
        return UNFINISHED
    return {
        each["source"]: (each["azimuth"], each["target"], each["resolved"], each["final"])
        for each in picture["sources"]
    }


def _sources(picture: Picture) -> list[str]:
    told = [
        f"{each['source']}{'*' if each['target'] else ''} at {rounded(each['azimuth'], 0):.0f}"
        + ("" if each["sigma"] is None else f" +- {each['sigma']:.0f}")
        + " deg"
        + ("" if each["mirror"] is None else f" or {rounded(each['mirror'], 0):.0f}")
        for each in picture["sources"]
    ]
    return [f"sources {', '.join(told)}, {frame(picture['sources'][0]['earth'])}"] if told else []


def _plan_key(picture: Picture) -> Any:
    plan = picture["plan"]
    return plan["current"], tuple((each["heading"], each["state"]) for each in plan["candidates"])


def _plan(picture: Picture) -> list[str]:
    told = [
        f"{each['heading']:.0f} deg ({each['state']}) isolates {each['source']}"
        for each in picture["plan"]["candidates"]
    ]
    return [f"alignment candidates {', '.join(told)}"] if told else []


def _groups_key(picture: Picture) -> Any:
    return tuple((each["phase"], tuple(each["members"]), each["score"]) for each in picture["groups"])


def _groups(picture: Picture) -> list[str]:
    told = []
    for each in picture["groups"]:
        score = "" if each["score"] is None else f" score {each['score']:.2f}"
        told.append(f"{'+'.join(map(str, each['members'])) or 'unknown'}{score}{' accepted' * each['accepted']}")
    return [f"separated ({picture['groups'][0]['phase']}) {', '.join(told)}"] if told else []


def _health_key(picture: Picture) -> Any:
    return tuple((name, each["level"]) for name, each in _parts(picture))


def _health(picture: Picture) -> list[str]:
    return [
        f"health {name}: {LEVELS[each['level']].lower()}, {each['words']}"
        for name, each in _parts(picture)
        if each["level"] in ("act", "watch")
    ] or ["health: good"]


def _parts(picture: Picture) -> list[tuple[str, dict[str, Any]]]:
    return [
        (name, each)
        for name, part in picture["health"].items()
        for each in (part if isinstance(part, list) else [part])
    ]


SECTIONS = {
    "standing": (_standing_key, _standing),
    "oddity": (_oddity_key, _oddity),
    "goal": (_goal_key, _goal),
    "mission": (_mission_key, _mission),
    "sources": (_sources_key, _sources),
    "plan": (_plan_key, _plan),
    "groups": (_groups_key, _groups),
    "health": (_health_key, _health),
}
