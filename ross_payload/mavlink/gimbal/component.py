"""The gimbal on the links: what it sends regularly and on request, which commands and set-points are for it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ross_payload.errors import ConfigError
from ross_payload.interfaces import Clock
from ross_payload.mavlink.command_server import ACCEPTED, CommandServer, Handler, Verdict
from ross_payload.mavlink.component import Received
from ross_payload.mavlink.gimbal.control_arbiter import AWAY, UNCHANGED, ControlArbiter
from ross_payload.mavlink.gimbal.device_state import DeviceState
from ross_payload.mavlink.gimbal.roles import Make, Role
from ross_payload.mavlink.message_board import Board, Rank, Sampled
from ross_payload.mavlink.message_requests import MessageRequests
from ross_payload.mavlink.message_scheduler import BEAT, MessageScheduler
from ross_payload.mavlink.router import Router
from ross_protocols.mavlink.commands import Command, Result
from ross_protocols.mavlink.gimbal_device import (
    FAULTS,
    PITCHYAW,
    Pose,
    attitude_status,
    commanded,
    device_information,
    flags_of,
    heartbeat,
    set_point_of,
)
from ross_protocols.mavlink.gimbal_messages import CONFIGURE, DEVICE_ATTITUDE, DEVICE_INFORMATION, MANAGER_STATUS

HEARTBEAT_PERIOD_S, ATTITUDE_PERIOD_S = 1.0, 0.1
SHARE = 1 / 3  # of the budget of a link that the messages may take, beside the heartbeat
RANKS = {BEAT: Rank.HEARTBEAT, DEVICE_ATTITUDE: Rank.GIMBAL_ATTITUDE, MANAGER_STATUS: Rank.GIMBAL_MANAGER}


class GimbalComponent:
    """One component, in one of the two roles.

    Parameters
    ----------
    device, arbiter
        What turns, and who is obeyed.
    role
        What the mode adds to a device.
    """

    def __init__(
        self,
        clock: Clock,
        links: Router,
        component_id: int,
        *,
        device: DeviceState,
        arbiter: ControlArbiter,
        role: Role,
    ) -> None:
        self._clock = clock
        self._device = device
        self._arbiter = arbiter
        self._role = role
        self._component = links.component(component_id)
        self._device_ids = 0, role.device_id, component_id
        number = role.device_id
        streams: dict[int, tuple[Make, float]] = {
            BEAT: (lambda boot: heartbeat(well=not self._pose().failures & FAULTS), HEARTBEAT_PERIOD_S),
            DEVICE_ATTITUDE: (lambda boot: attitude_status(boot, number, self._pose()), ATTITUDE_PERIOD_S),
        }
        streams |= role.streams(lambda: flags_of(self._pose()))
        board = Board()
        for message_id, (make, _) in streams.items():
            board.put(RANKS[message_id], [Sampled(message_id, self._timed(make))])
        periods = {message_id: period for message_id, (_, period) in streams.items()}
        self._scheduler = MessageScheduler(board, links, self._component, periods, share=SHARE)
        made = {DEVICE_INFORMATION: lambda boot: device_information(boot, number, device.axis())}
        on_request = {message_id: self._timed(make) for message_id, make in (made | role.made(device.axis)).items()}
        handlers: dict[int, Handler] = {**MessageRequests(self._component, self._scheduler, on_request).handlers}
        if role.is_manager:
            handlers |= {PITCHYAW: self._point, CONFIGURE: self._configure}
        self._server = CommandServer(self._component, handlers)
        self._component.subscribe(self._on_setpoint, *role.numbers)

    def tick(self, now: float) -> None:
        """Send what is due at ``now`` [s]."""
        self._server.tick(now)
        self._scheduler.flow(now)

    def _on_setpoint(self, received: Received) -> None:
        """Take a message with a set-point."""
        asked = set_point_of(received.packet.message)
        if asked is not None and asked.target.includes(self._component.id) and asked.device_id in self._device_ids:
            self._role.on_setpoint(asked.aim, received)

    def _point(self, command: Command, received: Received, now: float) -> Verdict:
        aim = commanded(command)
        if aim is None or command.numbers[6] not in self._device_ids:
            return Verdict(Result.DENIED)
        return self._arbiter.point(aim, received.packet.sender, self._clock.now())

    def _configure(self, command: Command, received: Received, now: float) -> Verdict:
        numbers, sender = command.numbers[:4], received.packet.sender
        if command.numbers[6] not in self._device_ids:
            return Verdict(Result.DENIED)
        try:
            control = self._arbiter.control.configured(numbers, sender)
        except ConfigError as error:
            return Verdict(Result.DENIED, str(error))
        self._arbiter.configure(control, sender, taken=numbers[0] not in (UNCHANGED, AWAY))
        return ACCEPTED

    def _pose(self) -> Pose:
        return self._device.pose(self._clock.now(), self._arbiter.aim, self._role.failures)

    def _timed(self, make: Make) -> Callable[[], Any]:
        return lambda: make(round(self._clock.now() * 1e3) % 2**32)
