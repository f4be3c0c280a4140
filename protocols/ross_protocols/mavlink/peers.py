"""Who was heard on a link."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable

from ross_protocols.mavlink.codec import Packet
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.gimbal_messages import COMPONENTS as GIMBALS

MOST = 64  # that are remembered: random ids cannot fill the memory
PRESENT = 10.0  # [s] since somebody was heard


def is_routed(senders: Iterable[ComponentId]) -> bool:
    """Tell whether one of several senders on a link must be passing on what the others say.

    A router passes on only what is meant for the far side: a gap in the sequence numbers is then no proof of a loss. A
    component and the gimbals of its system may be one program.

    >>> is_routed([(1, 191), (1, 154)]), is_routed([(1, 191), (1, 1)]), is_routed([(1, 191), (2, 154)])
    (False, True, True)
    """
    senders = set(senders)
    systems = {system for system, _ in senders}
    return len(systems) > 1 or sum(component not in GIMBALS for _, component in senders) > 1


class Peers:
    """The latest senders of a link, and how many of their frames are missing."""

    def __init__(self) -> None:
        self._latest: OrderedDict[ComponentId, tuple[int, float]] = OrderedDict()  # sequence, time; the latest is last
        self._missing = 0
        self._routed = False

    @property
    def lost(self) -> int | None:
        """Frames that were lost; None: some are missing, and a router may have kept them to itself."""
        return None if self._routed and self._missing else self._missing

    def meet(self, packet: Packet, now: float) -> None:
        """Note a packet; a jump ahead of less than half a round of sequence numbers is a loss, one back is not."""
        sender = packet.sender
        before = self._latest.pop(sender, None)
        sequence = packet.sequence
        if before is not None:
            ahead = (packet.sequence - before[0]) % 256
            self._missing += ahead - 1 if 0 < ahead < 128 else 0
            sequence = packet.sequence if ahead < 128 else before[0]
        elif len(self._latest) >= MOST:
            self._latest.popitem(last=False)
        self._latest[sender] = sequence, now
        if before is None:
            self._routed = self._routed or is_routed(self._latest)

    def knows(self, system_id: int, component_id: int) -> bool:
        """Tell whether a component was heard here; component 0 is any of its system."""
        if component_id:
            return ComponentId(system_id, component_id) in self._latest
        return any(system == system_id for system, _ in self._latest)

    def present(self, now: float) -> tuple[ComponentId, ...]:
        """Return who was heard lately, in ascending order."""
        return tuple(sorted(sender for sender, (_, time) in self._latest.items() if now - time <= PRESENT))
