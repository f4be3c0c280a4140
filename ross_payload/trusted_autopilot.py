"""Whose word about the vehicle counts."""

from __future__ import annotations

from typing import Protocol

from ross_protocols.mavlink.codec import Packet
from ross_protocols.mavlink.vehicle import AUTOPILOT


class ReceivedPacket(Protocol):
    """A packet and the role of the link that it came from."""

    @property
    def role(self) -> str:
        """``autopilot`` or ``ground``."""

    @property
    def packet(self) -> Packet:
        """What was said, and by whom."""


class TrustedAutopilot:
    """Component 1 of one system, on links of role ``autopilot``.

    Parameters
    ----------
    system_id
        Of the vehicle; 0: that of the first autopilot that is heard.
    """

    def __init__(self, system_id: int = 0) -> None:
        self.system_id = system_id

    def sent(self, received: ReceivedPacket) -> bool:
        """Tell whether it sent what a link has received."""
        packet = received.packet
        if received.role != "autopilot" or packet.component_id != AUTOPILOT:
            return False
        self.system_id = self.system_id or packet.system_id
        return packet.system_id == self.system_id
