"""Who commanded what, and which frames say again what was said before."""

from __future__ import annotations

import math
from collections import OrderedDict
from dataclasses import dataclass

from ross_payload.orders import Order
from ross_protocols.commands import Command, Result

RESENT = 5.0  # [s] within which a confirmation above 0 means the same command
LATE = 2.0  # [s] within which sequence numbers tell which of two frames was sent first
BEHIND = 64  # sequence numbers
MOST = 256  # commands that are remembered: random senders cannot fill the memory

Sender = tuple[int, int]  # system id, component id


@dataclass(slots=True)
class Entry:
    """The latest command of one number from one sender, and what has become of it."""

    command: Command
    sender: Sender
    sequence: int  # of its latest frame
    time: float  # of its latest frame, or of its end [s]
    result: Result = Result.IN_PROGRESS
    progress: float | None = None  # 0 to 1
    order: Order | None = None  # while the mission has it
    due: float = math.inf  # when the sender is told next [s]
    cancelled: bool = False  # somebody has asked to cancel it


class Ledger:
    """The latest commands, one per sender and number."""

    def __init__(self) -> None:
        self._entries: OrderedDict[tuple[Sender, int], Entry] = OrderedDict()

    def find(self, sender: Sender, number: int) -> Entry | None:
        """Return the latest command of a number from a sender."""
        return self._entries.get((sender, number))

    def note(self, entry: Entry) -> Entry | None:
        """Remember a command in the place of its like; return that one."""
        key = entry.sender, entry.command.number
        before = self._entries.pop(key, None)
        self._entries[key] = entry
        if len(self._entries) > MOST:
            self._entries.popitem(last=False)
        return before

    def repeated(self, command: Command, sender: Sender, sequence: int, now: float) -> Entry | None:
        """Return the entry that a frame only repeats: sent again, or doubled or delayed on its way."""
        entry = self.find(sender, command.number)
        if entry is None or not alike(entry.command, command):
            return None
        age, going_on = now - entry.time, entry.order is not None
        again = command.confirmation > 0 and (going_on or age < RESENT)
        again |= not command.long and going_on and age < RESENT  # it has no confirmation to tell
        if not again and not (age < LATE and (entry.sequence - sequence) % 256 < BEHIND):
            return None
        entry.time = now
        return entry

    def older(self, sender: Sender, number: int, sequence: int, now: float) -> bool:
        """Tell whether a frame was sent before the latest command of a number, though it arrives later."""
        entry = self.find(sender, number)
        return entry is not None and now - entry.time < LATE and 0 < (entry.sequence - sequence) % 256 < BEHIND


def alike(command: Command, other: Command) -> bool:
    """Tell whether two commands ask for the same; NaN is like NaN."""
    same = zip(command.numbers, other.numbers, strict=True)
    return command.number == other.number and all(a == b or (math.isnan(a) and math.isnan(b)) for a, b in same)
