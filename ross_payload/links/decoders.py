"""What arrives at a port, decoded: on a listening port each peer has a decoder of its own.

So the noise of one peer never stands between the bytes of another, and peers that were admitted go first: strangers get
what is left of a bounded number of looks, and what they say beyond it is thrown away.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterator

from ross_payload.links.ports import MOST, PEERS, LinkPort, Listener, Peer
from ross_protocols.codec import Decoder, Packet

SILENCE = 0.2  # [s] after which the rest of a frame is not waited for any longer
LOOKS = 200  # at what may be a frame, in one call: a flood cannot hold up who polls
STRANGERS = 16  # peers not admitted whose unfinished frames are kept
STRANGER_LOOKS = 3  # at what one stranger says in one call: all that may wait at a TCP port get theirs

Arrival = tuple[Packet, Peer]


class Ear:
    """One peer's decoder, and when it was heard."""

    def __init__(self, now: float) -> None:
        self.decoder = Decoder()
        self._heard = now  # [s]

    def feed(self, data: bytes, looks: int, now: float) -> list[Packet]:
        """Parse what has arrived; after a silence also what stands behind the beginning of a frame that never ended."""
        if data:
            self._heard = now
        if data or self.decoder.behind:
            return self.decoder.feed(data, looks)
        if self.decoder.waiting and now - self._heard > SILENCE:
            return self.decoder.settle()
        return []


class SinglePeer:
    """The decoder of a port with one far end."""

    def __init__(self, port: LinkPort, now: float) -> None:
        self._port = port
        self._ear = Ear(now)
        self.received_bytes = 0

    @property
    def decoders(self) -> list[Decoder]:
        """The only decoder."""
        return [self._ear.decoder]

    def read(self, now: float) -> Iterator[Arrival]:
        """Give what has arrived; while the decoder is behind, the system keeps the rest."""
        data = b"" if self._ear.decoder.behind else b"".join(self._port.receive())
        self.received_bytes += len(data)
        for packet in self._ear.feed(data, LOOKS, now):
            yield packet, None

    def admit(self, peer: Peer, now: float) -> None:
        """Answer the far end: nobody else hears us."""


class ManyPeers:
    """The decoders of a listening port."""

    def __init__(self, port: Listener) -> None:
        self._port = port
        self._admitted: OrderedDict[Peer, Ear] = OrderedDict()  # the latest believed is last
        self._strangers: OrderedDict[Peer, Ear] = OrderedDict()  # the latest heard is last
        self._gone = Decoder()  # keeps the counts of those that were forgotten
        self.received_bytes = 0

    @property
    def decoders(self) -> list[Decoder]:
        """All decoders, for their counts."""
        return [self._gone, *(ear.decoder for ears in (self._admitted, self._strangers) for ear in ears.values())]

    def read(self, now: float) -> Iterator[Arrival]:
        """Give what has arrived from admitted peers, then from strangers."""
        busy = [(peer, ear) for peer, ear in self._admitted.items() if ear.decoder.behind]
        for peer, ear in busy:
            for packet in ear.feed(b"", LOOKS // len(busy), now):
                yield packet, peer
        coming = self._port.receive_from(now, [peer for peer, ear in busy if ear.decoder.behind])
        self.received_bytes += sum(len(data) for _, data in coming)
        for peer, ear, data, looks in self._known(coming):
            for packet in ear.feed(data, looks, now):
                yield packet, peer
        yield from self._strange([arrival for arrival in coming if arrival[0] not in self._admitted], now)

    def _known(self, coming: list[tuple[Peer, bytes]]) -> list[tuple[Peer, Ear, bytes, int]]:
        """Collect what admitted peers have said, and how many looks each is worth; the silent ones may settle."""
        said: dict[Peer, bytearray] = {}
        for peer, data in coming:
            if peer in self._admitted and len(collected := said.setdefault(peer, bytearray())) < MOST:
                collected += data
        looks = LOOKS // max(len(said), 1)
        ears = [(peer, ear) for peer, ear in self._admitted.items() if peer in said or ear.decoder.waiting]
        return [(peer, ear, bytes(said.get(peer, b"")), looks) for peer, ear in ears if not ear.decoder.behind]

    def admit(self, peer: Peer, now: float) -> None:
        """Answer a peer whose frame was believed; the one unheard for longest makes room."""
        self._port.admit(peer)
        ear = self._admitted.pop(peer, None) or self._strangers.pop(peer, None) or Ear(now)
        self._admitted[peer] = ear
        if len(self._admitted) > PEERS:
            self._forget(self._admitted.popitem(last=False)[1])

    def _strange(self, coming: list[tuple[Peer, bytes]], now: float) -> Iterator[Arrival]:
        spent = 0
        for peer, data in coming:
            if spent >= LOOKS:
                return
            ear = self._admitted.get(peer) or self._stranger(peer, now)  # it may just have been admitted
            before = ear.decoder.bad + ear.decoder.unknown
            packets = ear.feed(data, STRANGER_LOOKS, now)
            spent += len(packets) + ear.decoder.bad + ear.decoder.unknown - before
            for packet in packets:
                yield packet, peer
            if ear.decoder.behind and self._strangers.get(peer) is ear:  # not admitted: the rest is not looked at
                self._forget(self._strangers.pop(peer))

    def _stranger(self, peer: Peer, now: float) -> Ear:
        ear = self._strangers.pop(peer, None) or Ear(now)
        self._strangers[peer] = ear
        if len(self._strangers) > STRANGERS:
            self._forget(self._strangers.popitem(last=False)[1])
        return ear

    def _behind(self, peer: Peer) -> bool:
        return peer in self._admitted and self._admitted[peer].decoder.behind

    def _forget(self, ear: Ear) -> None:
        self._gone.bad += ear.decoder.bad
        self._gone.unknown += ear.decoder.unknown
