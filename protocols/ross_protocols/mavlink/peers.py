"""Who was heard on a way: a link, or one peer of it."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable
from dataclasses import dataclass

from ross_protocols.mavlink.codec import Packet
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.gimbal_messages import COMPONENTS as GIMBALS

MOST = 64  # that are remembered: random ids cannot fill the memory
PRESENT = 10.0  # [s] since somebody was heard
REMEMBERED = 2**64 - 1  # bits: so many numbers back it is known which frames have come


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


@dataclass(slots=True)
class SequenceNumbers:
    """The latest sequence number of a sender, and which of those just before it have come.

    >>> numbers = SequenceNumbers(254)
    >>> [numbers.note(number) for number in (1, 0, 0, 2, 255, 253)]  # 255 and 0 are missing, 0 and 255 are late
    [2, -1, 0, 0, -1, 0]
    """

    latest: int
    _came: int = -1  # bit i: i before the latest; those before the first are not missed

    def ahead(self, number: int) -> int:
        """Return how far a number is ahead of the latest, 0 to 255; a late one is far ahead."""
        return (number - self.latest) % 256

    def note(self, number: int) -> int:
        """Return how many more frames are missing than before one with this number; -1: it was one of these."""
        ahead = self.ahead(number)
        if 0 < ahead < 128:
            self.latest, self._came = number, (self._came << ahead | 1) & REMEMBERED
            return ahead - 1
        bit = 1 << (-ahead % 256)
        late = bit & REMEMBERED & ~self._came
        self._came |= late
        return -1 if late else 0


class Peers:
    """The latest senders on a way, and how many of their frames are missing."""

    def __init__(self) -> None:
        self._latest: OrderedDict[ComponentId, tuple[SequenceNumbers, float]] = OrderedDict()  # and time; latest last
        self._missing = 0
        self._routed = False

    @property
    def lost(self) -> int | None:
        """Frames that were lost; None: some are missing, and a router may have kept them to itself."""
        return None if self._routed and self._missing else self._missing

    def meet(self, packet: Packet, now: float) -> None:
        """Note a packet; a jump ahead of less than half a round of sequence numbers is a loss, until they come late."""
        sender = packet.sender
        before = self._latest.pop(sender, None)
        if before is None and len(self._latest) >= MOST:
            self._latest.popitem(last=False)
        numbers = SequenceNumbers(packet.sequence) if before is None else before[0]
        self._missing += numbers.note(packet.sequence)
        self._latest[sender] = numbers, now
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
