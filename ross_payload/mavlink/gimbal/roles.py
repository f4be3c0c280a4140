"""The two modes: we manage ourselves, or an autopilot manages us."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from ross_payload.interfaces import Clock
from ross_payload.mavlink import Received
from ross_payload.mavlink.gimbal.control_arbiter import ControlArbiter
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.gimbal_device import Aim, Axis, manager_information, manager_status
from ross_protocols.mavlink.gimbal_messages import MANAGER_INFORMATION, MANAGER_STATUS, NO_MANAGER
from ross_protocols.mavlink.vehicle import AUTOPILOT

REPORTING = 0.2  # [s] between two statuses of the manager
ALONE = 1.0  # [s] without a set-point, after which a device has no manager
RATE_TIMEOUT_S = 0.5  # [s] that a rate of the manager counts: it sends 50 in a second
ASKED_OF_MANAGERS: tuple[int, ...] = (
    common.MAVLINK_MSG_ID_GIMBAL_MANAGER_SET_ATTITUDE,
    common.MAVLINK_MSG_ID_GIMBAL_MANAGER_SET_PITCHYAW,
)
ASKED_OF_DEVICES: tuple[int, ...] = (common.MAVLINK_MSG_ID_GIMBAL_DEVICE_SET_ATTITUDE,)

Make = Callable[[int], Any]  # a message, from the time since boot [ms]


class Manager:
    """We manage ourselves: everybody asks us."""

    device_id = 1  # among the gimbals of the manager; 0: the device is a component of its own
    is_manager = True  # commands point, too
    numbers = ASKED_OF_MANAGERS  # ids of the messages with set-points
    failures = 0

    def __init__(self, arbiter: ControlArbiter, clock: Clock) -> None:
        self._arbiter = arbiter
        self._clock = clock

    def streams(self, flags: Callable[[], int]) -> dict[int, tuple[Make, float]]:
        """Return the status."""

        def status(boot: int) -> Any:
            control = self._arbiter.control
            return manager_status(boot, self.device_id, flags(), control.primary, control.secondary)

        return {MANAGER_STATUS: (status, REPORTING)}

    def made(self, axis: Callable[[], Axis]) -> dict[int, Make]:
        """Return the information."""
        return {MANAGER_INFORMATION: lambda boot: manager_information(boot, self.device_id, axis())}

    def on_setpoint(self, aim: Aim | None, received: Received) -> None:
        """Take a set-point of anybody who may order something."""
        if aim is not None and received.may_order:
            self._arbiter.stream(aim, received.packet.sender, self._clock.now())


class Managed:
    """An autopilot manages us: it alone asks, all the time."""

    device_id = 0
    numbers = ASKED_OF_DEVICES
    is_manager = False

    def __init__(self, arbiter: ControlArbiter, clock: Clock, system_id: Callable[[], int]) -> None:
        self._arbiter = arbiter
        self._clock = clock
        self._system_id = system_id
        self._manager_at = -math.inf  # when the manager was heard [s]

    @property
    def failures(self) -> int:
        """Tell whether a manager is heard."""
        return NO_MANAGER if self._clock.now() - self._manager_at > ALONE else 0

    def streams(self, flags: Callable[[], int]) -> dict[int, tuple[Make, float]]:
        """Return nothing more."""
        return {}

    def made(self, axis: Callable[[], Axis]) -> dict[int, Make]:
        """Return nothing more."""
        return {}

    def on_setpoint(self, aim: Aim | None, received: Received) -> None:
        """Take a set-point of the autopilot; the one that it begins with, also after a silence, is no order."""
        who = received.packet.sender
        if received.role != "autopilot" or who != (self._system_id(), AUTOPILOT) or not received.may_order:
            return
        now = self._clock.now()
        if aim is not None and self.failures:
            self._arbiter.meet(aim, who)
        self._manager_at = now
        if aim is not None:
            self._arbiter.stream(aim, who, now, RATE_TIMEOUT_S)


Role = Manager | Managed
