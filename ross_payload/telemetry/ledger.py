"""Who commanded what, and which frames say again what was said before."""

from __future__ import annotations

import math
from collections import OrderedDict
from dataclasses import dataclass

from ross_payload.orders import Order
from ross_protocols.commands import Command, Result

RESENT = 5.0  # [s] within which a confirmation above 0 means the same command
LATE = 30.0  # [s] within which a frame may arrive late
ANEW = 0.5  # [s] of silence, after which a frame with the number 0 is the first of a sender that has started anew
MOST = 256  # commands, and senders, that are remembered: random ids cannot fill the memory

Sender = tuple[int, int]  # system id, component id


@dataclass(frozen=True, slots=True)
class Origin:
    """Where a frame came from, and its place among those that its sender has sent on a link."""

    sender: Sender
    link: str
    place: int

    def not_after(self, other: Origin) -> bool:
        """Tell whether this frame is known to have been sent before another one, or to be the same."""
        return self.link == other.link and self.place <= other.place


class Places:
    """Counts what every sender sends, beyond the 256 sequence numbers of MAVLink.

    >>> places = Places()
    >>> [places.note((255, 190), "udp", sequence, now=0.0).place for sequence in (254, 0, 255, 1)]
    [254, 256, 255, 257]
    >>> places.note((255, 190), "udp", 0, now=1.0).place
    512
    """

    def __init__(self) -> None:
        self._latest: OrderedDict[tuple[Sender, str], tuple[int, float]] = OrderedDict()  # place, when [s]

    def note(self, sender: Sender, link: str, sequence: int, now: float) -> Origin:
        """Return the origin of a frame; less than half a round ahead of the latest it is new, else it comes late.

        A script that is run once more counts from 0 again: that is new, too.
        """
        latest, heard = self._latest.pop((sender, link), (sequence, now))
        place = latest + (sequence - latest + 128) % 256 - 128
        if sequence == 0 and place <= latest and now - heard > ANEW:
            place += 256
        self._latest[sender, link] = max(latest, place), now
        if len(self._latest) > MOST:
            self._latest.popitem(last=False)
        return Origin(sender, link, place)


@dataclass(slots=True)
class Entry:
    """The latest command of one number from one sender, and what has become of it."""

    command: Command
    origin: Origin
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

    def note(self, entry: Entry) -> None:
        """Remember a command in the place of its like."""
        key = entry.origin.sender, entry.command.number
        self._entries.pop(key, None)
        self._entries[key] = entry
        if len(self._entries) > MOST:
            self._entries.popitem(last=False)

    def repeated(self, command: Command, origin: Origin, now: float) -> Entry | None:
        """Return the entry that a frame only repeats: sent again, or doubled or delayed on its way."""
        entry = self.find(origin.sender, command.number)
        if entry is None or not alike(entry.command, command):
            return None
        age, going_on = now - entry.time, entry.order is not None
        again = command.confirmation > 0 and (going_on or age < RESENT)
        again |= not command.long and going_on and age < RESENT  # it has no confirmation to tell
        if not again and not self.before(origin, command.number, now):
            return None
        entry.time = now
        return entry

    def before(self, origin: Origin, number: int, now: float) -> bool:
        """Tell whether a frame that arrives now was sent before the latest command of a number, or is that one."""
        entry = self.find(origin.sender, number)
        return entry is not None and now - entry.time < LATE and origin.not_after(entry.origin)


def alike(command: Command, other: Command) -> bool:
    """Tell whether two commands ask for the same; NaN is like NaN."""
    same = zip(command.numbers, other.numbers, strict=True)
    return command.number == other.number and all(a == b or (math.isnan(a) and math.isnan(b)) for a, b in same)
