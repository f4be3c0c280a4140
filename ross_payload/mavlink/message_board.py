"""What there is to send, the most important first: the latest value only; nothing queues here."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.message_map import LAYOUTS
from ross_protocols.mavlink.values import Value

COMPUTER = common.MAVLink_onboard_computer_status_message  # a message that is sent as it is
MESSAGE_IDS = {layout.value: layout.message.id for layout in LAYOUTS} | {COMPUTER: COMPUTER.id}


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
    STREAM = 9
    LINK = 10
    INFORMATION = 11
    DENSITY = 12
    ISOLATION = 13
    COMPUTER = 14
    GIMBAL_ATTITUDE = 15
    GIMBAL_MANAGER = 16
    EXTRA = 17  # what nothing new calls for, sooner than usual; a heartbeat or status sooner than after `ENOUGH`


@dataclass(frozen=True, slots=True, eq=False)
class Sampled:
    """A message that is made whenever it is due."""

    message_id: int
    make: Callable[[], Any]


Content = Value | Sampled
Key = tuple[Rank, int, int]  # rank, message id, place among its like


@dataclass(frozen=True, slots=True)
class Item:
    """A value on the board; ``news`` grows whenever everybody shall hear of it at once."""

    value: Content
    news: int


class Board:
    """The latest of everything that can be sent.

    >>> from ross_protocols.mavlink.values import Named
    >>> board = Board()
    >>> board.put(Rank.MIRROR, [Named(0.0, "ross_k", 1.0)])
    >>> board.put(Rank.MIRROR, [Named(0.0, "ross_k", 2.0)])
    >>> [item.value.value for _, item in board.items()]
    [2.0]
    """

    def __init__(self) -> None:
        self._items: dict[Key, Item] = {}  # the most important first
        self.news = 0  # grows with everything that is new

    def put(self, rank: Rank, values: Iterable[Content]) -> None:
        """Let ``values`` be all there is of a rank; they are sent when their time comes."""
        self._place(rank, values, lambda before, value: False)

    def announce(self, rank: Rank, values: Iterable[Content]) -> None:
        """Let ``values`` be all there is of a rank; those that are not as before are sent at once."""
        self._place(rank, values, lambda before, value: before != value)

    def items(self) -> Iterable[tuple[Key, Item]]:
        """Give everything, the most important first."""
        return self._items.items()

    def _place(self, rank: Rank, values: Iterable[Content], differs: Callable[[Content, Content], bool]) -> None:
        placed: dict[Key, Item] = {}
        for place, value in enumerate(values):
            key = rank, message_id_of(value), place
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


def message_id_of(value: Content) -> int:
    """Return the id of the message of a value."""
    return value.message_id if isinstance(value, Sampled) else MESSAGE_IDS[type(value)]
