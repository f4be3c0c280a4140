"""Who was heard on a link."""

from __future__ import annotations

from collections import OrderedDict

from ross_protocols.codec import Packet

MOST = 64  # that are remembered: random ids cannot fill the memory
PRESENT = 10.0  # [s] since somebody was heard

Sender = tuple[int, int]  # system id, component id


class Peers:
    """The latest senders of a link, and how many of their frames are missing."""

    def __init__(self) -> None:
        self._heard: OrderedDict[Sender, tuple[int, float]] = OrderedDict()  # sequence number, time; the latest is last
        self.lost = 0

    def meet(self, packet: Packet, now: float) -> None:
        """Note a packet; a jump ahead of less than half a round of sequence numbers is a loss, one back is not."""
        sender = packet.system_id, packet.component_id
        before = self._heard.pop(sender, None)
        sequence = packet.sequence
        if before is not None:
            ahead = (packet.sequence - before[0]) % 256
            self.lost += ahead - 1 if 0 < ahead < 128 else 0
            sequence = packet.sequence if ahead < 128 else before[0]
        elif len(self._heard) >= MOST:
            self._heard.popitem(last=False)
        self._heard[sender] = sequence, now

    def knows(self, system_id: int, component_id: int) -> bool:
        """Tell whether a component was heard here; component 0 is any of its system."""
        if component_id:
            return (system_id, component_id) in self._heard
        return any(system == system_id for system, _ in self._heard)

    def present(self, now: float) -> tuple[Sender, ...]:
        """Return who was heard lately, in ascending order."""
        return tuple(sorted(sender for sender, (_, time) in self._heard.items() if now - time <= PRESENT))
