"""One link of a ground station: its port, a decoder and an encoder per peer, and what went through."""

from __future__ import annotations

import asyncio
import errno
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import reduce
from typing import Any

from ross_payload.errors import ConfigError, LinkError
from ross_payload.ground.errors import GroundError
from ross_payload.ground.links.meter import Meter, Reading
from ross_payload.transport.link_url import parse
from ross_payload.transport.open_port import OpenPort, Server, open_port
from ross_payload.transport.ports import MAX_READ_BYTES, Peer, PortOptions
from ross_payload.transport.tcp import TcpServer
from ross_payload.transport.udp import UdpPeer, UdpServer
from ross_protocols.mavlink.codec import Decoder, Encoder, Packet
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.peers import Peers
from ross_protocols.mavlink.signing import Guardian, is_signed

HERE = "here"  # the peer of a port that has only one
MAX_PEERS = 128  # of one link: strangers cannot fill the memory
PRESENT_S = 10.0  # [s] for which a peer that has sent good frames keeps its place
SETTLE_AFTER_S = 0.2  # [s] after which the rest of a frame is not waited for any longer
MAX_CANDIDATES = 200  # at what may be a frame, in one go: a flood lets others have their turn
MAX_LATE_BYTES = 65536  # bytes of one peer that may wait for such a turn
OPTIONS = PortOptions(
    first_pause_s=0.2,
    longest_pause_s=0.8,
    connect_timeout_s=2.0,
    vanished_after_s=3.0,
    max_clients=MAX_PEERS,
    first_come=True,
)  # what is there again is heard within 3 s: the second try of the system to connect is in its 2 s
_Totals = dict[str, int | None]


@dataclass(frozen=True, slots=True)
class LinkState:
    """How a link is, and what went through it since the station began."""

    url: str
    up: bool  # connected, as far as one can know
    error: str  # the latest failure, in words
    frames: int
    bytes: int
    lost: int | None  # frames, by the senders' counts; None: behind a router nobody can tell
    bad: int  # what began like a frame and had a wrong checksum
    skipped: int  # bytes that belong to no frame
    refused: int  # frames whose signature is missing, wrong or old
    signed: int  # frames with a signature, believed or not
    strangers: int  # pieces of data from peers beyond `MAX_PEERS`
    peers: int  # addresses or connections
    senders: tuple[ComponentId, ...]  # heard lately
    last: float | None  # when the last good frame came [s]
    frames_s: float  # over the last seconds [1/s]
    bytes_s: float
    loss: float | None  # share of frames lost over the last seconds, 0 to 1; None: as for ``lost``


@dataclass(slots=True)
class _PeerState:
    """What is remembered of one peer."""

    encoder: Encoder
    received: float  # when anything came [s]
    good: float = -1e9  # when a good frame came [s]
    decoder: Decoder = field(default_factory=Decoder)
    senders: Peers = field(default_factory=Peers)
    late: bytes = b""  # waits until what came before is decoded


class GroundLink:
    """Receives and sends on one URL; ``on_packet`` gets every packet that may be believed, with its peer and time.

    Raises
    ------
    GroundError
        When the URL is none.
    """

    def __init__(
        self,
        number: int,
        url: str,
        *,
        me: ComponentId,
        now: Callable[[], float],
        on_packet: Callable[[int, Peer, Packet, float], None],
        guardian: Guardian | None,
    ) -> None:
        try:
            parse(url)
        except ConfigError as error:
            raise GroundError(str(error)) from error
        self.url = url
        self._number = number
        self._port: OpenPort | None = None
        self._descriptor = -1  # that tells the event loop when to read
        self._me = me
        self._now = now
        self._on_packet = on_packet
        self._guardian = guardian
        self._peers: dict[Peer, _PeerState] = {}
        self._counts = dict.fromkeys(("frames", "bytes", "refused", "signed", "strangers"), 0)
        self._past: _Totals = dict.fromkeys(("lost", "bad", "skipped"), 0)  # of peers that are gone
        self._last: float | None = None
        self._meter = Meter(self._reading(now()))

    async def open(self) -> None:
        """Open the port, or begin to try.

        Raises
        ------
        GroundError
            When this computer refuses, in one line.
        """
        try:
            port = await asyncio.to_thread(open_port, self.url, time.monotonic, patient=True, options=OPTIONS)
        except (ConfigError, LinkError) as error:
            raise GroundError(f"{error}{_remedy(error)}") from error
        if isinstance(port, UdpServer):
            port.require_admission()  # we choose whom to answer
        self._port, self._descriptor = port, port.fileno()
        asyncio.get_running_loop().add_reader(self._descriptor, self._receive)
        self._receive()

    async def close(self) -> None:
        """Close the port."""
        port, self._port = self._port, None
        if port is not None:
            asyncio.get_running_loop().remove_reader(self._descriptor)
            port.close()

    def host_of(self, peer: Peer) -> str:
        """Return the network address of a peer; empty: it has none, as on a serial line."""
        return "" if self._port is None else self._port.host_of(peer)

    def knows(self, peer: Peer) -> bool:
        """Tell whether a peer can be sent to."""
        return peer in self._peers

    def send(self, message: Any, peers: Iterable[Peer] | None = None) -> None:
        """Send one of pymavlink's messages to some peers, or to all."""
        for peer in tuple(self._peers if peers is None else peers):
            stamp = 0 if self._guardian is None else self._guardian.time.stamp(self._now())
            if self._port is not None and peer in self._peers and stamp is not None:
                frame = self._peers[peer].encoder.encode(message, stamp)
                if isinstance(self._port, Server):
                    self._port.send_to(frame, peer)
                else:
                    self._port.send(frame)

    def tick(self, now: float) -> None:
        """See to the connection, take what stands behind a frame that never ended, and read the meter."""
        self._receive()
        for peer, state in tuple(self._peers.items()):
            if state.decoder.waiting and not state.decoder.behind and now - state.received > SETTLE_AFTER_S:
                asyncio.get_running_loop().call_soon(self._settle, peer, state, now)
        self._meter.note(self._reading(now))

    def state(self, now: float) -> LinkState:
        """Return how the link is."""
        reading = self._reading(now)
        up, trouble = _health(self._port)
        frames_s, bytes_s = self._meter.rates(reading)
        senders = {ComponentId(*sender) for state in self._peers.values() for sender in state.senders.present(now)}
        return LinkState(
            url=self.url, up=up, error=trouble, peers=len(self._peers), senders=tuple(sorted(senders)),
            last=self._last, frames_s=frames_s, bytes_s=bytes_s, loss=self._meter.loss(reading),
            **self._counts, **self._totals(),
        )  # fmt: skip

    # ------------------------------------------------------------------------------------------ inside

    def _receive(self) -> None:
        """Take what has arrived, and note who can be sent to."""
        port, now = self._port, self._now()
        if port is None:
            return
        if isinstance(port, UdpServer):
            for peer, data in port.receive_from(now, (), MAX_READ_BYTES):
                self._arrived(peer, data, now)
            return
        if isinstance(port, TcpServer):
            arrivals, present = port.receive_from(now, ()), port.clients
        else:
            arrivals = [(HERE, data) for data in port.receive()]
            present = (HERE,) if port.counts.up else ()
        for peer in self._peers.keys() - set(present):
            self._forget(peer)
        for peer in present:
            self._state_of(peer, now)
        for peer, data in arrivals:
            self._arrived(peer, data, now)

    def _arrived(self, peer: Peer, data: bytes, now: float) -> None:
        state = self._state_of(peer, now)
        if state is None:
            self._counts["strangers"] += 1
            return
        state.received = now
        self._counts["bytes"] += len(data)
        if state.decoder.behind:
            state.late = (state.late + data)[:MAX_LATE_BYTES]
        else:
            self._decode(peer, state, data, now)

    def _forget(self, peer: Peer) -> None:
        self._past = _added(self._past, _totals(self._peers.pop(peer)))

    def _state_of(self, peer: Peer, now: float) -> _PeerState | None:
        """Return what is remembered of a peer; None: it is a stranger, and there is no room."""
        if peer not in self._peers:
            if len(self._peers) >= MAX_PEERS and not self._made_room(now):
                return None
            key = None if self._guardian is None else self._guardian.key
            self._peers[peer] = _PeerState(Encoder(*self._me, key, self._number % 256), now)
        return self._peers[peer]

    def _made_room(self, now: float) -> bool:
        """Forget the peer whose last good frame is oldest, unless all are present."""
        peer, state = min(self._peers.items(), key=lambda item: (item[1].good, item[1].received))
        if now - state.good < PRESENT_S:
            return False
        self._forget(peer)
        return True

    def _decode(self, peer: Peer, state: _PeerState, data: bytes, now: float) -> None:
        self._judge(peer, state, state.decoder.feed(data, MAX_CANDIDATES), now)
        if state.decoder.behind:
            asyncio.get_running_loop().call_soon(self._go_on, peer, state)

    def _go_on(self, peer: Peer, state: _PeerState) -> None:
        data, state.late = state.late, b""
        self._decode(peer, state, data, self._now())

    def _settle(self, peer: Peer, state: _PeerState, now: float) -> None:
        self._judge(peer, state, state.decoder.settle(), now)

    def _judge(self, peer: Peer, state: _PeerState, packets: Iterable[Packet], now: float) -> None:
        for packet in packets:
            self._counts["signed"] += is_signed(packet.frame)
            if self._guardian is not None and not self._guardian.believes(packet, now):
                self._counts["refused"] += 1
                continue
            self._counts["frames"] += 1
            self._last = state.good = now
            state.senders.meet(packet, now)
            self._on_packet(self._number, peer, packet, now)

    def _totals(self) -> dict[str, Any]:
        return reduce(_added, map(_totals, self._peers.values()), self._past)

    def _reading(self, now: float) -> Reading:
        return Reading(now, self._counts["frames"], self._counts["bytes"], self._totals()["lost"])


def _health(port: OpenPort | None) -> tuple[bool, str]:
    """Return whether a port is connected, as far as one can know, and what is wrong with it, in words."""
    if port is None:
        return False, ""
    counts = port.counts
    return counts.up and not (isinstance(port, UdpPeer) and counts.trouble), counts.trouble


def _totals(state: _PeerState) -> _Totals:
    return {"lost": state.senders.lost, "bad": state.decoder.bad, "skipped": state.decoder.skipped}


def _added(one: _Totals, other: _Totals) -> _Totals:
    """Add counts of the same names; what is unknown of one is unknown of both."""
    pairs = ((name, count, other[name]) for name, count in one.items())
    return {name: None if count is None or more is None else count + more for name, count, more in pairs}


def _remedy(error: Exception) -> str:
    if isinstance(error.__cause__, OSError) and error.__cause__.errno == errno.EADDRINUSE:
        return "; another program listens there (see ss -lnp): end it, or choose another port"
    return ""
