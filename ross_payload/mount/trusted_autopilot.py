"""Whose word about the vehicle counts."""

from __future__ import annotations

from ross_payload.mavlink import Received
from ross_protocols.mavlink.vehicle import AUTOPILOT


class TrustedAutopilot:
    """Component 1 of one system, on links of role ``autopilot``.

    Parameters
    ----------
    system_id
        Of the vehicle; 0: that of the first autopilot that is heard.
    """

    def __init__(self, system_id: int = 0) -> None:
        self.system_id = system_id

    def sent(self, received: Received) -> bool:
        """Tell whether it sent what a link has received."""
        packet = received.packet
        if received.role != "autopilot" or packet.component_id != AUTOPILOT:
            return False
        self.system_id = self.system_id or packet.system_id
        return packet.system_id == self.system_id
