"""Whom the driver of a MAVLink gimbal talks to: a manager that it is a client of, or a device that it manages.

Both remember what they have heard and say what is due; they send nothing themselves.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from ross_payload.actuators.mavlink_gimbal.port import Arrived
from ross_protocols import gimbal
from ross_protocols.gimbal import Address, GimbalControl, GimbalTravel
from ross_protocols.vehicle import AUTOPILOT

AGAIN = 1.0  # [s] between two questions that were not answered
WANTED = 50.0  # [Hz] of attitudes
ENOUGH = 30.0  # [Hz]: what flows at this rate is not asked for again
CONTROL_HZ = 5.0  # of the manager's status
ALONE = 3.0  # [s] after which a gimbal without an autopilot has none
NO_AUTOPILOT = 8  # MAV_AUTOPILOT_INVALID
ACCEPTED, IN_PROGRESS = 0, 5  # MAV_RESULT
MISSING = {
    "client": "no heartbeat of an autopilot yet",
    "manager": "no heartbeat of a gimbal device yet",
    "discover": "no heartbeat of an autopilot or a gimbal device yet",
}
INQUIRIES = 3  # after who a gimbal behind a manager is: it need not tell
INFORMATION = "GIMBAL_DEVICE_INFORMATION"
ATTACHED = len(gimbal.COMPONENTS)  # device ids up to this one belong to the manager, above are component ids


@dataclass(slots=True)
class Asking:
    """When to ask again, and for attitudes only while too few come."""

    due: float = 0.0  # [s]
    since: float = -math.inf  # [s]
    reports: int = 0  # attitudes since then

    def is_due(self, now: float) -> bool:
        """Tell whether to ask at ``now`` [s]; the next time is a while later."""
        if now < self.due:
            return False
        self.due = now + AGAIN
        return True

    def too_few(self, now: float) -> bool:
        """Tell whether too few attitudes came since this was asked last."""
        few = self.reports < ENOUGH * (now - self.since)
        self.reports, self.since = 0, now
        return few


@dataclass(slots=True)
class Client:
    """A gimbal manager, mostly an autopilot, that points the gimbal for us while it names us in control."""

    manager: Address
    device_id: int = 0  # 0: the first that it tells of
    travel: GimbalTravel | None = None
    device: Address | None = None  # whose attitudes are the gimbal's own
    primary: Address | None = None  # whom the manager names in control
    us: Address = (0, 0)
    had_control: bool = False
    refused: bool = False  # when we asked for control
    asked: int = 0  # times, for attitudes
    inquired: int = 0  # times, who the gimbal is
    identity: str = ""  # of the gimbal, as it tells
    asking: Asking = field(default_factory=Asking)

    def heard(self, arrived: Arrived, now: float) -> None:
        """Take in what the manager says."""
        packet, self.us = arrived.packet, arrived.us
        sender, said = (packet.system_id, packet.component_id), packet.message
        if packet.name == INFORMATION and (sender == self.device or self._passed_on(sender, said)):
            self.identity = gimbal.maker(said)
        if sender != self.manager:
            return
        if packet.name == "COMMAND_ACK" and said.command == gimbal.CONFIGURE and _is_for(self.us, said):
            self.refused = said.result not in (ACCEPTED, IN_PROGRESS)
        match gimbal.read(packet.message):
            case GimbalTravel() as travel if self.device_id in (0, travel.device_id):
                if self.travel is None:
                    self.asking.due = now
                self.travel, self.device_id = travel, travel.device_id
                number = travel.device_id
                component = gimbal.COMPONENTS[number - 1] if 1 <= number <= ATTACHED else number
                self.device = self.manager[0], component
            case GimbalControl() as control if self.travel and control.device_id == self.device_id:
                self.primary = control.primary
                self.had_control = self.had_control or self.ready

    def due(self, now: float) -> list[Any]:
        """Return what to ask at ``now`` [s]: who you are, then control, then attitudes."""
        if not self.asking.is_due(now):
            return []
        if self.travel is None:
            return [gimbal.request(self.manager, gimbal.MANAGER_INFORMATION)]
        questions = []
        if not self.ready and not self.trouble():
            questions = [
                gimbal.configure(self.manager, self.device_id, gimbal.ITSELF),
                gimbal.interval(self.manager, gimbal.MANAGER_STATUS, CONTROL_HZ),
                gimbal.request(self.manager, gimbal.MANAGER_STATUS),
            ]
        if self.asking.too_few(now):
            questions += [gimbal.interval(address, gimbal.DEVICE_ATTITUDE, WANTED) for address in self._reporters()]
            self.asked += 1
        if not self.identity and self.inquired < INQUIRIES:
            questions += [gimbal.request(address, gimbal.DEVICE_INFORMATION) for address in self._reporters()]
            self.inquired += 1
        return questions

    def _passed_on(self, sender: Address, said: Any) -> bool:
        """Tell whether the manager tells of the gimbal."""
        return sender == self.manager and self.travel is not None and said.gimbal_device_id == self.device_id

    def _reporters(self) -> list[Address]:
        """Whom to ask for what the gimbal tells: the device itself, and its manager when that was not enough."""
        if self.device is None:
            return [self.manager]
        return [self.device, self.manager] if self.asked else [self.device]

    def point(self, angle: float) -> Any:
        """Return the message that points at a joint angle [rad]."""
        return gimbal.point_manager(self.manager, self.device_id, angle)

    def leave(self) -> list[Any]:
        """Return what gives control back."""
        messages = [gimbal.configure(self.manager, self.device_id, gimbal.NOBODY)] if self.ready else []
        self.claim()
        self.primary = None
        return messages

    def claim(self) -> None:
        """Ask for control at once, also when somebody else has taken it."""
        self.had_control, self.asking.due = False, 0.0

    @property
    def ready(self) -> bool:
        """Whether it points where we say."""
        return self.primary == self.us != (0, 0)

    def relays(self, device_id: int) -> bool:
        """Tell whether an attitude with this device id, sent by the manager, is the gimbal's."""
        return device_id == self.device_id

    def waits_for(self) -> str:
        """Say what is still missing."""
        if self.refused:
            return f"the gimbal manager {_name(self.manager)} refuses us control"
        missing = "information" if self.travel is None else "word that we are in control"
        return f"the gimbal manager {_name(self.manager)} gives no {missing}"

    def trouble(self) -> str:
        """Say who has taken control, if it was somebody else."""
        if not self.had_control or self.primary is None or self.primary in (self.us, (0, 0)):
            return ""
        return f"{_name(self.primary)} has taken control of the gimbal from {_name(self.us)}; home takes it back"


@dataclass(slots=True)
class Manager:
    """A gimbal device without an autopilot, which we manage."""

    device: Address
    travel: GimbalTravel | None = None
    rival: Address | None = None  # who else points a gimbal here
    identity: str = ""  # of the gimbal, as it tells
    asking: Asking = field(default_factory=Asking)

    def heard(self, arrived: Arrived, now: float) -> None:
        """Take in what the device says."""
        packet = arrived.packet
        if packet.name == "GIMBAL_DEVICE_SET_ATTITUDE":
            self.rival = packet.system_id, packet.component_id
        if (packet.system_id, packet.component_id) == self.device:
            if packet.name == INFORMATION:
                self.identity = gimbal.maker(packet.message)
            said = gimbal.read(packet.message)
            if isinstance(said, GimbalTravel):
                if self.travel is None:
                    self.asking.due = now
                self.travel = said

    def due(self, now: float) -> list[Any]:
        """Return what to ask at ``now`` [s]: who you are, then attitudes."""
        if not self.asking.is_due(now):
            return []
        if self.travel is None:
            return [gimbal.request(self.device, gimbal.DEVICE_INFORMATION)]
        few = self.asking.too_few(now)
        return [gimbal.interval(self.device, gimbal.DEVICE_ATTITUDE, WANTED)] if few else []

    def point(self, angle: float) -> Any:
        """Return the message that points at a joint angle [rad]."""
        return gimbal.point_device(self.device, angle)

    def leave(self) -> list[Any]:
        """Return nothing: a device holds its last set-point."""
        return []

    def claim(self) -> None:
        """Forget who else has pointed the gimbal; if it goes on, it is heard again."""
        self.rival = None

    @property
    def ready(self) -> bool:
        """Whether it has told what it is."""
        return self.travel is not None

    def relays(self, device_id: int) -> bool:
        """Tell whether an attitude that the device does not send itself is the gimbal's: none is."""
        return False

    def waits_for(self) -> str:
        """Say what is still missing."""
        return f"the gimbal device {_name(self.device)} gives no information"

    def trouble(self) -> str:
        """Say who else manages a gimbal here: two would fight."""
        return "" if self.rival is None else f'{_name(self.rival)} manages the gimbal too: wanted role = "client"'


@dataclass(slots=True)
class Search:
    """Finds by heartbeats whom to talk to: an autopilot if there is one, a gimbal device that stays alone if not."""

    role: str  # client, manager or discover
    device_id: int
    found: Client | Manager | None = None
    device: Address | None = None  # the first one heard
    since: float = 0.0  # when [s]

    def met(self, heartbeat: Any, sender: Address, now: float) -> Client | Manager | None:
        """Return whom to talk to after one more heartbeat; an autopilot that comes late takes over."""
        if heartbeat.type == gimbal.TYPE_GIMBAL and sender[1] in gimbal.COMPONENTS and self.device is None:
            self.device, self.since = sender, now
        is_autopilot = sender[1] == AUTOPILOT and heartbeat.autopilot != NO_AUTOPILOT
        if is_autopilot and self.role != "manager" and not isinstance(self.found, Client):
            self.found = Client(sender, self.device_id)
        alone = self.role == "manager" or (self.role == "discover" and now - self.since >= ALONE)
        if self.found is None and self.device is not None and alone:
            self.found = Manager(self.device)
        return self.found

    def missing(self) -> str:
        """Say who has not been heard."""
        return MISSING[self.role]


def _is_for(us: Address, said: Any) -> bool:
    return (said.target_system, said.target_component) in (us, (0, 0))


def _name(address: Address) -> str:
    return f"component {address[1]} of system {address[0]}"
