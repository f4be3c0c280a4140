"""The two modes: we manage ourselves, or an autopilot manages us."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Protocol

from ross_payload.gimbal.rules import Rules
from ross_payload.interfaces import Clock
from ross_payload.links import Heard
from ross_protocols.dialect import common
from ross_protocols.gimbal import MANAGER_INFORMATION, MANAGER_STATUS, NO_MANAGER, Address
from ross_protocols.own_gimbal import Aim, Axis, manager_information, manager_status
from ross_protocols.vehicle import AUTOPILOT

REPORTING = 0.2  # [s] between two statuses of the manager
ALONE = 1.0  # [s] without a set-point, after which a device has no manager
PATIENCE = 0.5  # [s] that a rate of the manager counts: it sends 50 in a second
ASKED_OF_MANAGERS: tuple[int, ...] = (
    common.MAVLINK_MSG_ID_GIMBAL_MANAGER_SET_ATTITUDE,
    common.MAVLINK_MSG_ID_GIMBAL_MANAGER_SET_PITCHYAW,
)
ASKED_OF_DEVICES: tuple[int, ...] = (common.MAVLINK_MSG_ID_GIMBAL_DEVICE_SET_ATTITUDE,)

Make = Callable[[int], Any]  # a message, from the time since boot [ms]


class Role(Protocol):
    """What the modes do differently."""

    device_id: int  # among the gimbals of the manager; 0: the device is a component of its own
    numbers: tuple[int, ...]  # ids of the messages with set-points
    rules: Rules | None  # that commands change

    @property
    def failures(self) -> int:
        """Return flags."""

    def streams(self, flags: Callable[[], int]) -> dict[int, tuple[Make, float]]:
        """Return what is said regularly beside what every device says; ``flags`` are those of the device."""

    def made(self, axis: Callable[[], Axis]) -> dict[int, Make]:
        """Return what there is on request beside what every device has."""

    def asked(self, aim: Aim | None, heard: Heard) -> None:
        """Take a set-point that is for us."""


class Manager:
    """We manage ourselves: everybody asks us."""

    device_id = 1
    numbers = ASKED_OF_MANAGERS
    failures = 0

    def __init__(self, rules: Rules, clock: Clock) -> None:
        self.rules: Rules | None = rules
        self._rules = rules
        self._clock = clock

    def streams(self, flags: Callable[[], int]) -> dict[int, tuple[Make, float]]:
        """Return the status."""

        def status(boot: int) -> Any:
            control = self._rules.control
            return manager_status(boot, self.device_id, flags(), control.primary, control.secondary)

        return {MANAGER_STATUS: (status, REPORTING)}

    def made(self, axis: Callable[[], Axis]) -> dict[int, Make]:
        """Return the information."""
        return {MANAGER_INFORMATION: lambda boot: manager_information(boot, self.device_id, axis())}

    def asked(self, aim: Aim | None, heard: Heard) -> None:
        """Take a set-point of anybody who may order something."""
        if aim is not None and heard.may_order:
            self._rules.stream(aim, sender(heard), self._clock.now())


class Managed:
    """An autopilot manages us: it alone asks, all the time."""

    device_id = 0
    numbers = ASKED_OF_DEVICES
    rules: Rules | None = None

    def __init__(self, rules: Rules, clock: Clock, system_id: Callable[[], int]) -> None:
        self._rules = rules
        self._clock = clock
        self._system_id = system_id
        self._heard = -math.inf  # when the manager was heard [s]

    @property
    def failures(self) -> int:
        """Tell whether a manager is heard."""
        return NO_MANAGER if self._clock.now() - self._heard > ALONE else 0

    def streams(self, flags: Callable[[], int]) -> dict[int, tuple[Make, float]]:
        """Return nothing more."""
        return {}

    def made(self, axis: Callable[[], Axis]) -> dict[int, Make]:
        """Return nothing more."""
        return {}

    def asked(self, aim: Aim | None, heard: Heard) -> None:
        """Take a set-point of the autopilot; the one that it begins with, also after a silence, is no order."""
        who = sender(heard)
        if heard.role != "autopilot" or who != (self._system_id(), AUTOPILOT) or not heard.may_order:
            return
        now = self._clock.now()
        if aim is not None and self.failures:
            self._rules.meet(aim, who)
        self._heard = now
        if aim is not None:
            self._rules.stream(aim, who, now, PATIENCE)


def sender(heard: Heard) -> Address:
    """Return who has said something."""
    return heard.packet.system_id, heard.packet.component_id
