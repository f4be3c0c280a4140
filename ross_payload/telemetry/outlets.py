"""One stream for every link, and one for the logs: what is on the board goes out here."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from ross_payload.config import Telemetry as TelemetryConfig
from ross_payload.links import Component, Links, LinkStatus
from ross_payload.telemetry.streams import COMPUTER, MESSAGE_IDS, RESERVE, Board, Stream
from ross_protocols import values as v
from ross_protocols.codec import Encoder, message_of
from ross_protocols.tunnel import Wrapper

LOGS = "local"  # the link on which only logs and our own components listen
SIGNATURE = 13  # bytes
AROUND = 17  # bytes of a TUNNEL beside the frame that it carries
REPEAT = 5.0  # [s], of what was found out, for those who join late or lost it
USUAL = {
    v.Heartbeat: 1.0, v.Information: REPEAT, v.Source: REPEAT, v.Alignment: REPEAT, v.Separation: REPEAT,
    v.Audio: 1.0, v.Recording: REPEAT, v.LinkReport: REPEAT, v.Density: 8.0, v.Isolation: 8.0,
    COMPUTER: REPEAT,
}  # fmt: skip  # [s]
BEAT = MESSAGE_IDS[v.Heartbeat]
OURS = frozenset(kind for kind, number in MESSAGE_IDS.items() if 54000 <= number < 54020)


def periods(config: TelemetryConfig) -> dict[int, float]:
    """Return how often each message is told [s] by its id; infinite: never."""
    mirror = 1 / config.mirror_hz if config.mirror_hz else math.inf
    every = USUAL | {v.Status: 1 / config.status_hz, v.Named: mirror, v.Array: mirror}
    return {MESSAGE_IDS[kind]: period for kind, period in every.items()}


@dataclass(frozen=True, slots=True)
class _Outlet:
    stream: Stream
    send: Callable[[v.Value], None]


class _Form(NamedTuple):
    value: v.Value  # kept, so that its identity stays its own
    message: Any  # pymavlink's
    size: int  # of its frame, signed [bytes]


class Outlets:
    """Everything that is told, by link."""

    def __init__(self, board: Board, links: Links, component: Component, config: TelemetryConfig) -> None:
        self._board = board
        self._links = links
        self._component = component
        self._periods = periods(config)
        self._scale = Encoder(1, component.id)
        self._wrappers: dict[tuple[str, int], Wrapper] = {}  # by link and system id
        self._forms: dict[int, _Form] = {}  # by the identity of a value that is on its way
        logs = _Outlet(
            Stream(self._periods, lambda value: 0), lambda value: component.send(self._form(value).message, LOGS)
        )
        self._outlets = {LOGS: logs}
        self._waiting: set[str] = set()  # links that have to wait: what is said meanwhile is told when they are up

    def renew(self, config: TelemetryConfig) -> None:
        """Take over the usual rates of a configuration."""
        self._periods |= periods(config)

    def say(self, texts: list[v.Text]) -> None:
        """Put the parts of a text in line on every link."""
        self._rooms()
        for outlet in self._outlets.values():
            outlet.stream.say(texts)

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

    def set_period(self, link: str, message_id: int, period: float | None) -> bool:
        """Tell a message on a link every ``period`` [s] (infinite: never, None: as usual); False: impossible.

        A heartbeat never comes later than usual.
        """
        if message_id == BEAT and period is not None and period > USUAL[v.Heartbeat]:
            return False
        return link in self._outlets and self._outlets[link].stream.set_period(message_id, period)

    def period(self, link: str, message_id: int) -> float | None:
        """Return how often a message is told on a link [s], infinite: never; None: it is no stream of ours."""
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

    def _form(self, value: v.Value) -> _Form:
        """Return what a value looks like on the wire: the same on every link, and made once."""
        if id(value) not in self._forms:
            message = message_of(value)
            self._forms[id(value)] = _Form(value, message, len(self._scale.encode(message)) + SIGNATURE)
        return self._forms[id(value)]

    def _size(self, value: v.Value) -> int:
        return self._form(value).size

    def _size_inside(self, value: v.Value) -> int:
        return self._form(value).size + (AROUND if type(value) in OURS else 0)

    def _send(self, value: v.Value, url: str) -> None:
        self._component.repeat(self._form(value).message, url)

    def _send_inside(self, value: v.Value, url: str) -> None:
        """Send a value on the link of an autopilot, which drops what it does not know."""
        if type(value) not in OURS:
            self._send(value, url)
            return
        who = self._links.system_id or 1
        wrapper = self._wrappers.setdefault((url, who), Wrapper(who, self._component.id))
        self._component.repeat(wrapper.wrap(self._form(value).message), url)
