"""Where everybody was heard: which way a message goes, and whether two payloads share one id."""

from __future__ import annotations

from collections import OrderedDict, deque
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from ross_payload.ground.links.ports import Peer
from ross_payload.ground.picture.known import Who
from ross_protocols.codec import Packet
from ross_protocols.dialect import ross
from ross_protocols.tunnel import unwrap
from ross_protocols.values import Status

MOST_SENDERS, MOST_WAYS = 256, 8  # that are remembered; ways of one sender
LATELY = 3.0  # [s] since a way brought something, when another one still does
REMEMBERED = 32  # statuses of one way
ENOUGH, WINDOW = 3, 8.0  # statuses of each of two ways, within so many seconds [s], before they are compared


class Way(NamedTuple):
    """A peer of a link."""

    link: int
    peer: Peer


@dataclass(slots=True)
class _Trace:
    """What a way has brought of one sender."""

    last: float  # [s]
    times: deque[tuple[float, int]] = field(default_factory=lambda: deque(maxlen=REMEMBERED))  # [s], time_usec


class Ways:
    """The ways to everybody who was heard, the one in use first."""

    def __init__(self) -> None:
        self._heard: OrderedDict[Who, dict[Way, _Trace]] = OrderedDict()

    def note(self, who: Who, way: Way, packet: Packet, now: float) -> bool:
        """Take a packet; tell whether it shows that two payloads on one link share an id."""
        traces = self._heard.setdefault(who, {})
        self._heard.move_to_end(who)
        if way not in traces:
            self._make_room(traces)
            traces[way] = _Trace(now)
        trace = traces[way]
        trace.last = now
        others = [other for at, other in traces.items() if at != way and at.link == way.link]
        status = _status(packet) if others else None
        if status is None:
            return False
        trace.times.append((now, status.time_usec))
        return any(_strange(trace, other, now) for other in others)

    def to(self, who: Who, now: float, message: Any) -> list[Way]:
        """Return the ways for a message, one of them unless it may be heard twice; empty: nobody knows any."""
        traces = self._heard.get(who, {})
        newest = max((trace.last for trace in traces.values()), default=now)
        good = [way for way, trace in traces.items() if newest - trace.last < LATELY]
        return good if may_repeat(message) else good[:1]

    def _make_room(self, traces: dict[Way, _Trace]) -> None:
        while len(traces) >= MOST_WAYS:
            del traces[min(traces, key=lambda way: traces[way].last)]
        while len(self._heard) > MOST_SENDERS:
            self._heard.popitem(last=False)


def may_repeat(message: Any) -> bool:
    """Tell whether it does no harm that a payload hears a message twice: a stop, and what is sent again anyhow.

    >>> [may_repeat(ross.MAVLink_command_long_message(1, 191, 54004, number, *[0] * 7)) for number in (0, 1)]
    [True, True]
    >>> [may_repeat(ross.MAVLink_command_long_message(1, 191, 54000, number, *[0] * 7)) for number in (0, 1)]
    [False, True]
    """
    if not message.get_type().startswith("COMMAND_"):
        return False
    return message.command == ross.MAV_CMD_ROSS_STOP or getattr(message, "confirmation", 0) > 0


def _status(packet: Packet) -> Status | None:
    told = unwrap(packet.message) if packet.name == "TUNNEL" else packet
    value = None if told is None or told.name != "ROSS_STATUS" else told.value
    return value if isinstance(value, Status) else None


def _strange(one: _Trace, other: _Trace, now: float) -> bool:
    """Tell whether two ways bring statuses at once and never the same: one payload on two ways would repeat itself.

    A payload that has started anew speaks from another port: then the one way begins where the other ends.
    """
    if not one.times or not other.times:
        return False
    begin = max(one.times[0][0], other.times[0][0], now - WINDOW)
    mine, theirs = ({usec for at, usec in trace.times if at >= begin} for trace in (one, other))
    return min(len(mine), len(theirs)) >= ENOUGH and not mine & theirs
