"""What each link is sent of what is on the board, and when: the most important first, within the link's budget.

A `Stream` knows what its link has been sent and gives what is due within the room that the budget of the link leaves.
What does not fit waits on the board, where a later value takes its place. One `MessageScheduler` serves one component.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from ross_payload.config import Telemetry as TelemetryConfig
from ross_payload.mavlink.component import Component
from ross_payload.mavlink.link import LinkStatus
from ross_payload.mavlink.message_board import COMPUTER, MESSAGE_IDS, Board, Content, Item, Key, Rank, Sampled
from ross_payload.mavlink.router import Router
from ross_protocols.mavlink import values as v
from ross_protocols.mavlink.codec import Encoder, message_of
from ross_protocols.mavlink.stream_values import StreamReport
from ross_protocols.mavlink.tunnel import Wrapper
from ross_protocols.mavlink.values import Text

SHORTEST = 0.02  # [s] between two of a kind, however often somebody asks for them
RESERVE = 130  # bytes left to answers: an acknowledgement is never held back by what repeats itself
ENOUGH = 0.9  # [s] between two heartbeats, and two statuses, when there is not room for more
TEXTS = 24  # parts of texts that wait for room; then the oldest texts go
EARLY = 1e-6  # [s], of rounding
REQUESTED = -1  # stands for news: sent once more, whatever the period
FRAME = 75  # bytes of a typical message whose component has a share of the budget, signed
LOGS = "local"  # the link on which only logs and our own components listen
SIGNATURE = 13  # bytes
AROUND = 17  # bytes of a TUNNEL beside the frame that it carries
REPEAT = 5.0  # [s], of what was found out, for those who join late or lost it
USUAL = {
    v.Heartbeat: 1.0, v.Information: REPEAT, v.Source: REPEAT, v.Alignment: REPEAT, v.Separation: REPEAT,
    v.Audio: 1.0, v.Recording: REPEAT, v.LinkReport: REPEAT, StreamReport: REPEAT, v.Density: 8.0, v.Isolation: 8.0,
    COMPUTER: REPEAT,
}  # fmt: skip  # [s]
BEAT = MESSAGE_IDS[v.Heartbeat]
OURS = frozenset(kind for kind, number in MESSAGE_IDS.items() if 54000 <= number < 54020)


@dataclass(slots=True)
class _Sent:
    """What a link knows of a key."""

    news: int
    due: float  # when it is sent again [s]
    last: float  # when it was sent [s]


class Stream:
    """What one link is sent. ``size`` tells how many bytes a value takes there."""

    def __init__(self, periods: Mapping[int, float], size: Callable[[Content], int]) -> None:
        self._usual = periods  # message id -> [s]
        self._asked: dict[int, float] = {}
        self._size = size
        self.limit = math.inf  # what the messages may take beside the heartbeat [bytes/s]; infinite: what there is
        self.most = math.inf  # what the link ever takes at once [bytes]
        self.claimed = 0.0  # of that, what waits for an answer [bytes]
        self._sent: dict[Key, _Sent] = {}
        self._texts: deque[Text] = deque()
        self._seen = -1  # news of the board when everything had been sent
        self._quiet_until = -math.inf  # [s], unless there are news

    def queue_texts(self, texts: Iterable[Text]) -> None:
        """Put the parts of texts in line; of too many the oldest texts are lost, each as a whole."""
        self._texts.extend(texts)
        self._seen = -1
        if len(self._texts) > TEXTS:
            while self._texts and (len(self._texts) > TEXTS or self._texts[0].chunk):
                self._texts.popleft()

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
        for key, sent in self._sent.items():
            if key[1] == message_id:
                sent.due = -math.inf
        self._seen = -1
        return True

    def period(self, message_id: int) -> float | None:
        """Return how often a message is sent [s], infinite: never; None: there is no such stream."""
        usual = self._usual.get(message_id)
        wanted = self._asked.get(message_id, usual)
        if wanted is None or usual is None or math.isinf(self.limit):
            return wanted
        scaled = wanted * max(self._load() / self.limit, 1.0)
        return min(scaled, usual) if message_id == BEAT else scaled

    def _load(self) -> float:
        """Return how much the messages would take at the periods that are wanted [bytes/s]; a usual heartbeat not."""
        wanted = ((number, self._asked.get(number, usual), usual) for number, usual in self._usual.items())
        return sum(FRAME / period for number, period, usual in wanted if number != BEAT or period < usual)

    def request(self, board: Board, message_id: int) -> bool:
        """Tell a message once more, soon; False: there is nothing of it to tell."""
        keys = [key for key, item in board.items() if key[1] == message_id and self._need(key[0], item) <= self.most]
        for key in keys:
            self._sent[key] = _Sent(REQUESTED, -math.inf, -math.inf)
        self._seen = -1
        return bool(keys)

    def due(self, board: Board, now: float, room: float) -> list[Content]:
        """Return what is to be sent at ``now`` [s]; what finds no room now holds back what matters less."""
        chosen: list[Content] = []
        for rank, key, item in self._waiting(board, now):
            need = self._need(rank, item)
            if need > self.most:
                continue
            size = self._size(item.value)
            if max(need, size + (0 if rank is Rank.HEARTBEAT else self.claimed)) > room:
                return chosen
            room -= size
            chosen.append(item.value)
            if isinstance(item.value, Text):
                self._texts.popleft()
            else:
                self._note(key, item, now)
        self._rest(board)
        return chosen

    def _need(self, rank: Rank, item: Item) -> float:
        """Return how much room there has to be for a value [bytes]."""
        reserved = 0 if rank is Rank.HEARTBEAT or math.isfinite(self.limit) else RESERVE
        return self._size(item.value) + reserved

    def _rest(self, board: Board) -> None:
        """Everything has been sent: note when the next thing is due."""
        sent = (self._sent[key].due for key, _ in board.items() if key in self._sent and self._period(key) < math.inf)
        self._seen, self._quiet_until = board.news, min(sent, default=math.inf)

    def _waiting(self, board: Board, now: float) -> Iterator[tuple[Rank, Key, Item]]:
        due = [(key, item) for key, item in board.items() if self._is_due(key, item, now)]
        ranked = sorted((*self._urgency(key, item, now), place) for place, (key, item) in enumerate(due))
        yield from ((rank, *due[place]) for rank, _, place in ranked if rank < Rank.TEXT)
        yield from ((Rank.TEXT, (Rank.TEXT, 0, 0), Item(text, 0)) for text in list(self._texts))
        yield from ((rank, *due[place]) for rank, _, place in ranked if rank > Rank.TEXT)

    def _urgency(self, key: Key, item: Item, now: float) -> tuple[Rank, float]:
        """Return what goes first, and among equals what has waited longest; news have waited for ever.

        What comes sooner than usual, because somebody asks for it, takes what the others leave.
        """
        sent = self._sent.get(key)
        if sent is None or sent.news != item.news:
            return key[0], -math.inf
        usual = min(self._usual.get(key[1], math.inf), REPEAT)
        often = usual if self._period(key) < usual else 0.0
        enough = ENOUGH if key[0] <= Rank.STATUS else often
        return Rank.EXTRA if now < sent.last + enough - EARLY else key[0], sent.due

    def _is_due(self, key: Key, item: Item, now: float) -> bool:
        sent = self._sent.get(key)
        if sent is not None and sent.news == REQUESTED:
            return True
        if self._period(key) == math.inf:
            return False
        return sent is None or sent.news != item.news or now >= sent.due - EARLY

    def _note(self, key: Key, item: Item, now: float) -> None:
        sent, period = self._sent.get(key), self._period(key)
        on_time = sent is not None and sent.due <= now + EARLY < sent.due + period
        due = sent.due + period if sent is not None and on_time else now + period
        self._sent[key] = _Sent(item.news, due, now)

    def _period(self, key: Key) -> float:
        period = self.period(key[1])
        return math.inf if period is None else period


def periods(config: TelemetryConfig) -> dict[int, float]:
    """Return how often each message is sent [s] by its id; infinite: never."""
    mirror = 1 / config.mirror_hz if config.mirror_hz else math.inf
    every = USUAL | {v.Status: 1 / config.status_hz, v.Named: mirror, v.Array: mirror}
    return {MESSAGE_IDS[kind]: period for kind, period in every.items()}


@dataclass(frozen=True, slots=True)
class _Outlet:
    stream: Stream
    send: Callable[[Content], None]


class _Form(NamedTuple):
    value: Content  # kept, so that its identity stays its own
    message: Any  # pymavlink's


class MessageScheduler:
    """Sends what is on a board, link by link.

    Parameters
    ----------
    board
        What there is to send.
    links, component
        Where, and as whom.
    periods
        How often each message is sent usually [s], by its id; infinite: never.
    share
        Of the budget of a link that the messages may take, beside the heartbeat; None: what there is room for.
    """

    def __init__(
        self,
        board: Board,
        links: Router,
        component: Component,
        periods: Mapping[int, float],
        *,
        share: float | None = None,
    ) -> None:
        self._board = board
        self._links = links
        self._component = component
        self._periods = dict(periods)
        self._share = share
        self._scale = Encoder(1, component.component_id)
        self._wrappers: dict[tuple[str, int], Wrapper] = {}  # by link and system id
        self._forms: dict[int, _Form] = {}  # by the identity of a value that is on its way
        self._sizes: dict[int, int] = {}  # likewise [bytes]
        logs = _Outlet(
            Stream(self._periods, lambda value: 0), lambda value: component.send(self._form(value).message, LOGS)
        )
        self._outlets = {LOGS: logs}
        self._waiting: set[str] = set()  # links that have to wait: what is said meanwhile is sent when they are up

    def renew(self, periods: Mapping[int, float]) -> None:
        """Take over other usual periods [s], by message id."""
        self._periods |= periods

    def queue_texts(self, texts: list[v.Text]) -> None:
        """Put the parts of a text in line on every link."""
        self._rooms()
        for outlet in self._outlets.values():
            outlet.stream.queue_texts(texts)

    def quiet(self, now: float) -> bool:
        """Tell whether there is nothing to send at ``now`` [s]."""
        return all(
            url in self._waiting or outlet.stream.quiet(self._board, now) for url, outlet in self._outlets.items()
        )

    def flow(self, now: float) -> None:
        """Send what is due at ``now`` [s] and has room."""
        if self.quiet(now) and not self._waiting:
            return
        for url, room in self._rooms().items():
            outlet = self._outlets[url]
            for value in outlet.stream.due(self._board, now, room):
                outlet.send(value)
        self._forms.clear()
        self._sizes.clear()

    def set_period(self, link: str, message_id: int, period: float | None) -> bool:
        """Tell a message on a link every ``period`` [s] (infinite: never, None: as usual); False: impossible.

        A heartbeat never comes later than usual.
        """
        if message_id == BEAT and period is not None and period > self._periods[BEAT]:
            return False
        return link in self._outlets and self._outlets[link].stream.set_period(message_id, period)

    def period(self, link: str, message_id: int) -> float | None:
        """Return how often a message is sent on a link [s], infinite: never; None: it is no stream of ours."""
        return self._outlets[link].stream.period(message_id) if link in self._outlets else None

    def request(self, link: str, message_id: int) -> bool:
        """Tell a message once more on a link, soon; False: there is nothing of it to tell."""
        return link in self._outlets and self._outlets[link].stream.request(self._board, message_id)

    def _rooms(self) -> dict[str, float]:
        """Return how many bytes each link takes; those that are new get their stream."""
        rooms = {LOGS: math.inf}
        self._waiting = set()
        for status in self._links.status():
            rooms[status.url] = self._room(status)
            if status.url not in self._outlets:
                self._outlets[status.url] = self._outlet(status.url, status.role == "autopilot")
            stream = self._outlets[status.url].stream
            stream.most, stream.claimed = status.most, status.claimed
        if self._share is not None:
            for url, rate in self._links.rates().items():
                self._outlets[url].stream.limit = self._share * rate
        return rooms

    def _room(self, status: LinkStatus) -> float:
        """Return how many bytes a link takes: none while it is down, a heartbeat until our system id is known."""
        if status.up and self._links.system_id:
            return status.room
        self._waiting.add(status.url)
        return min(status.room, RESERVE) if status.up else 0.0

    def _outlet(self, url: str, tunnel: bool) -> _Outlet:
        if tunnel:
            return _Outlet(Stream(self._periods, self._size_inside), lambda value: self._send_inside(value, url))
        return _Outlet(Stream(self._periods, self._size), lambda value: self._send(value, url))

    def _form(self, value: Content) -> _Form:
        """Return what a value looks like on the wire: the same on every link, and made once."""
        if id(value) not in self._forms:
            message = value.make() if isinstance(value, Sampled) else message_of(value)
            self._forms[id(value)] = _Form(value, message)
        return self._forms[id(value)]

    def _size(self, value: Content) -> int:
        """Return the size of a value's frame, signed [bytes]; logs do not ask."""
        if id(value) not in self._sizes:
            self._sizes[id(value)] = len(self._scale.encode(self._form(value).message)) + SIGNATURE
        return self._sizes[id(value)]

    def _size_inside(self, value: Content) -> int:
        return self._size(value) + (AROUND if type(value) in OURS else 0)

    def _send(self, value: Content, url: str) -> None:
        self._component.repeat(self._form(value).message, url)

    def _send_inside(self, value: Content, url: str) -> None:
        """Send a value on the link of an autopilot, which drops what it does not know."""
        if type(value) not in OURS:
            self._send(value, url)
            return
        who = self._links.system_id or 1
        wrapper = self._wrappers.setdefault((url, who), Wrapper(who, self._component.component_id))
        self._component.repeat(wrapper.wrap(self._form(value).message), url)
