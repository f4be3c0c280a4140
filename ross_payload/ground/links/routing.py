"""Where everybody was heard: which way a message goes, and whether two payloads share one id."""

from __future__ import annotations

import math
from collections import OrderedDict, deque
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from ross_payload.transport.ports import Peer
from ross_protocols.mavlink.codec import Packet
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import ross
from ross_protocols.mavlink.tunnel import OURS, unwrapped

MAX_SENDERS, MAX_ROUTES = 256, 8  # that are remembered; routes of one sender
FRESH_S = 3.0  # [s] since a route brought something, when another one still does
REMEMBERED = 128  # time stamps of one route
ANSWERS = ("COMMAND_ACK", "PARAM_ERROR", "PARAM_VALUE", "STATUSTEXT")  # messages that a payload sends on every link
MAX_ANSWERS, MAX_TIMES = (
    1024,
    32,
)  # that are remembered of one route, and how often each came: no flood fills the memory
COPY_S = 10.0  # [s] by which one of them is late at most, where it comes a second time
MIN_STAMPS = 3  # of each of two routes, before they are compared
MIN_TOGETHER_S = 3.0  # [s] for which both bring some; what a payload says of its health has a new one every second
TWIN_WINDOW_S = 8.0  # within which these came
COMPARED_S = 0.25  # [s] between two comparisons of a route with others: a flood on several costs little


class Route(NamedTuple):
    """A peer of a link."""

    link: int
    peer: Peer


@dataclass(slots=True)
class _Trace:
    """What a route has brought of one sender."""

    last: float  # [s]
    compared: float = -math.inf  # with other routes [s]
    times: deque[tuple[float, int]] = field(default_factory=lambda: deque(maxlen=REMEMBERED))  # [s], [us]
    answers: OrderedDict[bytes, deque[float]] = field(default_factory=OrderedDict)  # when [s], the latest to come last

    def count(self, answer: bytes, now: float) -> int:
        """Return how often an answer has come lately."""
        return sum(now - at < COPY_S for at in self.answers.get(answer, ()))

    def note_answer(self, answer: bytes, now: float) -> None:
        """Note that an answer comes, and forget old ones."""
        times = self.answers.pop(answer, None) or deque(maxlen=MAX_TIMES)
        times.append(now)
        self.answers[answer] = times
        while now - next(iter(self.answers.values()))[-1] >= COPY_S or len(self.answers) > MAX_ANSWERS:
            self.answers.popitem(last=False)


class RoutingTable:
    """The routes to everybody who was heard, the one in use first."""

    def __init__(self) -> None:
        self._traces: OrderedDict[ComponentId, dict[Route, _Trace]] = OrderedDict()

    def note(self, who: ComponentId, route: Route, packet: Packet, now: float) -> bool:
        """Take a packet; tell whether it shows that two payloads on one link share an id."""
        traces = self._traces.setdefault(who, {})
        self._traces.move_to_end(who)
        if route not in traces:
            self._make_room(traces)
            traces[route] = _Trace(now)
        trace = traces[route]
        trace.last = now
        stamp = _stamp(packet)
        if stamp is None:
            return False
        trace.times.append((now, stamp))
        if now - trace.compared < COMPARED_S:
            return False
        trace.compared = now
        others = [other for at, other in traces.items() if at != route and at.link == route.link]
        return any(_strange(trace, other, now) for other in others)

    def is_copy(self, who: ComponentId, route: Route, packet: Packet, now: float) -> bool:
        """Take an answer or a text of a sender that was noted; tell whether it came on another route, as often.

        It may be seconds late there: an acknowledgement would be taken for one to a later order.
        """
        if packet.name not in ANSWERS:
            return False
        traces, answer = self._traces[who], packet.name.encode() + bytes(packet.message.get_payload())
        traces[route].note_answer(answer, now)
        others = [traces[other].count(answer, now) for other in self._good(who, now) if other != route]
        return traces[route].count(answer, now) <= max(others, default=0)

    def to(self, who: ComponentId, now: float, message: Any) -> list[Route]:
        """Return the routes for a message, one of them unless it may be heard twice; empty: nobody knows any."""
        good = self._good(who, now)
        return good if may_repeat(message) else good[:1]

    def best(self, who: ComponentId, now: float) -> Route | None:
        """Return the route in use; None: nobody knows any."""
        return next(iter(self._good(who, now)), None)

    def _good(self, who: ComponentId, now: float) -> list[Route]:
        traces = self._traces.get(who, {})
        newest = max((trace.last for trace in traces.values()), default=now)
        return [route for route, trace in traces.items() if newest - trace.last < FRESH_S]

    def _make_room(self, traces: dict[Route, _Trace]) -> None:
        while len(traces) >= MAX_ROUTES:
            del traces[min(traces, key=lambda route: traces[route].last)]
        while len(self._traces) > MAX_SENDERS:
            self._traces.popitem(last=False)


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


def _stamp(packet: Packet) -> int | None:
    """Return the time of the payload that a message of ours bears [us]; None: it bears none."""
    told = unwrapped(packet)
    return None if told is None or not told.name.startswith(OURS) else getattr(told.message, "time_usec", None)


def _strange(one: _Trace, other: _Trace, now: float) -> bool:
    """Tell whether two routes bring messages at once and never the same: one payload on both would repeat itself.

    Its statuses need not be the same, as each link has its own rates; what it says of its health once a second is. A
    payload that has restarted speaks from another port: then the one route begins where the other ends.
    """
    mine, theirs = ([each for each in trace.times if each[0] >= now - TWIN_WINDOW_S] for trace in (one, other))
    if not mine or not theirs or {usec for _, usec in mine} & {usec for _, usec in theirs}:
        return False
    begin, end = max(mine[0][0], theirs[0][0]), min(mine[-1][0], theirs[-1][0])
    counts = [sum(begin <= at <= end for at, _ in times) for times in (mine, theirs)]
    return min(counts) >= MIN_STAMPS and end - begin >= MIN_TOGETHER_S
