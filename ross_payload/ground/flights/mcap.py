"""A flight as an MCAP file: Foxglove's standard messages, and our own as JSON. Nothing is sent anywhere.

Of our own messages it has the fields as they are on the wire, and JSON Schemas that say what they mean. The frames
themselves are attached as a telemetry log, so that the page plays the file as it plays the flight.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any, BinaryIO, cast

import numpy as np
from foxglove import Channel, Context, Schema, open_mcap
from foxglove.channels import (
    FrameTransformChannel,
    LocationFixChannel,
    LogChannel,
    PoseInFrameChannel,
    SceneUpdateChannel,
)
from foxglove.mcap import MCAPWriteOptions
from foxglove.messages import Log, LogLevel, Timestamp

from ross_payload.atomic_files import replacing
from ross_payload.errors import refused_as
from ross_payload.ground.errors import GroundError
from ross_payload.ground.flights import scene
from ross_payload.ground.flights.mcap_sound import RecordedSound
from ross_payload.ground.flights.playback import relevant_frames
from ross_payload.ground.flights.reading import Flight
from ross_payload.ground.model.fleet import Fleet
from ross_payload.ground.model.payload_state import PayloadState, StatusText
from ross_payload.json_values import encodable, finite
from ross_protocols.mavlink.codec import Packet
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import ross
from ross_protocols.mavlink.message_map import LAYOUTS, Field, Layout
from ross_protocols.mavlink.tunnel import OURS, unwrapped

LEVELS = {2: LogLevel.Fatal, 3: LogLevel.Error, 4: LogLevel.Warning, 7: LogLevel.Debug}  # by MAV_SEVERITY
OUR_LAYOUTS: dict[str, Layout] = {
    layout.message.msgname: layout for layout in LAYOUTS if layout.message.msgname.startswith(OURS)
}  # by message name
OWN = 0o600  # who may read it: sound in it is what people have said
LOG_NAME, LOG_TYPE = "telemetry.tlog", "application/octet-stream"
KINDS = {"char": "string", "float": "number", "double": "number"}


def schema(name: str) -> dict[str, Any]:
    """Return the JSON Schema of a message; a field may be null when the dialect has a value for not known.

    >>> schema("ROSS_STATUS")["properties"]["heading"]
    {'type': ['number', 'null'], 'description': '[rad]'}
    """
    message = OUR_LAYOUTS[name].message
    lengths = dict(zip(message.ordered_fieldnames, message.array_lengths, strict=True))
    kinds = dict(zip(message.fieldnames, message.fieldtypes, strict=True))
    return {
        "title": name,
        "description": "As on the wire: angles are clockwise seen from above. null: not known.",
        "type": "object",
        "properties": {field: _property(message, field, kinds[field], lengths[field]) for field in kinds},
    }


def as_json(name: str, message: Any) -> dict[str, Any]:
    """Return the fields of a message; what is not known, or is no number, is null."""
    layout = OUR_LAYOUTS[name]
    value = layout.read(message)
    fields: dict[str, Any] = {}
    for wire in message.fieldnames:
        field = layout.fields[wire]
        unknown = isinstance(field, Field) and getattr(value, field.attribute) is None
        fields[wire] = None if unknown else finite(getattr(message, wire))
    return fields


def _property(message: Any, field: str, kind: str, length: int) -> dict[str, Any]:
    about = _about(message, field)
    if kind == "char":
        return {"type": "string", **about}
    item = KINDS.get(kind, "integer")
    if length:
        return {"type": "array", "items": {"type": [item, "null"]}, **about}
    return {"type": [item, "null"], **about}


def _about(message: Any, field: str) -> dict[str, str]:
    """Describe unit and entries of a field."""
    unit = message.fieldunits_by_name.get(field)
    enum = message.fieldenums_by_name.get(field)
    words = [f"[{unit}]"] if unit else []
    if enum:
        entries = ross.enums[enum].items()
        names = (f"{number} {entry.name.removeprefix(enum + '_').lower()}" for number, entry in entries)
        words.append(f"{enum}: {', '.join(name for name in names if not name.endswith(' enum_end'))}")
    return {"description": " ".join(words)} if words else {}


def export(flight: Flight, payloads: tuple[ComponentId, ...], path: Path) -> None:
    """Write a flight as MCAP, for its owner alone; the same bytes for the same flight.

    Times are UNIX time, or count from the first frame when the log does not know it.

    Raises
    ------
    GroundError
        When the file cannot be written.
    """
    context = Context()
    options = MCAPWriteOptions(profile="", compression_threads=0, disable_seeking=True)
    about = {"flight": encodable(flight.name), "time": "since the first frame" if flight.start is None else "UNIX"}
    with refused_as(GroundError, f"{path}: cannot be written"), replacing(path, OWN) as aside, aside.open("wb") as raw:
        file = _File(raw)
        with open_mcap(cast(BinaryIO, file), context=context, writer_options=options) as writer:
            writer.write_metadata("ross", about)
            exported = _Export(flight, payloads, context)
            sound = RecordedSound(flight, context)
            for at, packet in flight.packets(relevant_frames(flight, payloads)):
                sound.until(at)
                exported.on_packet(packet, at)
            exported.end(flight.duration)
            sound.until(math.inf)
            when = round((flight.start or 0.0) * 1e9)
            writer.attach(
                log_time=when, create_time=when, name=LOG_NAME, media_type=LOG_TYPE, data=_log_of(flight, payloads)
            )
        file.check()


def _log_of(flight: Flight, payloads: tuple[ComponentId, ...]) -> bytes:
    """Return what the page knows payloads by, as a telemetry log; its first frame is that of the flight."""
    which = np.union1d([0], relevant_frames(flight, payloads))
    index = flight.index
    return b"".join(
        usec.to_bytes(8, "big") + flight.file.read(start, size)
        for usec, start, size in zip(
            index.usec[which].tolist(), index.start[which].tolist(), index.size[which].tolist(), strict=True
        )
    )


class _File:
    """A file whose first error waits until `check`: the library would print one for every message."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self._error: OSError | None = None
        self._size = 0

    def write(self, data: bytes) -> int:
        """Take all of it."""
        try:
            if self._error is None:
                self._file.write(data)
        except OSError as error:
            self._error = error
        self._size += len(data)
        return len(data)

    def seek(self, offset: int, whence: int = 0) -> int:
        """Stay at the end: the library only asks where that is."""
        return self._size

    def flush(self) -> None:
        """Leave that to `check`."""

    def check(self) -> None:
        """Raise what went wrong, if anything did."""
        if self._error is not None:
            raise self._error
        self._file.flush()


class _Export:
    """Says what is new after every packet, on a channel for each kind of thing."""

    def __init__(self, flight: Flight, payloads: tuple[ComponentId, ...], context: Context) -> None:
        self._start = flight.start or 0.0
        self._payloads = payloads
        self._context = context
        self._channels: dict[str, Any] = {}
        self._fleet = Fleet()

    def on_packet(self, packet: Packet, at: float) -> None:
        """Take a packet that came ``at`` a time [s] since the first."""
        who = packet.sender
        now = round((self._start + at) * 1e6) * 1000
        before, place = self._fleet.payloads.get(who), self._fleet.vehicles.get(packet.system_id)
        self._fleet.on_packet(packet, at)
        after, there = self._fleet.payloads.get(who), self._fleet.vehicles.get(packet.system_id)
        if there is not None and there is not place:
            fix = scene.location(there.system, there.position, _stamp(now))
            self._publish(LocationFixChannel, f"/vehicle-{there.system}/location", fix, now)
        if after is not None and who in self._payloads:
            self._wire(who, packet, now)
            self._news(before, after, now)

    def end(self, at: float) -> None:
        """Learn that nothing comes after a time [s]: texts whose rest was lost are told as they are."""
        known = dict(self._fleet.payloads)
        self._fleet.end(at)
        for who in sorted(known.keys() & set(self._payloads)):
            self._news(known[who], self._fleet.payloads[who], round((self._start + at) * 1e6) * 1000)

    def _wire(self, who: ComponentId, packet: Packet, now: int) -> None:
        content = unwrapped(packet)
        if content is None or content.name not in OUR_LAYOUTS:
            return
        topic = f"/{who}/{content.name}"
        if topic not in self._channels:
            about = Schema(name=content.name, encoding="jsonschema", data=json.dumps(schema(content.name)).encode())
            self._channels[topic] = Channel(topic, schema=about, message_encoding="json", context=self._context)
        text = json.dumps(as_json(content.name, content.message), allow_nan=False)
        self._channels[topic].log(text, log_time=now)

    def _news(self, before: PayloadState | None, after: PayloadState, now: int) -> None:
        who, stamp = after.who, _stamp(now)
        if after.status is not None and (before is None or before.status is not after.status):
            for transform in scene.transforms(who, after.status, stamp):
                self._publish(FrameTransformChannel, "/tf", transform, now)
            pose = scene.heading(who, after.status, stamp)
            if pose is not None:
                self._publish(PoseInFrameChannel, f"/{who}/heading", pose, now)
        if after.sources != (before.sources if before else ()):
            self._publish(SceneUpdateChannel, f"/{who}/scene", scene.sources(after, stamp), now)
        for text in after.texts_since(before):
            self._publish(LogChannel, f"/{who}/log", _log(who, text, stamp), now)

    def _publish(self, kind: Any, topic: str, message: Any, now: int) -> None:
        if topic not in self._channels:
            self._channels[topic] = kind(topic, context=self._context)
        self._channels[topic].log(message, log_time=now)


def _log(who: ComponentId, text: StatusText, at: Timestamp) -> Log:
    level = LEVELS.get(text.severity, LogLevel.Info if text.severity > 2 else LogLevel.Fatal)
    return Log(timestamp=at, level=level, message=text.text, name=str(who), file="", line=0)


def _stamp(nanoseconds: int) -> Timestamp:
    return Timestamp(sec=nanoseconds // 10**9, nsec=nanoseconds % 10**9)
