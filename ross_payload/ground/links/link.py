"""One link of a ground station: its port, one ear and one voice per peer, and what went through."""

from __future__ import annotations

import asyncio
import errno
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import reduce
from typing import Any

from ross_payload.extras import install_line
from ross_payload.ground.errors import GroundError
from ross_payload.ground.links.meter import Meter, Reading
from ross_payload.ground.links.ports import Listener, Peer, Port, words
from ross_payload.ground.links.tcp import TcpCaller, TcpListener
from ross_payload.ground.links.uart import SerialPort
from ross_payload.ground.links.udp import UdpCaller, UdpListener
from ross_payload.ground.picture.known import Who
from ross_protocols.address import BadAddress, Serial, Tcp, Udp, parse
from ross_protocols.codec import Decoder, Encoder, Packet
from ross_protocols.peers import Peers, Sender
from ross_protocols.signing import Guardian, is_signed

MOST_PEERS = 128  # of one link: strangers cannot fill the memory
PRESENT = 10.0  # [s] for which a peer that has sent good frames keeps its place
SILENCE = 0.2  # [s] after which the rest of a frame is not waited for any longer
LOOKS = 200  # at what may be a frame, in one go: a flood lets others have their turn
MOST_LATE = 65536  # bytes of one peer that may wait for such a turn
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
    strangers: int  # pieces of data from peers beyond `MOST_PEERS`
    peers: int  # addresses or connections
    senders: tuple[Who, ...]  # heard lately
    last: float | None  # when the last good frame came [s]
    frames_s: float  # over the last seconds [1/s]
    bytes_s: float
    loss: float | None  # share of frames lost over the last seconds, 0 to 1; None: as for ``lost``


@dataclass(slots=True)
class _Ear:
    """What is remembered of one peer."""

    encoder: Encoder
    heard: float  # when anything came [s]
    good: float = -1e9  # when a good frame came [s]
    decoder: Decoder = field(default_factory=Decoder)
    senders: Peers = field(default_factory=Peers)
    late: bytes = b""  # waits until what came before is decoded


class Link:
    """Hears and speaks on one URL; ``hear`` takes every packet that may be believed, with its peer and time.

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
        me: Sender,
        now: Callable[[], float],
        hear: Callable[[int, Peer, Packet, float], None],
        guardian: Guardian | None,
    ) -> None:
        self.url = url
        self._number = number
        self._port = port_of(url, self)
        self._me = me
        self._now = now
        self._hear = hear
        self._guardian = guardian
        self._ears: dict[Peer, _Ear] = {}
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
            await self._port.open()
        except ModuleNotFoundError as error:
            raise GroundError(f"link '{self.url}' needs pyserial: {install_line('serial')}") from error
        except (OSError, ValueError) as error:
            raise GroundError(f"link '{self.url}' cannot be opened: {words(error)}{_remedy(error)}") from error

    async def close(self) -> None:
        """Close the port."""
        await self._port.close()

    def knows(self, peer: Peer) -> bool:
        """Tell whether a peer can be sent to."""
        return peer in self._ears

    def send(self, message: Any, peers: Iterable[Peer] | None = None) -> None:
        """Send one of pymavlink's messages to some peers, or to all."""
        for peer in tuple(self._ears if peers is None else peers):
            stamp = 0 if self._guardian is None else self._guardian.time.stamp(self._now())
            if peer in self._ears and stamp is not None:
                self._port.send(self._ears[peer].encoder.encode(message, stamp), peer)

    def tick(self, now: float) -> None:
        """Take what stands behind a frame that never ended, and read the meter."""
        for peer, ear in tuple(self._ears.items()):
            if ear.decoder.waiting and not ear.decoder.behind and now - ear.heard > SILENCE:
                asyncio.get_running_loop().call_soon(self._settle, peer, ear, now)
        self._meter.note(self._reading(now))

    def state(self, now: float) -> LinkState:
        """Return how the link is."""
        reading, health = self._reading(now), self._port.health
        frames_s, bytes_s = self._meter.rates(reading)
        senders = {Who(*sender) for ear in self._ears.values() for sender in ear.senders.present(now)}
        return LinkState(
            url=self.url, up=health.up, error=health.error, peers=len(self._ears), senders=tuple(sorted(senders)),
            last=self._last, frames_s=frames_s, bytes_s=bytes_s, loss=self._meter.loss(reading),
            **self._counts, **self._totals(),
        )  # fmt: skip

    # ------------------------------------------------------------------------------------------ what the port tells

    def met(self, peer: Peer) -> None:
        """Learn that there is somebody to send to."""
        self._ear(peer, self._now())

    def came(self, peer: Peer, data: bytes) -> None:
        """Take what came from somebody."""
        now = self._now()
        ear = self._ear(peer, now)
        if ear is None:
            self._counts["strangers"] += 1
            return
        ear.heard = now
        self._counts["bytes"] += len(data)
        if ear.decoder.behind:
            ear.late = (ear.late + data)[:MOST_LATE]
        else:
            self._decode(peer, ear, data, now)

    def gone(self, peer: Peer) -> None:
        """Forget somebody."""
        ear = self._ears.pop(peer, None)
        if ear is not None:
            self._past = _added(self._past, _totals(ear))

    # ------------------------------------------------------------------------------------------ inside

    def _ear(self, peer: Peer, now: float) -> _Ear | None:
        """Return what is remembered of a peer; None: it is a stranger, and there is no room."""
        if peer not in self._ears:
            if len(self._ears) >= MOST_PEERS and not self._made_room(now):
                return None
            key = None if self._guardian is None else self._guardian.key
            self._ears[peer] = _Ear(Encoder(*self._me, key, self._number % 256), now)
        return self._ears[peer]

    def _made_room(self, now: float) -> bool:
        """Forget the peer whose last good frame is oldest, unless all are present."""
        peer, ear = min(self._ears.items(), key=lambda item: (item[1].good, item[1].heard))
        if now - ear.good < PRESENT:
            return False
        self.gone(peer)
        return True

    def _decode(self, peer: Peer, ear: _Ear, data: bytes, now: float) -> None:
        self._take(peer, ear, ear.decoder.feed(data, LOOKS), now)
        if ear.decoder.behind:
            asyncio.get_running_loop().call_soon(self._go_on, peer, ear)

    def _go_on(self, peer: Peer, ear: _Ear) -> None:
        data, ear.late = ear.late, b""
        self._decode(peer, ear, data, self._now())

    def _settle(self, peer: Peer, ear: _Ear, now: float) -> None:
        self._take(peer, ear, ear.decoder.settle(), now)

    def _take(self, peer: Peer, ear: _Ear, packets: Iterable[Packet], now: float) -> None:
        for packet in packets:
            self._counts["signed"] += is_signed(packet.frame)
            if self._guardian is not None and not self._guardian.believes(packet, now):
                self._counts["refused"] += 1
                continue
            self._counts["frames"] += 1
            self._last = ear.good = now
            ear.senders.meet(packet, now)
            self._hear(self._number, peer, packet, now)

    def _totals(self) -> dict[str, Any]:
        return reduce(_added, map(_totals, self._ears.values()), self._past)

    def _reading(self, now: float) -> Reading:
        return Reading(now, self._counts["frames"], self._counts["bytes"], self._totals()["lost"])


def port_of(url: str, listener: Listener) -> Port:
    """Return the port of a URL, not open yet.

    Raises
    ------
    GroundError
        When it is none.
    """
    try:
        address = parse(url)
    except BadAddress as error:
        raise GroundError(str(error)) from error
    match address:
        case Udp():
            return (UdpListener if address.listen else UdpCaller)(address, listener)
        case Tcp():
            return (TcpListener if address.listen else TcpCaller)(address, listener)
        case Serial():
            return SerialPort(address, listener)


def _totals(ear: _Ear) -> _Totals:
    return {"lost": ear.senders.lost, "bad": ear.decoder.bad, "skipped": ear.decoder.skipped}


def _added(one: _Totals, other: _Totals) -> _Totals:
    """Add counts of the same names; what is unknown of one is unknown of both."""
    pairs = ((name, count, other[name]) for name, count in one.items())
    return {name: None if count is None or more is None else count + more for name, count, more in pairs}


def _remedy(error: Exception) -> str:
    if isinstance(error, OSError) and error.errno == errno.EADDRINUSE:
        return "; another program listens there (see ss -lnp): end it, or choose another port"
    return ""
