"""Messages of our dialect as JSON: the fields as they are on the wire, and JSON Schemas that say what they mean."""

from __future__ import annotations

from typing import Any

from ross_payload.json_values import finite
from ross_protocols.mavlink.dialect import ross
from ross_protocols.mavlink.message_map import LAYOUTS, Field, Layout
from ross_protocols.mavlink.tunnel import OURS

OUR_LAYOUTS: dict[str, Layout] = {
    layout.message.msgname: layout for layout in LAYOUTS if layout.message.msgname.startswith(OURS)
}  # by message name
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
