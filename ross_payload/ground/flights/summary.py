"""A whole flight as plain JSON. Angles are degrees, clockwise, as in `ross_payload.ground.model.view`."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

import numpy as np

from ross_payload.ground.errors import GroundError
from ross_payload.ground.flights import mission_timeline
from ross_payload.ground.flights.bookmarks import TEXT
from ross_payload.ground.flights.command_log import COMMAND_MESSAGES, CommandLog, LoggedCommand
from ross_payload.ground.flights.frame_stats import FrameStats, tallies
from ross_payload.ground.flights.reading import Flight
from ross_payload.ground.model.fleet import Fleet
from ross_payload.ground.model.payload_state import StatusText
from ross_payload.ground.model.state_reducer import is_sane
from ross_payload.ground.model.status_text import PREFIX
from ross_payload.ground.model.stream_rows import stream_row
from ross_payload.ground.model.view import candidate_row, group_row, source_row, word
from ross_protocols.mavlink.codec import Packet
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.tunnel import unwrapped
from ross_protocols.mavlink.values import Source, Text


class FlightContent:
    """Everything that the payloads of a flight did and were asked."""

    def __init__(self, flight: Flight, payloads: tuple[ComponentId, ...]) -> None:
        self.flight, self.payloads = flight, payloads
        self.timelines = {who: mission_timeline.MissionTimeline(who) for who in payloads}
        self.texts: dict[ComponentId, list[StatusText]] = {who: [] for who in payloads}
        self.commands = CommandLog()
        self._fleet = Fleet()  # puts texts together
        for at, packet in flight.packets(_worth_reading(flight, payloads)):
            self._on_packet(packet, at)
        before = dict(self._fleet.payloads)
        self._fleet.end(flight.duration)
        for who, known in self._fleet.payloads.items():
            self.texts[who] += known.texts_since(before[who])
            self.texts[who].sort(key=lambda text: text.at)

    def _on_packet(self, packet: Packet, at: float) -> None:
        self.commands.on_packet(packet, at, self.payloads)
        timeline = self.timelines.get(packet.sender)
        if timeline is None:
            return
        inner = unwrapped(packet)
        value = None if inner is None else inner.value
        if isinstance(value, Text) or timeline.who not in self._fleet.payloads:
            before = self._fleet.payloads.get(timeline.who)
            self._fleet.on_packet(packet, at)
            after = self._fleet.payloads.get(timeline.who)
            if after is not None:
                self.texts[timeline.who].extend(after.texts_since(before))
        if value is not None and is_sane(value):
            timeline.on_value(value, at)


def chosen(flight: Flight, payload: ComponentId | None) -> tuple[ComponentId, ...]:
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


def summary(content: FlightContent) -> dict[str, Any]:
    """Return the flight as JSON."""
    flight, counted = content.flight, tallies(content.flight)
    others = [_counts(counted[who]) for who in sorted(counted) if who not in flight.payloads]
    whole = {
        "name": flight.name,
        "start": flight.start,
        "duration": flight.duration,
        "frames": len(flight.index),
        "notes": list(flight.notes),
        "payloads": [_payload(content, who, counted[who]) for who in content.payloads],
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


def _worth_reading(flight: Flight, payloads: tuple[ComponentId, ...]) -> Any:
    index = flight.index
    mine = index.sent_by(*payloads)
    telling = mine & np.isin(index.message, [*mission_timeline.TIMELINE_MESSAGES, TEXT])
    return np.flatnonzero(telling | np.isin(index.message, COMMAND_MESSAGES))


def _payload(content: FlightContent, who: ComponentId, counted: FrameStats) -> dict[str, Any]:
    timeline = content.timelines[who]
    known = timeline.information
    return {
        **_counts(counted),
        "actuator": known.actuator if known else None,
        "version": known.software_version if known else None,
        "dialect": known.dialect_version if known else None,
        "earth": timeline.status.earth if timeline.status else None,
        "states": [
            {"at": stay.at, "state": word("ROSS_STATE", stay.state), "duration": stay.until - stay.at}
            for stay in timeline.states
        ],
        "explorations": [_exploration(each) for each in timeline.explorations],
        "sources": [_source(each) for _, each in sorted(timeline.sources.items())],
        "alignments": [_tried(each) for each in timeline.tried.values()],
        "separations": [_separated(each) for each in timeline.separated.values()],
        "streams": [_stream(each) for each in timeline.streams],
        "events": [
            {"at": text.at, "severity": text.severity, "text": text.text.removeprefix(PREFIX)}
            for text in content.texts[who]
        ],
        "commands": [_asked(each) for each in content.commands.asked(who)],
    }


def _counts(counted: FrameStats) -> dict[str, Any]:
    kinds = [asdict(kind) for kind in counted.kinds]
    return {**asdict(counted), "who": str(counted.who), "kinds": kinds, "gaps": [asdict(gap) for gap in counted.gaps]}


def _exploration(explored: mission_timeline.Exploration) -> dict[str, Any]:
    return {
        "at": explored.at,
        "duration": explored.until - explored.at,
        "rotations": explored.rotations,
        "k": [list(pair) for pair in explored.k],
        "final": explored.final,
        "sources": [_source(each) for _, each in sorted(explored.sources.items())],
    }


def _part(row: dict[str, Any], keys: str) -> dict[str, Any]:
    return {key: row[key] for key in keys.split()}


def _source(source: Source) -> dict[str, Any]:
    return _part(source_row(source), "source azimuth mirror sigma confidence score resolved target")


def _tried(tried: mission_timeline.TriedCandidate) -> dict[str, Any]:
    row = candidate_row(tried.candidate)
    shown = "candidate source heading isolation_us gain aliased rule state"
    return {"at": tried.at, "plan": tried.candidate.plan, **_part(row, shown)}


def _separated(separated: mission_timeline.TimedSeparation) -> dict[str, Any]:
    groups = [each for _, each in sorted(separated.groups.items())]
    rows = [group_row(group) for group in groups]
    return {
        "at": separated.at,
        "separation": groups[0].separation,
        **_part(rows[0], "phase method heading"),
        "groups": [_part(row, "group members score criterion si_sdri accepted target") for row in rows],
    }


def _stream(span: mission_timeline.StreamSpan) -> dict[str, Any]:
    shown = "number whom place sink codec words lost packets_lost records"
    return {"at": span.at, "duration": span.until - span.at, **_part(stream_row(span.stream), shown)}


def _asked(asked: LoggedCommand) -> dict[str, Any]:
    return {
        "at": asked.at,
        "from": None if asked.sender is None else str(asked.sender),
        "command": asked.command,
        "numbers": list(_numbers(asked.numbers)),
        "answers": [asdict(answer) for answer in asked.answers],
    }


def _numbers(numbers: tuple[float, ...]) -> Iterator[float | None]:
    """Yield a command's numbers without the zeros at the end; null is NaN."""
    size = max((place + 1 for place, number in enumerate(numbers) if number != 0), default=0)
    return (number if math.isfinite(number) else None for number in numbers[:size])
