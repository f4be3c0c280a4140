"""DroneCAN: the services that every node should have: who it is, and its restart."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import ClassVar, Self

from ross_protocols.dronecan.messages import DroneCanError, NodeStatus

MOST_NAME = 80  # of a node [bytes]
MAGIC = 0xACCE551B1E  # whoever sends this means a restart


class _EmptyRequest:
    """A question without a payload."""

    __slots__ = ()

    def pack(self) -> bytes:
        """Write the payload."""
        return b""

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload."""
        return cls()


@dataclass(frozen=True, slots=True)
class NodeInfoRequest(_EmptyRequest):
    """uavcan.protocol.GetNodeInfo, the question."""

    NUMBER, SEED = 1, 0xD9A7


@dataclass(frozen=True, slots=True)
class NodeInfo:
    """uavcan.protocol.GetNodeInfo, the answer."""

    NUMBER, SEED = 1, 0xD9A7
    _FIXED: ClassVar[struct.Struct] = struct.Struct("<7sBBBIQBB16sB")

    status: NodeStatus
    name: str  # at most 80 bytes
    unique_id: bytes  # 16 bytes
    software: tuple[int, int] = (0, 0)  # major, minor
    hardware: tuple[int, int] = (0, 0)
    commit: int | None = None  # of the software: the first 32 bits of its hash

    def pack(self) -> bytes:
        """Write the payload; a name that is too long is cut."""
        flags, commit = (0, 0) if self.commit is None else (1, self.commit)
        fixed = self._FIXED.pack(
            self.status.pack(), *self.software, flags, commit, 0, *self.hardware, self.unique_id, 0
        )
        return fixed + self.name.encode()[:MOST_NAME]

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload; a certificate of authenticity is passed over."""
        values = cls._FIXED.unpack_from(payload)
        status, major, minor, flags, commit, _, hard, soft, unique, certificate = values
        name = payload[cls._FIXED.size + certificate :]
        return cls(
            status=NodeStatus.unpack(status),
            name=name.decode(errors="replace"),
            unique_id=unique,
            software=(major, minor),
            hardware=(hard, soft),
            commit=commit if flags & 1 else None,
        )


@dataclass(frozen=True, slots=True)
class RestartRequest:
    """uavcan.protocol.RestartNode, the question.

    >>> RestartRequest().pack().hex()
    '1e1b55ceac'
    """

    NUMBER, SEED = 5, 0x1F7F

    magic: int = MAGIC

    def pack(self) -> bytes:
        """Write the payload."""
        return self.magic.to_bytes(5, "little")

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload."""
        if len(payload) != 5:
            raise DroneCanError(f"a restart request of {len(payload)} bytes")
        return cls(int.from_bytes(payload, "little"))


@dataclass(frozen=True, slots=True)
class RestartResponse:
    """uavcan.protocol.RestartNode, the answer."""

    NUMBER, SEED = 5, 0x1F7F

    ok: bool

    def pack(self) -> bytes:
        """Write the payload."""
        return bytes([self.ok << 7])

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload."""
        (bits,) = struct.unpack("<B", payload)
        return cls(bool(bits >> 7))


@dataclass(frozen=True, slots=True)
class TransportStatsRequest(_EmptyRequest):
    """uavcan.protocol.GetTransportStats, the question."""

    NUMBER, SEED = 4, 0x4D73


@dataclass(frozen=True, slots=True)
class TransportStats:
    """uavcan.protocol.GetTransportStats, the answer, of a node with one interface.

    >>> TransportStats(1, 2, 3, 4, 5).pack().hex()
    '010000000000020000000000030000000000040000000000050000000000000000000000'
    """

    NUMBER, SEED = 4, 0x4D73

    sent: int = 0  # transfers
    received: int = 0
    broken: int = 0  # transfers that came damaged or in part
    frames_sent: int = 0
    frames_received: int = 0
    failures: int = 0  # of the bus

    def pack(self) -> bytes:
        """Write the payload."""
        counts = self.sent, self.received, self.broken, self.frames_sent, self.frames_received, self.failures
        return b"".join(count.to_bytes(6, "little") for count in counts)

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload; interfaces beyond the first are passed over."""
        if len(payload) < 36:
            raise DroneCanError(f"statistics of {len(payload)} bytes")
        return cls(*(int.from_bytes(payload[begin : begin + 6], "little") for begin in range(0, 36, 6)))
