"""Messages on request: once (512), or more or less often (511, 510)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from ross_payload.mavlink import component_info
from ross_payload.mavlink.command_server import ACCEPTED, Handler, Verdict
from ross_payload.mavlink.component import Component, Received
from ross_payload.mavlink.message_scheduler import MessageScheduler
from ross_payload.token_bucket import TokenBucket
from ross_protocols.mavlink.commands import Command, Result
from ross_protocols.mavlink.dialect import common, ross

REQUEST_MESSAGE = common.MAV_CMD_REQUEST_MESSAGE
SET_INTERVAL = common.MAV_CMD_SET_MESSAGE_INTERVAL
GET_INTERVAL = common.MAV_CMD_GET_MESSAGE_INTERVAL
INTERVAL = common.MAVLINK_MSG_ID_MESSAGE_INTERVAL  # its first number is the id of the message that is meant
VERSION, PROTOCOL = common.MAVLINK_MSG_ID_AUTOPILOT_VERSION, ross.MAVLINK_MSG_ID_PROTOCOL_VERSION
BASIC = ross.MAVLINK_MSG_ID_COMPONENT_INFORMATION_BASIC
METADATA = ross.MAVLINK_MSG_ID_COMPONENT_METADATA
OLD_REQUESTS = {
    common.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES: VERSION,
    common.MAV_CMD_REQUEST_PROTOCOL_VERSION: PROTOCOL,
}  # commands from before there was REQUEST_MESSAGE

USUAL, NEVER = 0, -1  # as intervals on the wire [us]
SHORTEST = 20_000  # [us]
LONGEST = 2**31 - 1  # [us]
LARGEST_ID = 2**16 - 1  # of MESSAGE_INTERVAL
BURST, RATE = 30, 10.0  # messages on request at once, and [1/s]


class MessageRequests:
    """Obeys the commands that ask for messages.

    ``made`` makes what there is only on request, by message id; None: what the payload itself has.
    """

    def __init__(
        self, component: Component, scheduler: MessageScheduler, made: Mapping[int, Callable[[], Any]] | None = None
    ) -> None:
        self._component = component
        self._scheduler = scheduler
        self._bucket = TokenBucket(BURST, RATE)
        self._now = 0.0
        self._made = self._of_the_payload() if made is None else made
        self.handlers: Mapping[int, Handler] = {  # for the command server, by command
            REQUEST_MESSAGE: self._limited(self._request),
            SET_INTERVAL: self._limited(self._set_interval),
            GET_INTERVAL: self._limited(self._get_interval),
            **{old: self._limited(self._old_request) for old, number in OLD_REQUESTS.items() if number in self._made},
        }

    def _of_the_payload(self) -> Mapping[int, Callable[[], Any]]:
        content = component_info.files()
        return {
            VERSION: component_info.version_message,
            PROTOCOL: component_info.protocol_message,
            BASIC: lambda: component_info.basic_message(self._now),
            METADATA: lambda: component_info.metadata_message(content, self._now),
        }

    def _limited(self, obey: Callable[[Command, str], Verdict]) -> Handler:
        """Return what obeys a command that came on a link, unless too much is asked for."""

        def handler(command: Command, received: Received, now: float) -> Verdict:
            self._now = now
            if not self._bucket.spend(now):
                return Verdict(Result.TEMPORARILY_REJECTED)
            return obey(command, received.link)

        return handler

    def _request(self, command: Command, link: str) -> Verdict:
        message_id = _message_id(command.numbers[0])
        if message_id == INTERVAL:
            return self._tell_interval(command.numbers[1], link)
        if message_id is not None and message_id in self._made:
            self._component.send(self._made[message_id](), link)
            return ACCEPTED
        if message_id is None or self._scheduler.period(link, message_id) is None:
            return Verdict(Result.DENIED)
        return ACCEPTED if self._scheduler.request(link, message_id) else Verdict(Result.TEMPORARILY_REJECTED)

    def _old_request(self, command: Command, link: str) -> Verdict:
        self._component.send(self._made[OLD_REQUESTS[command.number]](), link)
        return ACCEPTED

    def _set_interval(self, command: Command, link: str) -> Verdict:
        message_id, interval = _message_id(command.numbers[0]), command.numbers[1]
        if message_id is None or self._scheduler.period(link, message_id) is None:
            return Verdict(Result.DENIED)
        periods = {USUAL: None, NEVER: math.inf}
        if interval not in periods and not SHORTEST <= interval <= LONGEST:
            wanted = f"{NEVER}, {USUAL}, or at least {SHORTEST} us"
            return Verdict(Result.DENIED, f"interval: expected {wanted}, got {interval:g}")
        if message_id == common.MAVLINK_MSG_ID_HEARTBEAT and interval == NEVER:
            return Verdict(Result.DENIED, "the heartbeat cannot be disabled")
        done = self._scheduler.set_period(link, message_id, periods.get(int(interval), interval / 1e6))
        return ACCEPTED if done else Verdict(Result.DENIED)

    def _get_interval(self, command: Command, link: str) -> Verdict:
        return self._tell_interval(command.numbers[0], link)

    def _tell_interval(self, number: float, link: str) -> Verdict:
        message_id = _message_id(number)
        if message_id is None or message_id > LARGEST_ID:
            return Verdict(Result.DENIED)
        interval = _interval(self._scheduler.period(link, message_id))
        self._component.send(common.MAVLink_message_interval_message(message_id, interval), link)
        return ACCEPTED


def _message_id(number: float) -> int | None:
    return int(number) if 0 <= number < 2**24 and number % 1 == 0 else None


def _interval(period: float | None) -> int:
    """Return a period as MESSAGE_INTERVAL says it [us]; 0: there is no such message, -1: never."""
    if period is None:
        return 0
    return NEVER if math.isinf(period) else min(round(period * 1e6), LONGEST)
