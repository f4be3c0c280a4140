"""What is remembered of components, and of who speaks on which way, to understand the next packet."""

from __future__ import annotations

import math
from collections import OrderedDict, deque
from collections.abc import Hashable, Iterable
from copy import deepcopy
from dataclasses import dataclass, field

from ross_payload.ground.model.payload_state import mission_time_between
from ross_payload.ground.model.state_reducer import LATE_US
from ross_payload.ground.model.status_text import Texts
from ross_protocols.mavlink.codec import Packet
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.peers import SequenceNumbers, is_routed
from ross_protocols.mavlink.values import Status

NEAR = 32  # frames missing in a row are lost; more are the numbers of another link, or a link that was down
WAYS = 4  # links that one component may be heard on, each with numbers of its own
LATE_S = LATE_US / 1e6
BACKWARD_S = 1.0  # [s] by which a payload's time goes back when it has restarted
TWIN_SPAN_S, TWIN_TIMES = 10.0, 3  # so many steps back within so many seconds [s] are two payloads, not restarts
PRESENCE_S = 60  # seconds for which it is remembered in which of them somebody was heard
_ALL = (1 << PRESENCE_S) - 1
MOST_WAYS = 512  # that are remembered: strangers cannot fill the memory
MOST_SENDERS = 16  # of a way; more are no better proof


@dataclass(slots=True)
class Presence:
    """In which of the last seconds a component was heard.

    >>> presence = Presence()
    >>> [presence.note(at) for at in (5.0, 5.9, 6.1, 20.0)]
    [True, False, True, True]
    >>> presence.seconds(20.0), presence.seconds(70.0), presence.seconds(90.0)
    (3, 1, 0)
    """

    _latest: int = 0  # second
    _seconds: int = 0  # one bit for each second, the latest one lowest

    def note(self, at: float) -> bool:
        """Learn that it is heard at a time [s]; return whether it is the first time in that second."""
        second = int(at)
        if self._seconds and second <= self._latest:
            return False
        self._seconds, self._latest = self._shifted(second) | 1, second
        return True

    def seconds(self, now: float) -> int:
        """Return in how many of the last `PRESENCE_S` seconds it was heard."""
        return self._shifted(int(now)).bit_count()

    def _shifted(self, second: int) -> int:
        return self._seconds << min(max(second - self._latest, 0), PRESENCE_S) & _ALL


@dataclass(slots=True)
class DecoderState:
    """One component's."""

    frame: bytes = b""  # its latest
    heads: list[SequenceNumbers] = field(default_factory=list)  # of every way, the latest way last
    status: Status | None = None  # its latest
    status_at: float = -1e9  # when that came [s]
    way: Hashable = None  # on which it came, or the start that was noticed
    by_way: dict[Hashable, Status] = field(default_factory=dict)  # the latest of ways that brought the same lately
    started_at: float = -1e9  # when it was noticed that it has restarted [s]
    backs: deque[float] = field(default_factory=lambda: deque(maxlen=TWIN_TIMES))  # when its time went back [s]
    leapt_at: float = -1e9  # when its time was much farther ahead on another way than has passed [s]
    twin_at: float = -1e9  # when two senders of its id were noticed last [s]
    texts: Texts = field(default_factory=Texts)
    presence: Presence = field(default_factory=Presence)

    def copy(self) -> DecoderState:
        """Return another one that remembers the same."""
        return deepcopy(self)

    def missing(self, sequence: int) -> int:
        """Return how many more frames are missing than before one with this number; -1: it was one of these.

        >>> decoder = DecoderState()
        >>> [decoder.missing(number) for number in (254, 255, 1, 100, 2, 103, 101, 101)]
        [0, 0, 1, 0, 0, 2, -1, 0]
        """
        behind = min(self.heads, key=lambda head: -head.ahead(sequence) % 256, default=None)
        if behind is not None and -behind.ahead(sequence) % 256 < NEAR:
            return behind.note(sequence)  # late, or doubled
        head = min(self.heads, key=lambda head: head.ahead(sequence), default=None)
        if head is None or head.ahead(sequence) > NEAR:
            self.heads = [*self.heads, SequenceNumbers(sequence)][-WAYS:]
            return 0
        self.heads.remove(head)
        self.heads.append(head)
        return head.note(sequence)

    def is_late(self, status: Status, at: float, way: Hashable) -> bool:
        """Tell whether a status was said before the latest one: it was on its way for longer.

        On another way, which may be slower, that is also so where time stamps do not tell, as the clock was just set,
        and of what was said before a start that was just noticed. Who listens may have stood still, and hear what
        waited way by way: then each goes on from where it was.
        """
        own = self.by_way.get(way)
        goes_on = own is not None and (own.time_usec <= status.time_usec or is_late(own, status))
        if is_late(self.status, status, most=math.inf if goes_on else LATE_US):
            self._note(status, way)
            return True
        if way == self.way:
            return False
        starting = at - self.started_at < LATE_S
        if self.status is None:
            return starting
        ahead = mission_time_between(self.status.mission_time, status.mission_time)
        undated = status.time_unix != self.status.time_unix or status.time_usec == self.status.time_usec
        return (undated and -LATE_S < ahead < 0) or (starting and ahead > BACKWARD_S + at - self.status_at)

    def _note(self, status: Status, way: Hashable) -> None:
        """Note what came on a way."""
        self.by_way.pop(way, None)
        self.by_way[way] = status
        if len(self.by_way) > WAYS:
            del self.by_way[next(iter(self.by_way))]

    def note_start(self, at: float, way: Hashable) -> None:
        """Note that it has restarted, and forget its status."""
        self.status, self.started_at, self.way = None, at, way
        self.by_way.clear()

    def went_back(self, status: Status, at: float, way: Hashable) -> bool:
        """Whether a status is of a time before the latest one: its time stamp, or the audio that was heard."""
        before, since, other = self.status, at - self.status_at, way != self.way
        self.status, self.status_at, self.way = status, at, way
        if before is None:
            self._note(status, way)
            return False
        stamped = (before.time_usec - status.time_usec) / 1e6 if before.time_unix == status.time_unix else 0.0
        heard = mission_time_between(status.mission_time, before.mission_time)
        back = max(stamped, heard) > BACKWARD_S
        leapt = other and min(stamped, heard) < -(since + LATE_S)
        if back:
            self.backs.append(at)
        if leapt:
            self.leapt_at = at
        if back or leapt:
            self.by_way.clear()  # another one may speak there
        else:
            self._note(status, way)
        return back

    def is_twin(self, at: float) -> bool:
        """Whether time went back so often, or back again after a leap ahead, that two must be speaking."""
        often = len(self.backs) == TWIN_TIMES and at - self.backs[0] < TWIN_SPAN_S
        return often or at - self.leapt_at < TWIN_SPAN_S


def is_late(before: Status | None, status: Status, most: float = LATE_US) -> bool:
    """Tell whether a status was said before another one that came before it: it was on its way for longer.

    Then it is behind by both clocks alike, unless the audio stood still, or caught up after the payload had stood still
    itself, for at most `LATE_S`. After a restart one of them goes on, or both are behind by more than ``most`` [us]: a
    computer is not switched on again within `LATE_US` of its start.

    >>> at = [Status(round(time * 1e6), time - 50.0, state=1, earth=True) for time in (100.0, 97.5, 60.0)]
    >>> is_late(at[0], at[1]), is_late(at[1], at[0]), is_late(at[0], at[2])
    (True, False, False)
    """
    if before is None or before.time_unix != status.time_unix:
        return False
    stamped = before.time_usec - status.time_usec
    heard = mission_time_between(status.mission_time, before.mission_time)
    return 0 < stamped < most and -BACKWARD_S <= heard <= stamped / 1e6 + LATE_S


def without_listener(senders: Iterable[ComponentId], stations: Iterable[ComponentId]) -> set[ComponentId]:
    """Leave out the one ground station among the senders of a log, which has written it; of two, one was routed.

    >>> sorted(without_listener([(1, 191), (255, 190)], [(255, 190)]))
    [(1, 191)]
    """
    senders, stations = set(senders), set(stations)
    return senders - stations if len(senders & stations) == 1 else senders


class Senders:
    """The senders of every way. A way is whatever tells one from another; None: not told, as in a log.

    A log holds what its own station has said, too. That one is left out.
    """

    def __init__(self) -> None:
        self._by_way: OrderedDict[Hashable, set[ComponentId]] = OrderedDict()  # the way that was heard last is last
        self._stations: set[ComponentId] = set()  # of a log

    def copy(self) -> Senders:
        """Return another one that knows the same."""
        return deepcopy(self)

    def meet(self, packet: Packet, way: Hashable) -> None:
        """Note who speaks on a way."""
        sender = packet.sender
        senders = self._by_way.setdefault(way, set())
        self._by_way.move_to_end(way)
        if len(senders) < MOST_SENDERS:
            senders.add(sender)
        if len(self._by_way) > MOST_WAYS:
            self._by_way.popitem(last=False)
        if way is None and packet.name == "HEARTBEAT" and packet.message.type == common.MAV_TYPE_GCS:
            self._stations = set(sorted({*self._stations, sender})[:MOST_SENDERS])

    def is_routed(self, way: Hashable) -> bool:
        """Tell whether somebody on a way passes on what others say."""
        senders = self._by_way.get(way, set())
        return is_routed(without_listener(senders, self._stations) if way is None else senders)
