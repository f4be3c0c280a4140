"""Electronic data sheets of CANopen devices (CiA 306): text to the entries of an object dictionary."""

from __future__ import annotations

import re
from configparser import RawConfigParser
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

from ross_protocols.canopen.frames import Item

FORMATS = {0x01: "?", 0x02: "b", 0x03: "h", 0x04: "i", 0x05: "B", 0x06: "H", 0x07: "I"}  # of numbers, by data type
_ENTRY = re.compile(r"([0-9A-Fa-f]{4})(?:sub([0-9A-Fa-f]+))?")


@dataclass(frozen=True, slots=True)
class Entry:
    """One number of an object dictionary."""

    item: Item
    name: str
    access: str  # ro, wo, rw, rww, rwr or const
    default: int = 0
    lowest: int | None = None
    highest: int | None = None
    mappable: bool = False

    @property
    def writable(self) -> bool:
        """Whether it can be written."""
        return "w" in self.access

    @property
    def readable(self) -> bool:
        """Whether it can be read."""
        return self.access != "wo"


def entries_of(text: str, node: int) -> dict[tuple[int, int], Entry]:
    r"""Return the numbers of a data sheet for a node, by index and subindex; strings and domains are left out.

    >>> sheet = "[1014]\nParameterName=EMCY\nDataType=0x0007\nAccessType=ro\nDefaultValue=$NODEID+0x80"
    >>> entries_of(sheet, 5)[0x1014, 0].default
    133
    """
    sheet = RawConfigParser(inline_comment_prefixes=(";",))
    sheet.read_string(text)
    entries = {}
    for name in sheet.sections():
        found = _ENTRY.fullmatch(name)
        entry = _entry(int(found[1], 16), int(found[2] or "0", 16), dict(sheet[name]), node) if found else None
        if entry:
            entries[entry.item.index, entry.item.sub] = entry
    return entries


def data_sheet(name: str) -> str:
    """Return the text of a data sheet that comes with the payload."""
    installed = Path(str(files("ross_protocols"))) / "data" / "canopen"
    folder = installed if installed.is_dir() else Path(__file__).parents[2] / "canopen"
    return (folder / f"{name}.eds").read_text(encoding="ascii")


def _entry(index: int, sub: int, keys: dict[str, str], node: int) -> Entry | None:
    """Make an entry of the keys of its section, None when it is no number."""
    kind = FORMATS.get(int(keys.get("datatype", "0"), 0))
    if kind is None:
        return None
    lowest, highest = (_number(keys[key], node) if keys.get(key) else None for key in ("lowlimit", "highlimit"))
    default = _number(keys.get("defaultvalue") or "0", node)
    mappable = keys.get("pdomapping", "0") == "1"
    return Entry(Item(index, sub, kind), keys["parametername"], keys["accesstype"], default, lowest, highest, mappable)


def _number(text: str, node: int) -> int:
    """Return a number that may be relative to the node's."""
    plain = text.upper().replace(" ", "").replace("$NODEID", "").strip("+")
    return int(plain or "0", 0) + (node if "$NODEID" in text.upper() else 0)
