"""Who speaks on each way to a listener: where others speak beside a payload, a router stands between."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Hashable, Iterable
from copy import deepcopy

from ross_protocols.codec import Packet
from ross_protocols.dialect import common
from ross_protocols.peers import Sender, is_routed

MOST_WAYS = 512  # that are remembered: strangers cannot fill the memory
MOST_SENDERS = 16  # of a way; more are no better proof


def without_listener(senders: Iterable[Sender], stations: Iterable[Sender]) -> set[Sender]:
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
        self._by_way: OrderedDict[Hashable, set[Sender]] = OrderedDict()  # the way that was heard last is last
        self._stations: set[Sender] = set()  # of a log

    def copy(self) -> Senders:
        """Return another one that knows the same."""
        return deepcopy(self)

    def meet(self, packet: Packet, way: Hashable) -> None:
        """Note who speaks on a way."""
        sender = packet.system_id, packet.component_id
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
