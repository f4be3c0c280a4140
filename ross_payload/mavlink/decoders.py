"""What arrives at a port, decoded: on a listening port each peer has a decoder of its own.

So the noise of one peer never stands between the bytes of another, and peers that were admitted go first: strangers get
what is left of a bounded number of looks, and what they say beyond it is thrown away.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable, Iterator

from ross_payload.transport.open_port import Server
from ross_payload.transport.ports import MAX_PEERS, MAX_READ_BYTES, Peer, Transport
from ross_protocols.mavlink.codec import Decoder, Packet
from ross_protocols.mavlink.peers import Peers

SILENCE = 0.2  # [s] after which the rest of a frame is not waited for any longer
LOOKS = 200  # at what may be a frame, in one call: a flood cannot hold up who polls
STRANGERS = 16  # peers not admitted whose unfinished frames are kept
STRANGER_LOOKS = 3  # at what one stranger says in one call: all that may wait at a TCP port get theirs

Arrival = tuple[Packet, Peer]


class PeerDecoder:
    """One peer's decoder, who speaks there, and when it was heard."""

    def __init__(self, now: float) -> None:
        self.decoder = Decoder()
        self.senders = Peers()
        self._latest = now  # [s]

    def feed(self, data: bytes, looks: int, now: float) -> list[Packet]:
        """Parse what has arrived; after a silence also what stands behind the beginning of a frame that never ended."""
        if data:
            self._latest = now
        if data or self.decoder.behind:
            return self.decoder.feed(data, looks)
        if self.decoder.waiting and now - self._latest > SILENCE:
            return self.decoder.settle()
        return []


class SinglePeer:
    """The decoder of a port with one far end."""

    def __init__(self, port: Transport, now: float) -> None:
        self._port = port
        self._entry = PeerDecoder(now)
        self.received_bytes = 0

    @property
    def decoders(self) -> list[Decoder]:
        """The only decoder."""
        return [self._entry.decoder]

    @property
    def senders(self) -> list[Peers]:
        """Who speaks at the far end."""
        return [self._entry.senders]

    @property
    def lost(self) -> int | None:
        """Frames that were lost; None: nobody can tell."""
        return self._entry.senders.lost

    def meet(self, packet: Packet, peer: Peer, now: float) -> None:
        """Note who has sent a packet that is believed."""
        self._entry.senders.meet(packet, now)

    def read(self, now: float) -> Iterator[Arrival]:
        """Give what has arrived; while the decoder is behind, the system keeps the rest."""
        data = b"" if self._entry.decoder.behind else b"".join(self._port.receive())
        self.received_bytes += len(data)
        for packet in self._entry.feed(data, LOOKS, now):
            yield packet, None

    def admit(self, peer: Peer, now: float) -> None:
        """Answer the far end: nobody else hears us."""


class ManyPeers:
    """The decoders of a listening port."""

    def __init__(self, port: Server) -> None:
        self._port = port
        self._admitted: OrderedDict[Peer, PeerDecoder] = OrderedDict()  # the latest believed is last
        self._strangers: OrderedDict[Peer, PeerDecoder] = OrderedDict()  # the latest heard is last
        self._gone = Decoder()  # keeps the counts of those that were forgotten
        self._gone_lost: int | None = 0
        self.received_bytes = 0

    @property
    def decoders(self) -> list[Decoder]:
        """All decoders, for their counts."""
        return [self._gone, *(each.decoder for each in (*self._admitted.values(), *self._strangers.values()))]

    @property
    def senders(self) -> list[Peers]:
        """Who speaks at each peer."""
        return [each.senders for each in (*self._admitted.values(), *self._strangers.values())]

    @property
    def lost(self) -> int | None:
        """Frames that were lost; None: of one peer nobody can tell."""
        return total([self._gone_lost, *(each.lost for each in self.senders)])

    def meet(self, packet: Packet, peer: Peer, now: float) -> None:
        """Note who has sent a packet that is believed."""
        entry = self._admitted.get(peer) or self._strangers.get(peer)
        if entry is not None:
            entry.senders.meet(packet, now)

    def read(self, now: float) -> Iterator[Arrival]:
        """Give what has arrived from admitted peers, then from strangers."""
        busy = [(peer, entry) for peer, entry in self._admitted.items() if entry.decoder.behind]
        for peer, entry in busy:
            for packet in entry.feed(b"", LOOKS // len(busy), now):
                yield packet, peer
        coming = self._port.receive_from(now, [peer for peer, entry in busy if entry.decoder.behind])
        self.received_bytes += sum(len(data) for _, data in coming)
        for peer, entry, data, looks in self._known(coming):
            for packet in entry.feed(data, looks, now):
                yield packet, peer
        yield from self._strange([arrival for arrival in coming if arrival[0] not in self._admitted], now)

    def _known(self, coming: list[tuple[Peer, bytes]]) -> list[tuple[Peer, PeerDecoder, bytes, int]]:
        """Collect what admitted peers have sent, and how many looks each is worth; the silent ones may settle."""
        arrived: dict[Peer, bytearray] = {}
        for peer, data in coming:
            if peer in self._admitted and len(collected := arrived.setdefault(peer, bytearray())) < MAX_READ_BYTES:
                collected += data
        looks = LOOKS // max(len(arrived), 1)
        found = [each for each in self._admitted.items() if each[0] in arrived or each[1].decoder.waiting]
        return [
            (peer, entry, bytes(arrived.get(peer, b"")), looks) for peer, entry in found if not entry.decoder.behind
        ]

    def admit(self, peer: Peer, now: float) -> None:
        """Answer a peer whose frame was believed; the one unheard for longest makes room."""
        self._port.admit(peer)
        entry = self._admitted.pop(peer, None) or self._strangers.pop(peer, None) or PeerDecoder(now)
        self._admitted[peer] = entry
        if len(self._admitted) > MAX_PEERS:
            self._forget(self._admitted.popitem(last=False)[1])

    def _strange(self, coming: list[tuple[Peer, bytes]], now: float) -> Iterator[Arrival]:
        spent = 0
        for peer, data in coming:
            if spent >= LOOKS:
                return
            entry = self._admitted.get(peer) or self._stranger(peer, now)  # it may just have been admitted
            before = entry.decoder.bad + entry.decoder.unknown
            packets = entry.feed(data, STRANGER_LOOKS, now)
            spent += len(packets) + entry.decoder.bad + entry.decoder.unknown - before
            for packet in packets:
                yield packet, peer
            if entry.decoder.behind and self._strangers.get(peer) is entry:  # not admitted: the rest is not looked at
                self._forget(self._strangers.pop(peer))

    def _stranger(self, peer: Peer, now: float) -> PeerDecoder:
        entry = self._strangers.pop(peer, None) or PeerDecoder(now)
        self._strangers[peer] = entry
        if len(self._strangers) > STRANGERS:
            self._forget(self._strangers.popitem(last=False)[1])
        return entry

    def _forget(self, entry: PeerDecoder) -> None:
        self._gone.bad += entry.decoder.bad
        self._gone.unknown += entry.decoder.unknown
        self._gone_lost = total([self._gone_lost, entry.senders.lost])


def total(counts: Iterable[int | None]) -> int | None:
    """Add counts; what is unknown of one is unknown of all.

    >>> total([1, 2]), total([1, None])
    (3, None)
    """
    known = [*counts]
    return None if None in known else sum(count or 0 for count in known)
