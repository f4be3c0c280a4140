"""DroneCAN: how a node without an id gets one. It asks anonymously, in three parts of its unique id."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

from ross_protocols.can import CanFrame
from ross_protocols.dronecan import DroneCanError
from ross_protocols.dronecan_services import UNIQUE
from ross_protocols.dronecan_transfer import anonymous

MOST_ASKED = 6  # bytes of a unique id in a request
REQUEST_PERIOD = (0.6, 1.0)  # [s] between two requests, by chance
FOLLOW_UP = (0.0, 0.4)  # [s] until a follow-up, by chance
FOLLOW_UP_TIMEOUT = 0.5  # [s] after which an allocator forgets a request


@dataclass(frozen=True, slots=True)
class Allocation:
    """uavcan.protocol.dynamic_node_id.Allocation.

    >>> Allocation(125, b"abcdef", first=True).pack().hex()
    'fb616263646566'
    """

    NUMBER: ClassVar[int] = 1
    SEED: ClassVar[int] = 0xF258
    PRIORITY: ClassVar[int] = 30

    node_id: int  # wanted or given; 0: any, or not given yet
    unique_id: bytes  # as much of it as is told
    first: bool = False  # the first part

    def pack(self) -> bytes:
        """Write the payload."""
        return bytes([self.node_id << 1 | self.first]) + self.unique_id

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload."""
        if not 1 <= len(payload) <= 1 + UNIQUE:
            raise DroneCanError(f"an allocation of {len(payload)} bytes")
        return cls(payload[0] >> 1, payload[1:], bool(payload[0] & 1))

    def asked(self, discriminator: int, transfer: int) -> CanFrame:
        """Return the frame of a node without an id."""
        return anonymous(self.NUMBER, discriminator, self.pack(), transfer, self.PRIORITY)
