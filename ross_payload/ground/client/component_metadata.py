"""What a payload tells about its parameters: component metadata over MAVLink FTP. No port, no clock.

COMPONENT_METADATA names ``general.json``, that names ``parameter.json``; the checksum of each is checked. Nothing in
these files is trusted: what is not as wanted is left out, and a note says so. Texts stay plain texts.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ross_payload.ground.client.ftp_client import FileReader
from ross_protocols.mavlink.codec import Packet
from ross_protocols.mavlink.commands import Acknowledged, Result, acknowledged_of, long_message
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common, ross
from ross_protocols.mavlink.ftp import checksum

MESSAGE = ross.MAVLINK_MSG_ID_COMPONENT_METADATA
REQUEST = common.MAV_CMD_REQUEST_MESSAGE
SCHEME = "mftp://"
TYPE_PARAMETER = 1  # COMP_METADATA_TYPE
REQUEST_TIMEOUT_S, MOST_REQUESTS = 2.0, 5  # [s] between two requests, and how many
MOST_READS = 3  # times that a file with a wrong checksum is read
MOST_PARAMETERS, MOST_TEXT = 1000, 500
NOTHING_TOLD = "the payload provides no parameter metadata"


@dataclass(frozen=True, slots=True)
class ParameterDescription:
    """What one parameter means; None and '' are not told."""

    default: float | None = None
    min: float | None = None
    max: float | None = None
    unit: str = ""
    description: str = ""
    group: str = ""
    whole: bool = False


@dataclass(frozen=True, slots=True)
class FileLocation:
    """Where a file is, and its checksum; None: not told."""

    path: str
    crc: int | None


class Metadata:
    """Fetches what one payload tells about its parameters; it begins with the first `tick`.

    ``described`` is by name, ``note`` says what is wrong, ``over`` that no more will come.
    """

    def __init__(self, send: Callable[[Any], None], who: ComponentId, system_id: int, component_id: int) -> None:
        self.described: dict[str, ParameterDescription] = {}
        self.note = ""
        self.over = False
        self._send = send
        self._who = who
        self._us = ComponentId(system_id, component_id)
        self._asked = self._read = 0
        self._due = -math.inf
        self._place: FileLocation | None = None
        self._reading: FileReader | None = None
        self._then: Callable[[bytes], None] = self._general

    def tick(self, now: float) -> None:
        """Ask for what has not come."""
        if self.over:
            return
        if self._reading is not None:
            self._reading.tick(now)
            self._look()
        elif now >= self._due:
            self._ask(now)

    def on_packet(self, packet: Packet, now: float) -> None:
        """Take a packet; what is not for us passes by."""
        if self.over or packet.sender != self._who:
            return
        if self._reading is not None:
            self._reading.on_packet(packet, now)
            self._look()
        elif packet.message.get_msgId() == MESSAGE:
            self._begin(place_of(packet.message.uri, packet.message.file_crc), self._general)
        elif self._denied(acknowledged_of(packet.message)):
            self._end(NOTHING_TOLD)

    def _denied(self, ack: Acknowledged | None) -> bool:
        if ack is None or ack.number != REQUEST or not ack.target.includes(self._us):
            return False
        return ack.result in (Result.DENIED, Result.UNSUPPORTED)

    def _ask(self, now: float) -> None:
        if self._asked == MOST_REQUESTS:
            self._end(NOTHING_TOLD)
            return
        self._send(long_message(REQUEST, (MESSAGE,), self._who))
        self._asked, self._due = self._asked + 1, now + REQUEST_TIMEOUT_S

    def _begin(self, place: FileLocation | str, then: Callable[[bytes], None]) -> None:
        if isinstance(place, str):
            self._end(place)
            return
        sequence = 0 if self._reading is None else self._reading.sequence
        if place != self._place:
            self._read = 0
        self._place, self._then, self._read = place, then, self._read + 1
        self._reading = FileReader(self._send, self._who, self._us, place.path, sequence)

    def _look(self) -> None:
        """Go on when a file is there."""
        reading, place = self._reading, self._place
        if reading is None or place is None or not reading.over:
            return
        if reading.content is None:
            self._end(reading.trouble)
        elif place.crc in (None, checksum(reading.content)):
            self._then(reading.content)
        elif self._read < MOST_READS:
            self._begin(place, self._then)
        else:
            self._end(f"{place.path}: its checksum is wrong")

    def _general(self, content: bytes) -> None:
        self._begin(parameter_place(content), self._parameters)

    def _parameters(self, content: bytes) -> None:
        self.described, note = described_in(content)
        self._end(note)

    def _end(self, note: str) -> None:
        self.over, self.note = True, note


def place_of(uri: Any, crc: Any) -> FileLocation | str:
    """Return where a URI points to, or why it cannot be followed.

    >>> place_of("mftp:///general.json", 7), place_of("https://example.org/general.json", 7)
    (FileLocation(path='/general.json', crc=7), 'https://example.org/general.json: only mftp:// is fetched')
    """
    text = uri.split(b"\0")[0].decode("ascii", "replace") if isinstance(uri, bytes) else uri
    if not isinstance(text, str) or not text.startswith(SCHEME):
        return f"{plain(text) or 'no place'}: only {SCHEME} is fetched"
    whole = isinstance(crc, int) and not isinstance(crc, bool)
    path = text.removeprefix(SCHEME)
    inside = path.partition("]")[2] if path.startswith("[") else path  # [;comp=191]: the component that we ask anyhow
    return FileLocation(inside, int(crc) if whole else None)


def parameter_place(content: bytes) -> FileLocation | str:
    """Return where ``general.json`` says that parameters are described, or why it does not."""
    document = _json(content)
    entries = document.get("metadataTypes") if isinstance(document, dict) else None
    for entry in entries if isinstance(entries, list) else []:
        if isinstance(entry, dict) and entry.get("type") == TYPE_PARAMETER:
            return place_of(entry.get("uri"), entry.get("fileCrc"))
    return NOTHING_TOLD


def described_in(content: bytes) -> tuple[dict[str, ParameterDescription], str]:
    """Return what ``parameter.json`` tells of every parameter, and a note on what was left out."""
    document = _json(content)
    rows = document.get("parameters") if isinstance(document, dict) else None
    if not isinstance(rows, list):
        return {}, "the parameter metadata of the payload cannot be read"
    named = {row["name"]: row for row in rows if isinstance(row, dict) and isinstance(row.get("name"), str)}
    kept = list(named.items())[:MOST_PARAMETERS]
    left_out = len(rows) - len(kept)
    return {name: _described(row) for name, row in kept}, f"{left_out} descriptions left out" if left_out else ""


def plain(text: Any) -> str:
    """Return a text without control characters, not too long; anything else is no text."""
    shown = "".join(letter if letter.isprintable() else " " for letter in text) if isinstance(text, str) else ""
    return shown.strip()[:MOST_TEXT]


def _described(row: dict[str, Any]) -> ParameterDescription:
    words = [plain(row.get(key)).rstrip(".") for key in ("shortDesc", "longDesc")]
    return ParameterDescription(
        default=_number(row.get("default")),
        min=_number(row.get("min")),
        max=_number(row.get("max")),
        unit=plain(row.get("units")),
        description=". ".join(filter(None, words)),
        group=plain(row.get("group")),
        whole=row.get("decimalPlaces") == 0,
    )


def _number(value: Any) -> float | None:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    try:
        number = float(value)
    except OverflowError:
        return None
    return number if math.isfinite(number) else None


def _json(content: bytes) -> Any:
    try:
        return json.loads(content)
    except (ValueError, RecursionError):
        return None
