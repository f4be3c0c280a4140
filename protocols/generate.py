"""Generate what follows from the files in mavlink/.

``python protocols/generate.py [FOLDER]`` writes one Python module of both, ``ross_dialect.py``, the reference page
``mavlink.md``, Wireshark's ``ross.lua`` and C headers, ``mavlink-c/``, to their places in the checkout or, when a
folder is given, there. The C headers are not checked in.
"""

from __future__ import annotations

import contextlib
import io
import re
import sys
from argparse import Namespace
from pathlib import Path
from typing import Any

from pymavlink.generator import mavgen, mavparse

import others

HERE = Path(__file__).resolve().parent
XML = HERE / "mavlink" / "ross.xml"
STANDARD = HERE / "mavlink" / "standard.xml"

INTRODUCTION = """\
# MAVLink messages

% Generated from protocols/mavlink/ross.xml by protocols/generate.py: edit those.

Every message, enumeration and command of the payload's own dialect, for those who write software against it. How to
send the commands is in [command the payload](../how-to/command-the-payload.md), what the texts mean in
[troubleshooting](troubleshooting.md#messages-to-the-operator).

The payload is a MAVLink 2 component: `MAV_TYPE_ONBOARD_CONTROLLER`, no autopilot, component
`MAV_COMP_ID_ONBOARD_COMPUTER` (191, configurable). It sends

- `HEARTBEAT` every second, and when the state changes. `custom_mode` is the mission's [state](#ross-state);
  `system_status` is `BOOT` before the mission runs, `CALIBRATING` while it measures the noise, `STANDBY` when it is
  idle or over, `ACTIVE` while it listens and turns, `CRITICAL` after a fault;
- `STATUSTEXT` when something happens that an operator wants to know, not more often than once in 2 s in the long run,
  but for errors, which are always sent;
- `NAMED_VALUE_FLOAT` and `DEBUG_FLOAT_ARRAY` with the most important numbers, for
  [ground stations](../how-to/ground-stations.md) without our dialect;
- `ONBOARD_COMPUTER_STATUS` every 5 s, from `ross run`: the load of each core, memory, the hottest thermal zone, the
  disk of the recordings. Not on links below 800 bytes/s, where it finds no room;
- the messages below. Their dialect is `protocols/mavlink/ross.xml`; it needs no other file. On links with the role
  `autopilot` each is sent inside a `TUNNEL` of the type [ROSS_TUNNEL_TYPE_FRAME](#ross-tunnel-type): one whole frame.

Rates are those of a link that can carry all; `MAV_CMD_SET_MESSAGE_INTERVAL` changes them on the link that it comes
from.

**Angles** are radians, clockwise seen from above and in (-pi, pi], from north in `ROSS_FRAME_EARTH` and from the zero
of the mount in `ROSS_FRAME_MOUNT`; joint angles are clockwise too but not wrapped. Inside the payload angles are
counter-clockwise; only `ross_protocols` converts them.

**To draw the scene**, take the axis from `ROSS_STATUS.heading` and draw it both ways, since two microphones have no
front; per `ROSS_SOURCE` a wedge of `azimuth` plus and minus `azimuth_sigma`, a second one at `azimuth_mirror` when that
is a number; the headings that will be tried next are in `ROSS_ALIGNMENT`. Drop sources whose `estimate` is not the
latest. A message that is repeated keeps the time at which its content was found.

**Who listens** is in `ROSS_STREAM`, one message per stream, and in two flags of `ROSS_STATUS`. Sound leaves the payload
only by a command or by its configuration: [listen live](../how-to/command-the-payload.md#listen-live).

**Numbers that are not known** are sent as the value in the column *invalid*. **Versions** understand each other: fields
are only ever added, as extensions at the end; a test compares the checksum (CRC_EXTRA) of every message with a table.
"""


def generate(language: str, output: Path, *files: Path) -> None:
    """Run mavgen: MAVLink 2, units checked against the schema's list."""
    options = Namespace(output=str(output), language=language, wire_protocol="2.0", validate=True, strict_units=True)
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        done = mavgen.mavgen(options, [str(file) for file in files])
    if not done:
        sys.exit(f"{files[0].name} is not a valid dialect:\n{said.getvalue()}")


def reference(folder: Path) -> None:
    """Write ``mavlink.md``: every message and every enumeration as a table."""
    xml = mavparse.MAVXML(str(XML), mavparse.PROTOCOL_2_0)
    parts = [INTRODUCTION, "## Messages\n", *map(_message, xml.message), "## Enumerations\n", *map(_enum, xml.enum)]
    (folder / "mavlink.md").write_text("\n".join(parts), encoding="utf-8")


def _message(message: Any) -> str:
    known = len(message.fields) if message.extensions_start is None else message.extensions_start
    fields = [_field(field, added=index >= known) for index, field in enumerate(message.fields)]
    head = (
        f"### {message.name} ({message.id})\n\n{_line(message.description)}\n\n"
        f"{message.wire_length} bytes, CRC_EXTRA {message.crc_extra}.\n\n"
        "| field | type | unit | invalid | meaning |\n|---|---|---|---|---|\n"
    )
    return head + "".join(f"| {' | '.join(field)} |\n" for field in fields)


def _field(field: Any, *, added: bool) -> tuple[str, ...]:
    kind = field.type + (f"[{field.array_length}]" if field.array_length else "")
    meaning = _line(field.description)
    if field.enum:
        meaning += f" [{field.enum}](#{_anchor(field.enum)})"
    if field.instance:
        meaning += " *Instance.*"
    if added:
        meaning += " *Extension.*"
    return f"`{field.name}`", kind, field.units.strip("[]"), field.invalid, meaning


def _enum(enum: Any) -> str:
    head = (
        f"({_anchor(enum.name)})=\n### {enum.name}\n\n{_line(enum.description)}{' Bitmask.' * bool(enum.bitmask)}\n\n"
    )
    entries = [entry for entry in enum.entry if not entry.name.endswith("_ENUM_END")]
    rows = "".join(f"| {entry.value} | `{entry.name}` | {_meaning(entry)} |\n" for entry in entries)
    return f"{head}| value | name | meaning |\n|---|---|---|\n{rows}"


def _meaning(entry: Any) -> str:
    """Say what an entry means; of a command also what its numbers are."""
    numbers = [p for p in entry.param if p.label]
    return "<br>".join([_line(entry.description), *map(_number, numbers)])


def _number(param: Any) -> str:
    unit = f" [{param.units}]" if param.units else ""
    span = f", {param.minValue} to {param.maxValue}" if param.minValue and param.maxValue else ""
    choice = f" [{param.enum}](#{_anchor(param.enum)})" if param.enum else ""
    return f"{param.index}: {param.label}{unit}{span}. {_line(param.description)}{choice}"


def _line(text: str) -> str:
    return re.sub(r"\s+", " ", text).strip()


def _anchor(name: str) -> str:
    return name.lower().replace("_", "-")


def main(folder: Path | None) -> None:
    """Write everything, into one folder or to its places."""
    generate("Python3", (folder or HERE / "ross_protocols" / "mavlink") / "ross_dialect.py", XML, STANDARD)
    reference(folder or HERE.parent / "docs" / "reference")
    others.dissector(folder or HERE / "wireshark", generate)
    others.c_headers((folder or HERE.parent / "build") / "mavlink-c", generate)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else None)
