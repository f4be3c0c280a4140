"""Messages on request: once (512), or more or less often (511, 510).

The streams of every link belong to `ross_payload.telemetry.service`; here they are asked, and asked to change.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, Protocol

from ross_payload.telemetry.allowance import Allowance
from ross_payload.telemetry.identity import Endpoint, basic_message, protocol_message, version_message
from ross_payload.telemetry.metadata import files, metadata_message
from ross_protocols.commands import Command, Result
from ross_protocols.dialect import common, standard

REQUEST_MESSAGE = common.MAV_CMD_REQUEST_MESSAGE
SET_INTERVAL = common.MAV_CMD_SET_MESSAGE_INTERVAL
GET_INTERVAL = common.MAV_CMD_GET_MESSAGE_INTERVAL
VERSION, PROTOCOL = common.MAVLINK_MSG_ID_AUTOPILOT_VERSION, standard.MAVLINK_MSG_ID_PROTOCOL_VERSION
BASIC = standard.MAVLINK_MSG_ID_COMPONENT_INFORMATION_BASIC
METADATA = standard.MAVLINK_MSG_ID_COMPONENT_METADATA
OLD_REQUESTS = {
    common.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES: VERSION,
    common.MAV_CMD_REQUEST_PROTOCOL_VERSION: PROTOCOL,
}  # commands from before there was REQUEST_MESSAGE

USUAL, NEVER = 0, -1  # as intervals on the wire [us]
SHORTEST = 20_000  # [us]
LONGEST = 2**31 - 1  # [us]
LARGEST_ID = 2**16 - 1  # of MESSAGE_INTERVAL
BURST, RATE = 30, 10.0  # messages on request at once, and [1/s]


class Verdict(NamedTuple):
    """What becomes of a command, and why."""

    result: Result
    reason: str = ""


ACCEPTED = Verdict(Result.ACCEPTED)


class Streams(Protocol):
    """What each link is told regularly; a period is in seconds, infinite: never."""

    def request(self, link: str, message_id: int) -> bool:
        """Tell a message once more, soon; False: there is nothing of it to tell."""

    def period(self, link: str, message_id: int) -> float | None:
        """Return how often a message is told; None: there is no such stream."""

    def set_period(self, link: str, message_id: int, period: float | None) -> bool:
        """Tell a message so often, None: as usual; False: there is no such stream."""


class Requests:
    """Obeys the commands that ask for messages; whoever calls acknowledges them.

    ``made`` makes what there is only on request, by message id; None: what the payload itself has.
    """

    def __init__(
        self, endpoint: Endpoint, streams: Streams, made: Mapping[int, Callable[[], Any]] | None = None
    ) -> None:
        self._endpoint = endpoint
        self._streams = streams
        self._allowance = Allowance(BURST, RATE)
        self._now = 0.0
        self._made = self._of_the_payload() if made is None else made
        self._commands: Mapping[int, Callable[[Command, str], Verdict]] = {
            REQUEST_MESSAGE: self._request,
            SET_INTERVAL: self._set_interval,
            GET_INTERVAL: self._get_interval,
            **{old: self._old_request for old, number in OLD_REQUESTS.items() if number in self._made},
        }

    def _of_the_payload(self) -> Mapping[int, Callable[[], Any]]:
        content = files()
        return {
            VERSION: version_message,
            PROTOCOL: protocol_message,
            BASIC: lambda: basic_message(self._now),
            METADATA: lambda: metadata_message(content, self._now),
        }

    def obey(self, command: Command, link: str, now: float) -> Verdict | None:
        """Obey a command that came on a link; None: it is not one of these."""
        if command.number not in self._commands:
            return None
        self._now = now
        if not self._allowance.take(now):
            return Verdict(Result.TEMPORARILY_REJECTED)
        return self._commands[command.number](command, link)

    def _request(self, command: Command, link: str) -> Verdict:
        message_id = _message_id(command)
        if message_id is not None and message_id in self._made:
            self._endpoint.send(self._made[message_id](), link)
            return ACCEPTED
        if message_id is None or self._streams.period(link, message_id) is None:
            return Verdict(Result.DENIED)
        return ACCEPTED if self._streams.request(link, message_id) else Verdict(Result.TEMPORARILY_REJECTED)

    def _old_request(self, command: Command, link: str) -> Verdict:
        self._endpoint.send(self._made[OLD_REQUESTS[command.number]](), link)
        return ACCEPTED

    def _set_interval(self, command: Command, link: str) -> Verdict:
        message_id, interval = _message_id(command), command.numbers[1]
        if message_id is None or self._streams.period(link, message_id) is None:
            return Verdict(Result.DENIED)
        periods = {USUAL: None, NEVER: math.inf}
        if interval not in periods and not SHORTEST <= interval <= LONGEST:
            wanted = f"{NEVER}, {USUAL}, or at least {SHORTEST} us"
            return Verdict(Result.DENIED, f"interval: expected {wanted}, got {interval:g}")
        if message_id == common.MAVLINK_MSG_ID_HEARTBEAT and interval == NEVER:
            return Verdict(Result.DENIED, "the heartbeat cannot be disabled")
        done = self._streams.set_period(link, message_id, periods.get(int(interval), interval / 1e6))
        return ACCEPTED if done else Verdict(Result.DENIED)

    def _get_interval(self, command: Command, link: str) -> Verdict:
        message_id = _message_id(command)
        if message_id is None or message_id > LARGEST_ID:
            return Verdict(Result.DENIED)
        interval = _interval(self._streams.period(link, message_id))
        self._endpoint.send(common.MAVLink_message_interval_message(message_id, interval), link)
        return ACCEPTED


def _message_id(command: Command) -> int | None:
    number = command.numbers[0]
    return int(number) if 0 <= number < 2**24 and number % 1 == 0 else None


def _interval(period: float | None) -> int:
    """Return a period as MESSAGE_INTERVAL says it [us]; 0: there is no such message, -1: never."""
    if period is None:
        return 0
    return NEVER if math.isinf(period) else min(round(period * 1e6), LONGEST)
