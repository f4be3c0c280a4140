"""The object dictionary of the simulated CANopen drive, as its data sheet says."""

from __future__ import annotations

import struct
from collections.abc import Callable

from ross_protocols.canopen import sdo
from ross_protocols.canopen.eds import Entry, data_sheet, entries_of
from ross_protocols.canopen.frames import Item, mapped

MAPPINGS = (0x1600 >> 9, 0x1A00 >> 9)  # of process data to the drive and from it


class Objects:
    r"""Values by index and subindex; reads and writes from the bus are checked, those of the firmware are not.

    >>> objects = Objects(node=5)
    >>> objects.answer(sdo.Read(0x1000, 0))
    Value(index=4096, sub=0, data=b'\x92\x01\x02\x00')
    >>> print(objects.answer(sdo.Write(0x6041, 0, bytes(2))))
    it can only be read
    """

    def __init__(self, node: int) -> None:
        self.entries = entries_of(data_sheet("ross_drive"), node)
        self.written: Callable[[int, int], None] = lambda index, sub: None  # told what the bus has written
        self._values: dict[tuple[int, int], int] = {}
        self.reset()

    def reset(self) -> None:
        """Take the values of the data sheet."""
        self._values = {key: entry.default for key, entry in self.entries.items()}

    def __getitem__(self, item: Item) -> int:
        return self._values[item.index, item.sub]

    def __setitem__(self, item: Item, value: int) -> None:
        self._values[item.index, item.sub] = value

    def at(self, index: int, sub: int) -> int:
        """Return a value."""
        return self._values[index, sub]

    def item(self, index: int, sub: int) -> Item:
        """Return what an entry is."""
        return self.entries[index, sub].item

    def answer(self, asked: sdo.Read | sdo.Write) -> sdo.Value | sdo.Written | sdo.Abort:
        """Answer a read or write from the bus."""
        code = self._refusal(asked)
        if code:
            return sdo.Abort(asked.index, asked.sub, code)
        if isinstance(asked, sdo.Write):
            self.write(asked.index, asked.sub, self.item(asked.index, asked.sub).unpack(asked.data))
            return sdo.Written(asked.index, asked.sub)
        return sdo.Value(asked.index, asked.sub, self.data(asked.index, asked.sub))

    def data(self, index: int, sub: int) -> bytes:
        """Return an entry as bytes."""
        return self.item(index, sub).pack(self.at(index, sub))

    def write(self, index: int, sub: int, value: int) -> None:
        """Set an entry from the bus."""
        self._values[index, sub] = value
        self.written(index, sub)

    def _refusal(self, asked: sdo.Read | sdo.Write) -> int:
        """Return why a read or write is refused, else 0."""
        entry = self.entries.get((asked.index, asked.sub))
        if entry is None:
            return sdo.NO_SUBINDEX if any(index == asked.index for index, _ in self.entries) else sdo.NO_OBJECT
        if isinstance(asked, sdo.Read):
            return 0 if entry.readable else sdo.ONLY_WRITTEN
        return self._unfit(entry, asked.data) if entry.writable else sdo.ONLY_READ

    def _unfit(self, entry: Entry, data: bytes) -> int:
        try:
            value = entry.item.unpack(data)
        except struct.error:
            return sdo.WRONG_LENGTH
        maps = entry.item.index >> 9 in MAPPINGS and entry.item.sub > 0
        if maps and value and not self._mappable(value):
            return sdo.NOT_MAPPABLE
        if entry.lowest is not None and value < entry.lowest:
            return sdo.TOO_LOW
        return sdo.TOO_HIGH if entry.highest is not None and value > entry.highest else 0

    def _mappable(self, mapping: int) -> bool:
        index, sub, size = mapped(mapping)
        entry = self.entries.get((index, sub))
        return entry is not None and entry.mappable and entry.item.size == size
