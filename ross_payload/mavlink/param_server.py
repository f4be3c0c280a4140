"""The parameter server: the closed table of `ross_payload.config.parameter_table` on the links.

`on_packet` takes what arrives and `tick` the time, both on the thread of the pump. Answers leave one every `PACE`, on a
link with a budget no faster than half of it carries them: a whole list does not crowd out telemetry, and is not dropped
for want of room. A change is told everywhere at once, and where that is too fast once more in time. No parameter waits
in line more than once for a link. What a client has missed it asks for again. A ground station that appears is sent one
value without having asked: QGroundControl asks for the others of a component only after it has received one. A request
for what does not exist, or a value that is not allowed, is answered with a PARAM_ERROR: a client that knows it need not
ask five times more.
"""

from __future__ import annotations

import math
from collections import OrderedDict, deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from ross_payload.config.parameter_store import Parameters
from ross_payload.config.parameter_table import TABLE, value_of
from ross_payload.errors import ConfigError
from ross_payload.mavlink.component import Component, Received, Way
from ross_payload.token_bucket import TokenBucket
from ross_protocols.mavlink import params
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.values import Severity

PACE = 0.04  # [s] between two answers: 25 a second, 925 bytes/s
SIZE = 50  # of an answer, signed [bytes]
SHARE = 0.5  # of what a link may carry: telemetry has the rest
EVERYWHERE = None  # as a link: all of them
MOST = 8 * len(TABLE)  # answers in line
BURST, RATE = 40, 20.0  # values that are set at once, and [1/s]; what is more is as if lost
GREETINGS, AGAIN = 3, 5.0  # values told unasked to a ground station that asks for nothing, one every so many seconds
AWAY = 5.0  # [s] of silence after which a ground station that is heard again has restarted
MOST_STATIONS = 64  # that are remembered
GREETING_BURST, GREETING_RATE = 8, 1.0  # of all ground stations at once, and [1/s]

NAMES = tuple(TABLE)


@dataclass(slots=True)
class _Station:
    """A ground station on one way."""

    received_at: float  # last [s]
    left: int = GREETINGS  # values that it may still be told unasked
    due: float = 0.0  # the next one [s]


class ParamServer:
    """Answers what is asked of our component about parameters.

    Parameters
    ----------
    component
        Ours.
    parameters
        What is in force, and keeps what is set.
    changed
        Is told the name and the value of everything that is set.
    send_text
        Tells an operator something.
    rates
        Tells what every link may carry [bytes/s], by its URL.
    """

    def __init__(
        self,
        component: Component,
        parameters: Parameters,
        changed: Callable[[str, float], None],
        send_text: Callable[[Severity, str], None],
        rates: Callable[[], Mapping[str, float]] = dict,
    ) -> None:
        self._component = component
        self._parameters = parameters
        self._changed = changed
        self._send_text = send_text
        self._rates = rates
        self._free: dict[str | None, float] = {}  # when a link may take the next answer [s]
        self._calm: dict[str | None, float] = {}  # and when it has carried all changes, too [s]
        self._again: set[tuple[int, str | None]] = set()  # of those in line, what is told once more
        self._waiting: deque[tuple[int, str | None]] = deque()  # index and link
        self._known = parameters.config
        self._due = 0.0
        self._now = 0.0
        self._notes = deque(parameters.notes)
        self._trouble = ""
        self._texts = TokenBucket(burst=4, rate=0.5)
        self._settable = TokenBucket(BURST, RATE)
        self._errors = TokenBucket(burst=10, rate=5.0)
        self._greetings = TokenBucket(GREETING_BURST, GREETING_RATE)
        self._stations: OrderedDict[tuple[Way, ComponentId], _Station] = OrderedDict()  # who was heard last is last
        component.subscribe(self.on_packet, common.MAVLINK_MSG_ID_HEARTBEAT, *params.REQUESTS)

    def on_packet(self, received: Received) -> None:
        """Take a packet; what does not ask about our parameters passes by."""
        if (
            received.may_order
            and received.packet.name == "HEARTBEAT"
            and received.packet.message.type == common.MAV_TYPE_GCS
        ):
            self._greet(received)
        request = params.request_of(received.packet.message)
        if request is None or not request.target.includes(self._component.id):
            return
        if not received.may_order:
            if received.refusal and isinstance(request, params.SetRequest) and self._texts.spend(self._now):
                self._send_text(Severity.WARNING, f"{request.name} not set: {received.refusal}")
            return
        station = self._stations.get(_who(received))
        if station is not None:
            station.left = 0  # it knows us
        match request:
            case params.ListRequest():
                for index in range(len(NAMES)):
                    self._answer(index, received.link)
            case params.ReadRequest():
                index = NAMES.index(request.name) if request.index < 0 and request.name in TABLE else request.index
                if 0 <= index < len(NAMES):
                    self._answer(index, received.link)
                else:
                    self._refuse(request, params.ParamError.DOES_NOT_EXIST, received)
            case params.SetRequest() if request.name not in TABLE:
                self._refuse(request, params.ParamError.DOES_NOT_EXIST, received)
            case params.SetRequest() if self._settable.spend(self._now) and not self._set(request.name, request.value):
                self._refuse(request, params.ParamError.VALUE_OUT_OF_RANGE, received)

    def tick(self, now: float) -> None:
        """Send the next answer when it is due; tell what there is to tell about the file."""
        self._now = now
        self._look()
        if self._waiting and now >= self._due:
            self._answer_next(now)
        if self._notes:
            self._send_text(Severity.WARNING, self._notes.popleft())
        if self._parameters.trouble != self._trouble:
            self._trouble = self._parameters.trouble
            if self._trouble:
                self._send_text(Severity.ERROR, self._trouble)

    def _answer_next(self, now: float) -> None:
        """Send the first answer whose link has carried the one before."""
        ready = next((each for each in self._waiting if now >= self._ready_at(each)), None)
        if ready is None:
            return
        self._waiting.remove(ready)
        self._again.discard(ready)
        index, link = ready
        name = NAMES[index]
        self._component.send(params.value_message(name, self._parameters.value(name), index, len(NAMES)), link)
        self._due = now + PACE
        for url, rate in self._rates().items():
            if link not in (EVERYWHERE, url):
                continue
            if link is EVERYWHERE and now < self._calm.get(url, -math.inf):
                self._answer(index, url)  # there it may have found no room: once more, in time
                self._again.add((index, url))
            self._calm[url] = now + SIZE / (SHARE * rate)
            if now >= self._free.get(url, -math.inf):  # changes without end hold up no list
                self._free[url] = self._calm[url]

    def _ready_at(self, answer: tuple[int, str | None]) -> float:
        """When the link of an answer has carried what came before it [s]."""
        return (self._calm if answer in self._again else self._free).get(answer[1], -math.inf)

    def _greet(self, received: Received) -> None:
        """Tell a ground station that has just appeared one value, and again until it asks for others."""
        if not self._component.system_id:
            return
        who, now = _who(received), self._now
        station = self._stations.pop(who, None)
        if station is None or now - station.received_at > AWAY:
            station = _Station(now, due=now)
        self._stations[who] = station
        station.received_at = now
        if len(self._stations) > MOST_STATIONS:
            self._stations.popitem(last=False)
        if station.left and now >= station.due and self._greetings.spend(now):
            station.left, station.due = station.left - 1, now + AGAIN
            self._answer(0, received.link)

    def _look(self) -> None:
        """Tell everybody what was set by another way than ours."""
        before, self._known = self._known, self._parameters.config
        if before is not self._known:
            for index, name in enumerate(NAMES):
                if value_of(before, name) != value_of(self._known, name):
                    self._answer(index, EVERYWHERE)

    def _set(self, name: str, value: float) -> bool:
        """Set a value, or say why not; either way everybody is told which one is in force."""
        before, allowed = self._parameters.value(name), True
        try:
            self._parameters.set(name, value)
        except ConfigError as error:
            allowed = False
            if self._texts.spend(self._now):
                self._send_text(Severity.WARNING, str(error))
        if self._parameters.value(name) != before:
            self._changed(name, self._parameters.value(name))
        self._answer(NAMES.index(name), EVERYWHERE)
        return allowed

    def _refuse(
        self, request: params.ReadRequest | params.SetRequest, error: params.ParamError, received: Received
    ) -> None:
        """Tell the sender why not, unless it asked everybody or asks too often."""
        if request.target.component == self._component.component_id and self._errors.spend(self._now):
            self._component.send(params.error_message(request, error, received.packet.sender), received.link)

    def _answer(self, index: int, link: str | None) -> None:
        """Put an answer in line, unless it waits there already."""
        if (index, link) not in self._waiting and len(self._waiting) < MOST:
            self._waiting.append((index, link))


def _who(received: Received) -> tuple[Way, ComponentId]:
    """Return whom a packet came from, and on which way: several stations have the same ids by default."""
    return received.way, received.packet.sender
