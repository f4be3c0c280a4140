"""Whom the driver of a MAVLink gimbal talks to: a manager that it is a client of, or a device that it manages.

Both remember what they have heard and say what is due; they send nothing themselves.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from ross_payload.actuators.mavlink_gimbal.component_port import ReceivedPacket
from ross_payload.actuators.mavlink_gimbal.gimbal_manager_client import (
    ATTITUDE_RATE_HZ,
    INFORMATION,
    GimbalManagerClient,
    QueryTimer,
    component_name,
)
from ross_protocols.mavlink import gimbal_messages
from ross_protocols.mavlink.component_id import ComponentId, target_of
from ross_protocols.mavlink.gimbal_messages import GimbalTravel
from ross_protocols.mavlink.vehicle import AUTOPILOT, NO_AUTOPILOT

DISCOVERY_TIMEOUT_S = 3.0  # [s] after which a gimbal without an autopilot has none
MISSING = {
    "client": "no heartbeat received from an autopilot",
    "manager": "no heartbeat received from a gimbal device",
    "discover": "no heartbeat received from an autopilot or a gimbal device",
}


@dataclass(slots=True)
class GimbalDeviceClient:
    """A gimbal device without an autopilot, which we manage: nobody else can be in control."""

    device: ComponentId
    travel: GimbalTravel | None = None
    rival: ComponentId | None = None  # who else points it
    identity: str = ""  # of the gimbal, as it tells
    heard_at: float = -math.inf  # when somebody else than the gimbal was heard, who could speak for it: never
    queries: QueryTimer = field(default_factory=QueryTimer)

    def on_packet(self, received: ReceivedPacket, now: float) -> None:
        """Take in what the device says."""
        packet = received.packet
        points = packet.name == "GIMBAL_DEVICE_SET_ATTITUDE"
        if points and target_of(packet.message).includes(self.device):  # another gimbal here may have its own manager
            self.rival = packet.sender
        if packet.sender == self.device:
            if packet.name == INFORMATION:
                self.identity = gimbal_messages.maker(packet.message)
            message = gimbal_messages.read(packet.message)
            if isinstance(message, GimbalTravel):
                if self.travel is None:
                    self.queries.due = now
                self.travel = message

    def due(self, now: float) -> list[Any]:
        """Return what to ask at ``now`` [s]: who you are, then attitudes."""
        if not self.queries.is_due(now):
            return []
        if self.travel is None:
            return [gimbal_messages.request(self.device, gimbal_messages.DEVICE_INFORMATION)]
        few = self.queries.too_few(now)
        return [gimbal_messages.interval(self.device, gimbal_messages.DEVICE_ATTITUDE, ATTITUDE_RATE_HZ)] if few else []

    def point(self, angle: float) -> Any:
        """Return the message that points at a joint angle [rad]."""
        return gimbal_messages.point_device(self.device, angle)

    def want_control(self, now: float) -> None:
        """Do nothing: it is ours."""

    def claim_control(self, now: float) -> None:
        """Forget who else has pointed the gimbal; if it goes on, it is heard again."""
        self.rival = None

    def release_control(self) -> None:
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
        return "" if self.ready else f"the gimbal device, {component_name(self.device)}, gives no information"

    def trouble(self) -> str:
        """Say who else manages a gimbal here: two would fight."""
        if self.rival is None:
            return ""
        who = component_name(self.rival)
        return f'{who} manages the gimbal too: actuator.options.role: expected "client", got "manager"'


@dataclass(slots=True)
class PeerSearch:
    """Finds by heartbeats whom to talk to: an autopilot if there is one, a gimbal device that stays alone if not."""

    role: str  # client, manager or discover
    device_id: int
    found: GimbalManagerClient | GimbalDeviceClient | None = None
    device: ComponentId | None = None  # the first one heard
    since: float = 0.0  # when [s]

    def on_heartbeat(
        self, heartbeat: Any, sender: ComponentId, now: float
    ) -> GimbalManagerClient | GimbalDeviceClient | None:
        """Return whom to talk to after one more heartbeat; an autopilot that comes late takes over."""
        if (
            heartbeat.type == gimbal_messages.TYPE_GIMBAL
            and sender[1] in gimbal_messages.COMPONENTS
            and self.device is None
        ):
            self.device, self.since = sender, now
        is_autopilot = sender[1] == AUTOPILOT and heartbeat.autopilot != NO_AUTOPILOT
        if is_autopilot and self.role != "manager" and not isinstance(self.found, GimbalManagerClient):
            self.found = GimbalManagerClient(sender, self.device_id)
        alone = self.role == "manager" or (self.role == "discover" and now - self.since >= DISCOVERY_TIMEOUT_S)
        if self.found is None and self.device is not None and alone:
            self.found = GimbalDeviceClient(self.device)
        return self.found

    def missing(self) -> str:
        """Say who has not been heard."""
        return MISSING[self.role]
