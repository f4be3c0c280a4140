"""The parameter server: the closed table of `ross_payload.parameters` on the links.

``heard`` takes what arrives and ``tick`` the time, both on the thread of the pump. Answers leave one every `PACE`: a
whole list does not crowd out telemetry, and no parameter waits in line more than once for a link. What a client has
missed it asks for again. A ground station that appears is told one value unasked: QGroundControl asks for the others of
a component only after it has heard one. Who asks us for what does not exist, or sets what is not allowed, gets a
PARAM_ERROR: a client that knows it need not ask five times more.
"""

from __future__ import annotations

from collections import OrderedDict, deque
from collections.abc import Callable
from dataclasses import dataclass

from ross_payload.errors import ConfigError
from ross_payload.links import Heard
from ross_payload.parameters import TABLE, Parameters, value_of
from ross_payload.telemetry.allowance import Allowance
from ross_payload.telemetry.identity import Endpoint
from ross_protocols.dialect import common
from ross_protocols.params import (
    ListRequest,
    ParamError,
    ReadRequest,
    SetRequest,
    error_message,
    request_of,
    value_message,
)
from ross_protocols.values import Severity

PACE = 0.04  # [s] between two answers: 25 a second, 925 bytes/s
EVERYWHERE = None  # as a link: all of them
MOST = 8 * len(TABLE)  # answers in line
BURST, RATE = 40, 20.0  # values that are set at once, and [1/s]; what is more is as if lost
GREETINGS, AGAIN = 3, 5.0  # values told unasked to a ground station that asks for nothing, one every so many seconds
AWAY = 5.0  # [s] of silence after which a ground station that is heard again has started anew
MOST_STATIONS = 64  # that are remembered
GREETING_BURST, GREETING_RATE = 8, 1.0  # of all ground stations at once, and [1/s]

NAMES = tuple(TABLE)


@dataclass(slots=True)
class _Station:
    """A ground station on one link."""

    heard: float  # last [s]
    left: int = GREETINGS  # values that it may still be told unasked
    due: float = 0.0  # the next one [s]


class ParameterServer:
    """Answers what is asked of our component about parameters.

    Parameters
    ----------
    endpoint
        Who we are.
    parameters
        What is in force, and keeps what is set.
    changed
        Is told the name and the value of everything that is set.
    say
        Tells an operator something.
    """

    def __init__(
        self,
        endpoint: Endpoint,
        parameters: Parameters,
        changed: Callable[[str, float], None],
        say: Callable[[Severity, str], None],
    ) -> None:
        self._endpoint = endpoint
        self._parameters = parameters
        self._changed = changed
        self._say = say
        self._waiting: deque[tuple[int, str | None]] = deque()  # index and link
        self._known = parameters.config
        self._due = 0.0
        self._now = 0.0
        self._notes = deque(parameters.notes)
        self._trouble = ""
        self._texts = Allowance(burst=4, rate=0.5)
        self._settable = Allowance(BURST, RATE)
        self._errors = Allowance(burst=10, rate=5.0)
        self._greetings = Allowance(GREETING_BURST, GREETING_RATE)
        self._stations: OrderedDict[tuple[str, int, int], _Station] = OrderedDict()  # who was heard last is last

    def heard(self, heard: Heard) -> None:
        """Take a packet; what does not ask about our parameters passes by."""
        if heard.may_order and heard.packet.name == "HEARTBEAT" and heard.packet.message.type == common.MAV_TYPE_GCS:
            self._greet(heard)
        request = request_of(heard.packet.message)
        if request is None or not self._endpoint.meant(request.system_id, request.component_id):
            return
        if not heard.may_order:
            if heard.refusal and isinstance(request, SetRequest) and self._texts.take(self._now):
                self._say(Severity.WARNING, f"{request.name} not set: {heard.refusal}")
            return
        station = self._stations.get(_who(heard))
        if station is not None:
            station.left = 0  # it knows us
        match request:
            case ListRequest():
                for index in range(len(NAMES)):
                    self._answer(index, heard.link)
            case ReadRequest():
                index = NAMES.index(request.name) if request.index < 0 and request.name in TABLE else request.index
                if 0 <= index < len(NAMES):
                    self._answer(index, heard.link)
                else:
                    self._refuse(request, ParamError.DOES_NOT_EXIST, heard)
            case SetRequest() if request.name not in TABLE:
                self._refuse(request, ParamError.DOES_NOT_EXIST, heard)
            case SetRequest() if self._settable.take(self._now) and not self._set(request.name, request.value):
                self._refuse(request, ParamError.VALUE_OUT_OF_RANGE, heard)

    def tick(self, now: float) -> None:
        """Send the next answer when it is due; tell what there is to tell about the file."""
        self._now = now
        self._look()
        if self._waiting and now >= self._due:
            self._due = now + PACE
            index, link = self._waiting.popleft()
            name = NAMES[index]
            self._endpoint.send(value_message(name, self._parameters.value(name), index, len(NAMES)), link)
        if self._notes:
            self._say(Severity.WARNING, self._notes.popleft())
        if self._parameters.trouble != self._trouble:
            self._trouble = self._parameters.trouble
            if self._trouble:
                self._say(Severity.ERROR, self._trouble)

    def _greet(self, heard: Heard) -> None:
        """Tell a ground station that has just appeared one value, and again until it asks for others."""
        if not self._endpoint.system_id:
            return
        who, now = _who(heard), self._now
        station = self._stations.pop(who, None)
        if station is None or now - station.heard > AWAY:
            station = _Station(now, due=now)
        self._stations[who] = station
        station.heard = now
        if len(self._stations) > MOST_STATIONS:
            self._stations.popitem(last=False)
        if station.left and now >= station.due and self._greetings.take(now):
            station.left, station.due = station.left - 1, now + AGAIN
            self._answer(0, heard.link)

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
            if self._texts.take(self._now):
                self._say(Severity.WARNING, str(error))
        if self._parameters.value(name) != before:
            self._changed(name, self._parameters.value(name))
        self._answer(NAMES.index(name), EVERYWHERE)
        return allowed

    def _refuse(self, request: ReadRequest | SetRequest, error: ParamError, heard: Heard) -> None:
        """Tell the sender why not, unless it asked everybody or asks too often."""
        if request.component_id == self._endpoint.component_id and self._errors.take(self._now):
            sender = heard.packet.system_id, heard.packet.component_id
            self._endpoint.send(error_message(request, error, *sender), heard.link)

    def _answer(self, index: int, link: str | None) -> None:
        """Put an answer in line, unless it waits there already."""
        if (index, link) not in self._waiting and len(self._waiting) < MOST:
            self._waiting.append((index, link))


def _who(heard: Heard) -> tuple[str, int, int]:
    """Return whom a packet came from, and on which link."""
    return heard.link, heard.packet.system_id, heard.packet.component_id
