"""What the gimbal says: streams whose rate every link may choose, and messages on request."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from ross_payload.links import Component, Links
from ross_payload.telemetry.streams import Every
from ross_protocols.dialect import common

BEAT = common.MAVLINK_MSG_ID_HEARTBEAT
LOGS = "local"  # the link on which only logs and our own components listen
SHORTEST = 0.02  # [s]
LOOKING = 1.0  # [s] between two looks for new links
SHARE = 1 / 3  # of the budget of a link that the streams may take, beside the heartbeat
FRAME = 75  # bytes of the largest of them, signed
EARLY = 1e-6  # [s], of rounding


class Voice:
    """The streams of one component.

    Parameters
    ----------
    links, component
        Where it speaks, and as whom.
    streams
        What makes each message that is sent regularly, and its usual period [s], by message id.
    """

    def __init__(
        self, links: Links, component: Component, streams: Mapping[int, tuple[Callable[[], Any], float]]
    ) -> None:
        self._links = links
        self._component = component
        self._streams = streams
        self._asked: dict[tuple[str, int], float] = {}  # period [s] by link and message
        self._due: dict[tuple[str, int], float] = {}  # [s]
        self._rates: dict[str, float] = {}  # of the links [bytes/s]
        self._looking = Every(LOOKING)

    def tick(self, now: float) -> None:
        """Say what is due at ``now`` [s]: the same to all, once."""
        if self._looking.due(now):
            self._rates = self._links.rates()
        for number, (make, _) in self._streams.items():
            urls = [url for url in (LOGS, *self._rates) if self._is_due(url, number, now)]
            message = make() if urls else None
            for url in urls:
                say = self._component.send if url == LOGS else self._component.repeat
                say(message, url)

    def request(self, link: str, message_id: int) -> bool:
        """Say a message once more on a link."""
        self._component.send(self._streams[message_id][0](), link)
        return True

    def period(self, link: str, message_id: int) -> float | None:
        """Return how often a message is said on a link [s]; None: it is no stream of ours."""
        if message_id not in self._streams:
            return None
        return self._wanted(link, message_id) * (1.0 if message_id == BEAT else self._stretch(link))

    def set_period(self, link: str, message_id: int, period: float | None) -> bool:
        """Say a message so often on a link (infinite: never, None: as usual); a heartbeat is never slower."""
        usual = self._streams[message_id][1]
        if message_id == BEAT and period is not None and period > usual:
            return False
        self._asked[link, message_id] = usual if period is None else max(period, SHORTEST)
        self._due.pop((link, message_id), None)
        return True

    def _wanted(self, link: str, message_id: int) -> float:
        return self._asked.get((link, message_id), self._streams[message_id][1])

    def _stretch(self, link: str) -> float:
        """Return by how much the periods on a link are longer than wanted, so that its budget leaves room to others."""
        wanted = sum(FRAME / self._wanted(link, number) for number in self._streams if number != BEAT)
        return max(wanted / (SHARE * self._rates.get(link, math.inf)), 1.0)

    def _is_due(self, url: str, number: int, now: float) -> bool:
        period = self.period(url, number)
        due = self._due.get((url, number), now)
        if period is None or math.isinf(period) or now < due - EARLY:
            return False
        self._due[url, number] = due + period if due + period > now else now + period
        return True
