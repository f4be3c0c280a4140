"""Whom the driver of a MAVLink gimbal talks to: a manager that it is a client of, or a device that it manages.

Both remember what they have heard and say what is due; they send nothing themselves.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from ross_payload.actuators.mavlink_gimbal.gimbal_client import INFORMATION, WANTED, Asking, Client, name_of
from ross_payload.actuators.mavlink_gimbal.port import Arrived
from ross_protocols import gimbal
from ross_protocols.gimbal import Address, GimbalTravel
from ross_protocols.vehicle import AUTOPILOT

ALONE = 3.0  # [s] after which a gimbal without an autopilot has none
NO_AUTOPILOT = 8  # MAV_AUTOPILOT_INVALID
MISSING = {
    "client": "no heartbeat received from an autopilot",
    "manager": "no heartbeat received from a gimbal device",
    "discover": "no heartbeat received from an autopilot or a gimbal device",
}


@dataclass(slots=True)
class Manager:
    """A gimbal device without an autopilot, which we manage: nobody else can be in control."""

    device: Address
    travel: GimbalTravel | None = None
    rival: Address | None = None  # who else points a gimbal here
    identity: str = ""  # of the gimbal, as it tells
    heard_at: float = -math.inf  # when somebody else than the gimbal was heard, who could speak for it: never
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

    def take(self, now: float) -> None:
        """Do nothing: it is ours."""

    def claim(self, now: float) -> None:
        """Forget who else has pointed the gimbal; if it goes on, it is heard again."""
        self.rival = None

    def release(self) -> None:
        """Do nothing: a device needs a manager that speaks all the time."""

    def leave(self) -> list[Any]:
        """Return nothing: a device holds its last set-point."""
        return []

    @property
    def idle(self) -> bool:
        """Whether others may turn the gimbal: never."""
        return False

    @property
    def ready(self) -> bool:
        """Whether it has told what it is."""
        return self.travel is not None

    def relays(self, device_id: int) -> bool:
        """Tell whether an attitude that the device does not send itself is the gimbal's: none is."""
        return False

    def missing(self, now: float) -> str:
        """Say what it has not told; empty when nothing is missing."""
        return "" if self.ready else f"the gimbal device, {name_of(self.device)}, gives no information"

    def trouble(self) -> str:
        """Say who else manages a gimbal here: two would fight."""
        if self.rival is None:
            return ""
        return f'{name_of(self.rival)} manages the gimbal too: actuator.options.role: expected "client", got "manager"'


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
