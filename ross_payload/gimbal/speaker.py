"""The gimbal on the links: what it says regularly and on request, and which packets are for it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ross_payload.gimbal.body import Body
from ross_payload.gimbal.commands import Commands
from ross_payload.gimbal.roles import Make, Role
from ross_payload.gimbal.rules import Rules
from ross_payload.gimbal.voice import BEAT, Voice
from ross_payload.interfaces import Clock
from ross_payload.links import Heard, Links
from ross_payload.telemetry.identity import Endpoint
from ross_payload.telemetry.requests import Requests
from ross_protocols.gimbal import DEVICE_ATTITUDE, DEVICE_INFORMATION
from ross_protocols.own_gimbal import (
    FAULTS,
    Pose,
    attitude_status,
    device_information,
    flags_of,
    heartbeat,
    set_point_of,
)

BEATING, TELLING = 1.0, 0.1  # [s] between two heartbeats, and two attitudes


class Speaker:
    """One component, in one of the two roles.

    Parameters
    ----------
    body, rules
        What turns, and who is obeyed.
    role
        What the mode adds to a device.
    """

    def __init__(self, clock: Clock, links: Links, component_id: int, *, body: Body, rules: Rules, role: Role) -> None:
        self._clock = clock
        self._body = body
        self._rules = rules
        self._role = role
        self._endpoint = Endpoint(links, component_id)
        self._device_ids = 0, role.device_id, component_id
        number = role.device_id
        streams: dict[int, tuple[Make, float]] = {
            BEAT: (lambda boot: heartbeat(well=not self._pose().failures & FAULTS), BEATING),
            DEVICE_ATTITUDE: (lambda boot: attitude_status(boot, number, self._pose()), TELLING),
        }
        streams |= role.streams(lambda: flags_of(self._pose()))
        made = {DEVICE_INFORMATION: lambda boot: device_information(boot, number, body.axis())} | role.made(body.axis)
        timed = {number: (self._timed(make), period) for number, (make, period) in streams.items()}
        self._voice = Voice(links, links.component(component_id), timed)
        on_request = {number: self._timed(make) for number, make in made.items()}
        requests = Requests(self._endpoint, self._voice, on_request)
        self._commands = Commands(self._endpoint, requests, role.rules, self._device_ids)
        links.component(component_id).subscribe(self._hear)

    def tick(self, now: float) -> None:
        """Say what is due."""
        self._voice.tick(now)

    def _hear(self, heard: Heard) -> None:
        """Take a packet from the links."""
        self._commands.heard(heard, self._clock.now())
        message = heard.packet.message
        if message.get_msgId() not in self._role.numbers:
            return
        asked = set_point_of(message)
        if asked is not None and self._endpoint.meant(*asked.target) and asked.device_id in self._device_ids:
            self._role.asked(asked.aim, heard)

    def _pose(self) -> Pose:
        return self._body.pose(self._clock.now(), self._rules.aim, self._role.failures)

    def _timed(self, make: Make) -> Callable[[], Any]:
        return lambda: make(round(self._clock.now() * 1e3) % 2**32)
