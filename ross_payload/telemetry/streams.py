"""What there is to tell, and what each link is told of it: the most important first, the latest value only.

The `Board` holds one value per key; nothing queues on it. A `Stream` knows what its link has been told and gives what
is due within the room that the budget of the link leaves. What does not fit waits on the board, where a later value
takes its place.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from enum import IntEnum

from ross_protocols.dialect import common
from ross_protocols.layouts import LAYOUTS
from ross_protocols.values import Text, Value

COMPUTER = common.MAVLink_onboard_computer_status_message  # a message that is told as it is
MESSAGE_IDS = {layout.value: layout.message.id for layout in LAYOUTS} | {COMPUTER: COMPUTER.id}
SHORTEST = 0.02  # [s] between two of a kind, however often somebody asks for them
RESERVE = 130  # bytes left to answers: an acknowledgement is never held back by what repeats itself
ENOUGH = 0.9  # [s] between two statuses, when there is not room for more
TEXTS = 24  # that wait for room; then the oldest go
EARLY = 1e-6  # [s], of rounding


class Rank(IntEnum):
    """What goes first when there is not room for all."""

    HEARTBEAT = 0
    STATUS = 1
    TEXT = 2
    SOURCE = 3
    MIRROR = 4
    ALIGNMENT = 5
    SEPARATION = 6
    AUDIO = 7
    RECORDING = 8
    LINK = 9
    INFORMATION = 10
    DENSITY = 11
    ISOLATION = 12
    COMPUTER = 13
    EXTRA = 14  # a status that nothing new calls for, sooner than `ENOUGH` after the last one


Key = tuple[Rank, int, int]  # rank, message id, place among its like
REQUESTED = -1  # stands for news: told once more, whatever the period


@dataclass(frozen=True, slots=True)
class Item:
    """A value on the board; ``news`` grows whenever everybody shall hear of it at once."""

    value: Value
    news: int


class Every:
    """Tells when something periodic is due; the first time at once, without drift, without catching up.

    >>> second = Every(1.0)
    >>> [second.due(now) for now in (0.0, 0.9, 1.05, 2.0, 7.0, 7.5)]
    [True, False, True, True, True, False]
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self._next: float | None = None

    def due(self, now: float) -> bool:
        """Tell whether it is due at ``now`` [s], once."""
        if self._next is not None and now < self._next - 1e-9:
            return False
        upcoming = now if self._next is None else self._next
        self._next = upcoming + self._period if upcoming + self._period > now else now + self._period
        return True


class Board:
    """The latest of everything that can be told.

    >>> from ross_protocols.values import Named
    >>> board = Board()
    >>> board.put(Rank.MIRROR, [Named(0.0, "ross_k", 1.0)])
    >>> board.put(Rank.MIRROR, [Named(0.0, "ross_k", 2.0)])
    >>> [item.value.value for _, item in board.items()]
    [2.0]
    """

    def __init__(self) -> None:
        self._items: dict[Key, Item] = {}  # the most important first
        self.news = 0  # grows with everything that is new

    def put(self, rank: Rank, values: Iterable[Value]) -> None:
        """Let ``values`` be all there is of a rank; they are told when their time comes."""
        self._place(rank, values, lambda before, value: False)

    def tell(self, rank: Rank, values: Iterable[Value]) -> None:
        """Let ``values`` be all there is of a rank; those that are not as before are told at once."""
        self._place(rank, values, lambda before, value: before != value)

    def items(self) -> Iterable[tuple[Key, Item]]:
        """Give everything, the most important first."""
        return self._items.items()

    def _place(self, rank: Rank, values: Iterable[Value], differs: Callable[[Value, Value], bool]) -> None:
        placed: dict[Key, Item] = {}
        for place, value in enumerate(values):
            key = rank, MESSAGE_IDS[type(value)], place
            before = self._items.get(key)
            if before is None or differs(before.value, value):
                self.news += 1
                placed[key] = Item(value, self.news)
            else:
                placed[key] = Item(value, before.news)
        old = [key for key in self._items if key[0] is rank]
        if len(old) == len(placed) and placed.keys() == set(old):
            self._items |= placed  # the order stays
            return
        others = {key: item for key, item in self._items.items() if key[0] is not rank}
        self._items = dict(sorted((others | placed).items(), key=lambda pair: pair[0]))


@dataclass(slots=True)
class _Told:
    """What a link knows of a key."""

    news: int
    due: float  # when it is told again [s]
    last: float  # when it was told [s]


class Stream:
    """What one link is told. ``size`` tells how many bytes a value takes there."""

    def __init__(self, periods: Mapping[int, float], size: Callable[[Value], int]) -> None:
        self._usual = periods  # message id -> [s]
        self._asked: dict[int, float] = {}
        self._size = size
        self._told: dict[Key, _Told] = {}
        self._texts: deque[Text] = deque(maxlen=TEXTS)
        self._seen = -1  # news of the board when everything had been told
        self._quiet_until = -math.inf  # [s], unless there are news

    def say(self, texts: Iterable[Text]) -> None:
        """Put texts in line; of too many the oldest are lost."""
        self._texts.extend(texts)
        self._seen = -1

    def quiet(self, board: Board, now: float) -> bool:
        """Tell whether nothing is due at ``now`` [s]: most of the time, and much cheaper to know."""
        return self._seen == board.news and now < self._quiet_until - EARLY

    def set_period(self, message_id: int, period: float | None) -> bool:
        """Tell a message every ``period`` [s] (infinite: never, None: as usual); False: there is no such stream."""
        if message_id not in self._usual or (period is not None and math.isnan(period)):
            return False
        self._asked.pop(message_id, None)
        if period is not None:
            self._asked[message_id] = max(period, SHORTEST)
        for key, told in self._told.items():
            if key[1] == message_id:
                told.due = -math.inf
        self._seen = -1
        return True

    def period(self, message_id: int) -> float | None:
        """Return how often a message is told [s], infinite: never; None: there is no such stream."""
        return self._asked.get(message_id, self._usual.get(message_id))

    def request(self, board: Board, message_id: int) -> bool:
        """Tell a message once more, soon; False: there is nothing of it to tell."""
        keys = [key for key, _ in board.items() if key[1] == message_id]
        for key in keys:
            self._told[key] = _Told(REQUESTED, -math.inf, -math.inf)
        self._seen = -1
        return bool(keys)

    def due(self, board: Board, now: float, room: float) -> list[Value]:
        """Return what is to be sent at ``now`` [s]; what finds no room holds back what matters less."""
        chosen: list[Value] = []
        for key, item in self._waiting(board, now):
            size = self._size(item.value)
            if size > room - (0 if key[0] is Rank.HEARTBEAT else RESERVE):
                return chosen
            room -= size
            chosen.append(item.value)
            if isinstance(item.value, Text):
                self._texts.popleft()
            else:
                self._note(key, item, now)
        self._rest(board)
        return chosen

    def _rest(self, board: Board) -> None:
        """Everything has been told: note when the next thing is due."""
        told = (self._told[key].due for key, _ in board.items() if key in self._told and self._period(key) < math.inf)
        self._seen, self._quiet_until = board.news, min(told, default=math.inf)

    def _waiting(self, board: Board, now: float) -> Iterator[tuple[Key, Item]]:
        due = [(key, item) for key, item in board.items() if self._is_due(key, item, now)]
        ranked = sorted((*self._urgency(key, item, now), place) for place, (key, item) in enumerate(due))
        yield from (due[place] for rank, _, place in ranked if rank < Rank.TEXT)
        yield from (((Rank.TEXT, 0, 0), Item(text, 0)) for text in list(self._texts))
        yield from (due[place] for rank, _, place in ranked if rank > Rank.TEXT)

    def _urgency(self, key: Key, item: Item, now: float) -> tuple[Rank, float]:
        """Return what goes first, and among equals what has waited longest; news have waited for ever."""
        told = self._told.get(key)
        if told is None or told.news != item.news:
            return key[0], -math.inf
        extra = key[0] is Rank.STATUS and now < told.last + ENOUGH - EARLY
        return Rank.EXTRA if extra else key[0], told.due

    def _is_due(self, key: Key, item: Item, now: float) -> bool:
        told = self._told.get(key)
        if told is not None and told.news == REQUESTED:
            return True
        if self._period(key) == math.inf:
            return False
        return told is None or told.news != item.news or now >= told.due - EARLY

    def _note(self, key: Key, item: Item, now: float) -> None:
        told, period = self._told.get(key), self._period(key)
        on_time = told is not None and told.due <= now + EARLY < told.due + period
        due = told.due + period if told is not None and on_time else now + period
        self._told[key] = _Told(item.news, due, now)

    def _period(self, key: Key) -> float:
        return self._asked.get(key[1], self._usual[key[1]])
