"""Who commanded what, and which frames say again what was said before."""

from __future__ import annotations

import math
from collections import OrderedDict, deque
from collections.abc import Iterator
from dataclasses import dataclass, field

from ross_payload.mavlink.component import Way
from ross_payload.orders import Order, Task
from ross_protocols.mavlink.commands import HEARD, MOST_CONFIRMATION, Command, Result
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import ross

REARM = ross.MAV_CMD_ROSS_REARM
RESENT = 5.0  # [s] within which a confirmation above 0 means the same command
DOUBTED = 3.0  # [s] within which it does even when as many frames were lost as it says were sent before it
RESENT_EVERY = 1.0  # [s] from one frame of a command to the next: a new one cannot have reached a confirmation sooner
ON_THE_WAY = 0.5  # [s] by which the way of one frame may take longer than that of another
LATE = 30.0  # [s] within which a frame may arrive late
COPIED = 2.0  # [s] within which one may come on another link, too
RESTARTED_AFTER_S = (
    0.5  # [s] without a later frame, after which the number 0 is the first of a sender that has restarted
)
LOWER = 3.0  # [s] without a later frame, after which any lower number is one of such a sender
MOST_PAST = 4  # commands before the latest one of a number that are remembered, and frames of each
MOST_CANCELS = 32  # that are remembered
MOST_BEHIND = 32  # frames by which one is late at most; by more, another sender counts, or this one anew
MOST = 256  # commands, and senders, that are remembered: random ids cannot fill the memory


@dataclass(frozen=True, slots=True)
class Origin:
    """Where a frame came from, and its place among those that its sender has sent on a way.

    Ground stations with the same ids, as several have by default, are told apart by their ways: each counts by itself.
    """

    sender: ComponentId
    way: Way
    place: int
    lost: int = 0  # how many that its sender has sent before it on the way were lost, or have not arrived yet
    sequence: int | None = None  # as in the frame
    time: float = -math.inf  # when it arrived [s]

    def not_after(self, other: Origin) -> bool:
        """Tell whether this frame is known to have been sent before another one, or to be the same."""
        return self.way == other.way and self.place <= other.place

    def is_copy(self, other: Origin) -> bool:
        """Tell whether this frame may be another one that has come on another link before.

        A router or a client that knows two ways to us sends it on both. A station that counts what it sends on each by
        itself seldom says the same with the same number within so short a time.
        """
        return self.way[0] != other.way[0] and self.is_like(other)

    def is_like(self, other: Origin) -> bool:
        """Tell whether this frame has the number of another one of its sender that came a moment before."""
        alike = self.sequence is not None and (self.sender, self.sequence) == (other.sender, other.sequence)
        anew = self.way == other.way and self.place != other.place
        return alike and not anew and self.time - other.time < COPIED


class FrameCounter:
    """Counts what every sender sends, beyond the 256 sequence numbers of MAVLink.

    >>> frames = FrameCounter()
    >>> [frames.note((255, 190), ("udp", None), sequence, now=0.0).place for sequence in (254, 0, 255, 1)]
    [254, 256, 255, 257]
    >>> frames.note((255, 190), ("udp", None), 0, now=1.0).place
    512
    """

    def __init__(self) -> None:
        self._latest: OrderedDict[tuple[ComponentId, Way], _Latest] = OrderedDict()

    def note(self, sender: ComponentId, way: Way, sequence: int, now: float) -> Origin:
        """Return the origin of a frame; less than half a round ahead of the latest it is new, else it comes late.

        A script that is run once more, or a computer that has rebooted, counts from 0 again: that is new, too, also
        when its first frames were lost.
        """
        latest = self._latest.pop((sender, way), None) or _Latest(sequence, now)
        place = latest.place + (sequence - latest.place + 128) % 256 - 128
        if place <= latest.place and now - latest.time > (RESTARTED_AFTER_S if sequence == 0 else LOWER):
            place += 256
        elif place > latest.place:
            latest.lost += place - latest.place - 1
        if place > latest.place:
            latest.place, latest.time = place, now
        self._latest[sender, way] = latest
        if len(self._latest) > MOST:
            self._latest.popitem(last=False)
        return Origin(sender, way, place, latest.lost, sequence, now)

    def lost(self, origin: Origin) -> int:
        """Return how many frames of a sender were lost on a way so far."""
        latest = self._latest.get((origin.sender, origin.way))
        return origin.lost if latest is None else latest.lost


@dataclass(slots=True)
class _Latest:
    """The frame of a sender on a way with the highest place so far."""

    place: int
    time: float  # when it arrived [s]
    lost: int = 0  # frames before it that have not arrived


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
    kept: Entry | None = None  # the one before, until this one is accepted: what is refused takes nobody's place
    silent: bool = False  # what is said of it would look like an answer to one that waits to replace it
    lost: int | None = None  # frames of its sender that were lost on its way until it ended
    earlier: tuple[Origin, ...] = ()  # of its frames before the latest one
    past: tuple[tuple[Command, float, tuple[Origin, ...]], ...] = ()  # those before it: when heard, or ended, last [s]
    first: Origin = field(init=False)  # of its first frame

    def __post_init__(self) -> None:
        """Note where its first frame came from."""
        self.first = self.origin

    @property
    def origins(self) -> tuple[Origin, ...]:
        """Of its latest frames."""
        return (*self.earlier, self.origin)

    @property
    def heard(self) -> Iterator[tuple[Command, Origin]]:
        """Its frames, and those of the ones before it, as far as they are remembered."""
        for command, origins in ((self.command, self.origins), *((other, old) for other, _, old in self.past)):
            yield from ((command, origin) for origin in origins)

    @property
    def current(self) -> Entry:
        """Itself, or the one that was kept when it was refused."""
        return self if self.order is not None or self.kept is None else self.kept.current

    @property
    def waits(self) -> bool:
        """Whether it is a task that is to replace one that goes on."""
        return self.kept is not None and self.kept.silent and isinstance(self.order, Task)

    @property
    def remembered(self) -> tuple[Entry, ...]:
        """Those that were kept, the oldest first, and this one."""
        return (self,) if self.kept is None else (*self.kept.remembered, self)


@dataclass(slots=True)
class _Stops:
    """The stops of a sender on a way."""

    place: int  # the highest
    time: float = -math.inf  # of the latest [s]
    new: float = -math.inf  # of the latest that had not come on another link before [s]


class RecentCommands:
    """The latest commands, one per sender and number."""

    def __init__(self) -> None:
        self._entries: OrderedDict[tuple[ComponentId, int], Entry] = OrderedDict()
        self._stops: OrderedDict[tuple[ComponentId, Way], _Stops] = OrderedDict()

    def find(self, sender: ComponentId, number: int) -> Entry | None:
        """Return the latest command of a number from a sender."""
        return self._entries.get((sender, number))

    def note(self, entry: Entry) -> None:
        """Remember a command in the place of its like."""
        key = entry.origin.sender, entry.command.number
        before = self._entries.pop(key, None)
        if before is not None:
            entry.past = (*before.past, (before.command, before.time, before.origins))[-MOST_PAST:]
        self._entries[key] = entry
        if len(self._entries) > MOST:
            self._entries.popitem(last=False)

    def note_stop(self, entry: Entry) -> None:
        """Remember a stop; each is obeyed, also one that has come on another link before."""
        origin = entry.origin
        before = self.find(origin.sender, entry.command.number)
        copied = before is not None and any(origin.is_copy(whence) for _, whence in before.heard)
        stops = self._stops.pop((origin.sender, origin.way), None) or _Stops(origin.place)
        stops.place, stops.time = max(stops.place, origin.place), entry.time
        stops.new = stops.new if copied else entry.time
        self._stops[origin.sender, origin.way] = stops
        if len(self._stops) > MOST:
            self._stops.popitem(last=False)
        self.note(entry)

    def repeated(self, command: Command, origin: Origin, now: float) -> Entry | None:
        """Return the entry that a frame only repeats: sent again, or doubled or delayed on its way."""
        latest = self.find(origin.sender, command.number)
        if latest is None:
            return None
        new = command.confirmation < HEARD
        for entry in latest.remembered:
            over = new and entry is not latest and entry.order is None and alike(latest.command, command)
            if over or not alike(entry.command, command):
                continue  # it was answered, and its like was refused since
            if self._is_late(entry, command, origin, now):
                return entry
            if self._again(entry, command, origin, now):
                entry.earlier = entry.origins[-MOST_PAST:]
                entry.time, entry.command, entry.origin, entry.lost = now, command, origin, None
                return entry
        return None

    def before(self, command: Command, origin: Origin, now: float) -> bool:
        """Tell whether a frame that arrives now was sent before the latest command of its number, or is that one.

        Confirmations count up: a higher one with a lower place is of a sender that has restarted. On another way a
        confirmation of what was just replaced has taken longer: a sender may confirm on several at once.
        """
        entry = self.find(origin.sender, command.number)
        return entry is not None and self._is_late(entry, command, origin, now)

    def not_after(self, number: int, origin: Origin, now: float) -> bool:
        """Tell whether a frame that arrives now has no higher place than the latest command of a number."""
        entry = self.find(origin.sender, number)
        return entry is not None and _not_after(entry, origin, now)

    def _is_late(self, entry: Entry, command: Command, origin: Origin, now: float) -> bool:
        """Tell whether a frame that arrives now was sent before a command of its number, or is that one."""
        copied = [whence for other, whence in entry.heard if alike(other, command) and origin.is_copy(whence)]
        if copied and not (command.number == REARM and self._undone(origin, copied[-1])):
            return True
        if origin.way != entry.origin.way:
            past = any(alike(other, command) and now - time < RESENT for other, time, _ in entry.past)
            return past and command.confirmation > 0
        if not _not_after(entry, origin, now):
            return False
        return command.confirmation <= entry.command.confirmation or not alike(entry.command, command)

    def _undone(self, origin: Origin, first: Origin) -> bool:
        """Tell whether a stop that came before a frame on its link has undone what the frame did on a faster one.

        Nobody may have stopped since in any other way.
        """
        way = origin.sender, origin.way
        ahead = self._stops.get(way)
        if ahead is None or ahead.time < first.time or ahead.place >= origin.place:
            return False
        return all(stops.new < first.time for other, stops in self._stops.items() if other != way)

    def _again(self, entry: Entry, command: Command, origin: Origin, now: float) -> bool:
        """Tell whether a sender says a command again that it has not heard the end of."""
        age, going_on = now - entry.time, entry.order is not None
        if not command.long:
            return going_on and age < RESENT  # it has no confirmation to tell
        if command.confirmation == 0:
            return False
        if going_on or command.confirmation >= HEARD:
            return going_on or age < LATE
        if origin.way != entry.origin.way:
            return age < RESENT
        least = min(entry.command.confirmation + 1, MOST_CONFIRMATION)
        if command.confirmation < least or origin.not_after(entry.origin):
            return False  # its sender counts from 0 again, and the first were lost
        lost = origin.lost - (entry.origin.lost if entry.lost is None else entry.lost)
        doubted = max(DOUBTED, command.confirmation * RESENT_EVERY + ON_THE_WAY)
        return age < (min(doubted, RESENT) if lost >= command.confirmation else RESENT)


class RecentCancels:
    """The latest COMMAND_CANCEL, to know what was ordered after one that comes twice or late.

    A cancel that is not obeyed leaves in motion what somebody wants to end, so a place in the count of a sender is not
    enough: two stations behind one router count by themselves, a script that runs again counts from 0, and some send
    the same number always. It has to be a frame that was here before, or one that is late by no more than a moment.
    """

    def __init__(self) -> None:
        self._first: deque[tuple[int, Origin]] = deque(maxlen=MOST_CANCELS)

    def note(self, number: int, origin: Origin) -> Origin | None:
        """Remember a cancel of commands of a number; return where it came from at first, None: it is new."""
        known = (first for other, first in self._first if other == number and origin.is_like(first))
        first = next(known, None)
        if first is None:
            self._first.append((number, origin))
        return first


def is_before(origin: Origin, first: Origin | None, entry: Entry) -> bool:
    """Tell whether a cancel was sent before a command; ``first`` is where its frame came from when it came before."""
    ordered = entry.first
    if origin.sender == ordered.sender and origin.sequence == ordered.sequence:
        return False  # its sender does not count
    if origin.way == ordered.way and origin.sender == ordered.sender:
        return origin.place < ordered.place and (first is not None or _was_before(origin, ordered))
    return first is not None and _was_before(first, ordered)


def _was_before(origin: Origin, ordered: Origin) -> bool:
    """Tell whether a frame has come before another one, or should have."""
    later = origin.time - ordered.time
    if origin.way != ordered.way or origin.sender != ordered.sender:
        return later < 0
    behind = ordered.place - origin.place
    return behind > 0 and (later < 0 or (later < ON_THE_WAY and behind <= MOST_BEHIND))


def _not_after(entry: Entry, origin: Origin, now: float) -> bool:
    return now - entry.time < LATE and origin.not_after(entry.origin)


def alike(command: Command, other: Command) -> bool:
    """Tell whether two commands ask for the same; NaN is like NaN."""
    same = zip(command.numbers, other.numbers, strict=True)
    return command.number == other.number and all(a == b or (math.isnan(a) and math.isnan(b)) for a, b in same)
