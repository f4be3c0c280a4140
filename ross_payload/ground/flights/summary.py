"""A whole flight as plain JSON. Angles are degrees, clockwise, as in `ross_payload.ground.picture.view`."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

import numpy as np

from ross_payload.ground.errors import GroundError
from ross_payload.ground.flights.asked import ASKING, Asked, Desk
from ross_payload.ground.flights.marks import OUR_NAME, TEXT
from ross_payload.ground.flights.reading import Flight
from ross_payload.ground.flights.story import TELLING, Exploration, Separated, Story, Tried
from ross_payload.ground.flights.tally import Tally, tallies
from ross_payload.ground.picture.fleet import Fleet
from ross_payload.ground.picture.known import Said, Who
from ross_payload.ground.picture.learning import is_sane
from ross_payload.ground.picture.view import word
from ross_protocols.codec import Packet
from ross_protocols.pairs import compass
from ross_protocols.tunnel import unwrap
from ross_protocols.values import Source, Text


class Told:
    """Everything that the payloads of a flight did and were asked."""

    def __init__(self, flight: Flight, payloads: tuple[Who, ...]) -> None:
        self.flight, self.payloads = flight, payloads
        self.stories = {who: Story(who) for who in payloads}
        self.texts: dict[Who, list[Said]] = {who: [] for who in payloads}
        self.desk = Desk()
        self._fleet = Fleet()  # puts texts together
        for at, packet in flight.packets(_worth_reading(flight, payloads)):
            self._hear(packet, at)

    def _hear(self, packet: Packet, at: float) -> None:
        self.desk.hear(packet, at, self.payloads)
        story = self.stories.get(Who(packet.system_id, packet.component_id))
        if story is None:
            return
        told = unwrap(packet.message) if packet.name == "TUNNEL" else packet
        value = None if told is None else told.value
        if isinstance(value, Text) or story.who not in self._fleet.payloads:
            self._text(story.who, packet, at)
        if value is not None and is_sane(value):
            story.hear(value, at)

    def _text(self, who: Who, packet: Packet, at: float) -> None:
        before = self._fleet.payloads.get(who)
        self._fleet.hear(packet, at)
        after = self._fleet.payloads.get(who)
        if after and after.texts and (not before or not before.texts or after.texts[-1] is not before.texts[-1]):
            self.texts[who].append(after.texts[-1])


def chosen(flight: Flight, payload: Who | None) -> tuple[Who, ...]:
    """Return the payloads that are meant: one, or None: all.

    Raises
    ------
    GroundError
        When the flight does not have it.
    """
    if payload is None:
        return flight.payloads
    if payload not in flight.payloads:
        found = ", ".join(map(str, flight.payloads)) or "none"
        raise GroundError(f"payload: expected one of {found}, got {payload}")
    return (payload,)


def summary(told: Told) -> dict[str, Any]:
    """Return the flight as JSON."""
    flight, counted = told.flight, tallies(told.flight)
    others = [_counts(counted[who]) for who in sorted(counted) if who not in flight.payloads]
    whole = {
        "name": flight.name,
        "start": flight.start,
        "duration": flight.duration,
        "frames": len(flight.index),
        "notes": list(flight.notes),
        "payloads": [_payload(told, who, counted[who]) for who in told.payloads],
        "others": others,
    }
    return {name: _rounded(part) for name, part in whole.items()}


def _rounded(part: Any) -> Any:
    """Round every number to what telemetry can tell."""
    if isinstance(part, dict):
        return {name: _rounded(each) for name, each in part.items()}
    if isinstance(part, list | tuple):
        return [_rounded(each) for each in part]
    return round(part, 6) if isinstance(part, float) else part


def _worth_reading(flight: Flight, payloads: tuple[Who, ...]) -> Any:
    index = flight.index
    mine = np.isin(index.sender, [256 * who.system + who.component for who in payloads])
    said = mine & np.isin(index.message, [*TELLING, TEXT])
    return np.flatnonzero(said | np.isin(index.message, ASKING))


def _payload(told: Told, who: Who, counted: Tally) -> dict[str, Any]:
    story = told.stories[who]
    known = story.information
    return {
        **_counts(counted),
        "actuator": known.actuator if known else None,
        "version": known.software_version if known else None,
        "dialect": known.dialect_version if known else None,
        "earth": story.status.earth if story.status else None,
        "states": [
            {"at": stay.at, "state": word("ROSS_STATE", stay.state), "duration": stay.until - stay.at}
            for stay in story.states
        ],
        "explorations": [_exploration(each) for each in story.explorations],
        "sources": [_source(each) for _, each in sorted(story.sources.items())],
        "alignments": [_tried(each) for each in story.tried.values()],
        "separations": [_separated(each) for each in story.separated.values()],
        "events": [
            {"at": said.at, "severity": said.severity, "text": said.text.removeprefix(OUR_NAME)}
            for said in told.texts[who]
        ],
        "commands": [_asked(each) for each in told.desk.asked(who)],
    }


def _counts(counted: Tally) -> dict[str, Any]:
    kinds = [asdict(kind) for kind in counted.kinds]
    return {**asdict(counted), "who": str(counted.who), "kinds": kinds, "gaps": [asdict(gap) for gap in counted.gaps]}


def _exploration(explored: Exploration) -> dict[str, Any]:
    return {
        "at": explored.at,
        "duration": explored.until - explored.at,
        "rotations": explored.rotations,
        "k": [list(pair) for pair in explored.k],
        "final": explored.final,
        "sources": [_source(each) for _, each in sorted(explored.sources.items())],
    }


def _source(source: Source) -> dict[str, Any]:
    return {
        "source": source.source,
        "azimuth": compass(source.azimuth),
        "mirror": None if source.mirror is None else compass(source.mirror),
        "sigma": math.degrees(source.sigma),
        "confidence": source.confidence,
        "score": source.score,
        "resolved": source.resolved,
        "target": source.target,
    }


def _tried(tried: Tried) -> dict[str, Any]:
    said = tried.said
    return {
        "at": tried.at,
        "plan": said.plan,
        "candidate": said.candidate,
        "source": said.source,
        "heading": compass(said.heading),
        "isolation_us": said.isolation * 1e6,
        "gain": said.gain,
        "aliased": list(said.aliased),
        "rule": word("ROSS_ALIGNMENT_RULE", said.rule),
        "state": word("ROSS_CANDIDATE_STATE", said.state),
    }


def _separated(separated: Separated) -> dict[str, Any]:
    groups = [each for _, each in sorted(separated.groups.items())]
    heading = groups[0].heading
    return {
        "at": separated.at,
        "separation": groups[0].separation,
        "phase": word("ROSS_SEPARATION_PHASE", groups[0].phase),
        "method": groups[0].method,
        "heading": None if heading is None else compass(heading),
        "groups": [
            {
                "group": group.group,
                "members": list(group.members),
                "score": group.score,
                "criterion": group.criterion,
                "si_sdri": group.si_sdri,
                "accepted": group.accepted,
                "target": group.target,
            }
            for group in groups
        ],
    }


def _asked(asked: Asked) -> dict[str, Any]:
    return {
        "at": asked.at,
        "from": None if asked.sender is None else str(asked.sender),
        "command": asked.command,
        "numbers": list(_said(asked.numbers)),
        "answers": [asdict(answer) for answer in asked.answers],
    }


def _said(numbers: tuple[float, ...]) -> Iterator[float | None]:
    """Yield a command's numbers without the zeros at the end; null is NaN."""
    size = max((place + 1 for place, number in enumerate(numbers) if number != 0), default=0)
    return (number if math.isfinite(number) else None for number in numbers[:size])
