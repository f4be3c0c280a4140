"""The sink ``rtp``: a voice as L16 or Opus to one address, over RTP; see `rtp_sender` and the session description.

A thread of its own encodes and sends as blocks come: their order is the pace, and pauses between packets would only be
delay. One socket serves all: reports go over it both ways (RFC 5761), and since it is connected the system says when
nobody listens there.
"""

from __future__ import annotations

import contextlib
import ipaddress
import logging
import os
import select
import socket
import threading
import time
from collections import deque
from typing import Annotated, Literal, Self

from pydantic import Field, field_validator

from ross_payload.audio.sinks import BuiltInSink, SinkInfo, SinkServices
from ross_payload.audio.sinks.rtp_sender import RtpSender
from ross_payload.config.table import Table
from ross_payload.errors import AudioError, reason, shown
from ross_payload.interfaces import VoiceBlock
from ross_payload.transport.ports import MAX_READ_BYTES
from ross_payload.transport.rtp.session_description import L16, OPUS, Media, Session, described

KEPT_S = 1.0  # of samples that wait for the thread; beyond that they are lost
IDLE_S = 0.25  # between two looks, with nothing to do
FAILED_S = 3.0  # after the system could not send, it still holds
LEAVE_S = 1.0  # for what waits, in the end
TOO_SLOW = "the network is slower than the stream"
log = logging.getLogger(__name__)
CODECS = {name.lower(): name for name in (L16, OPUS)}


class RtpOptions(Table):
    """[listening.streams.options] of ``rtp``."""

    address: str  # of one computer, as a number: 192.168.1.20, fd00::20
    port: Annotated[int, Field(ge=1, le=65535)] = 5004  # UDP port; also of the reports, both ways
    codec: Literal["opus", "L16"] = "opus"  # with forward error correction, or samples of 16 bits
    bit_rate_kbps: Annotated[int, Field(ge=12, le=256)] = 48  # of Opus
    rate_hz: Annotated[int, Field(ge=8000, le=48000)] | None = None  # of L16; absent: that of the audio

    @field_validator("address")
    @classmethod
    def _one_computer(cls, text: str) -> str:
        return unicast(text)

    @field_validator("codec", mode="before")
    @classmethod
    def _any_case(cls, name: object) -> object:
        return CODECS.get(name.lower(), name) if isinstance(name, str) else name


def unicast(text: str) -> str:
    """Return an address in its usual form, that of IPv4 where it is one of these in IPv6 (RFC 4291, 2.5.5.2).

    >>> unicast("FD00::0007"), unicast("::ffff:192.168.1.20")
    ('fd00::7', '192.168.1.20')

    Raises
    ------
    ValueError
        When it is not the address of one computer; says what was expected.
    """
    try:
        address = ipaddress.ip_address(text)
    except ValueError:
        raise ValueError(f"expected one like 192.168.1.20 or fd00::20, got {shown(text)}") from None
    if isinstance(address, ipaddress.IPv6Address):
        address = address.ipv4_mapped or address
    limited = address == ipaddress.ip_address("255.255.255.255")
    if address.is_multicast or address.is_unspecified or limited:
        kind = "multicast" if address.is_multicast else "broadcast" if limited else "no address in particular"
        raise ValueError(f"expected that of one computer, got {text}, which is {kind}")
    return str(address)


class RtpSink:
    """An AudioSink that sends to one address.

    Parameters
    ----------
    options
        Where to, and how.
    services
        Clock, rate, and what it is about.
    """

    def __init__(self, options: RtpOptions, services: SinkServices) -> None:
        self._options, self._services = options, services
        self._clock = services.clock
        self._sender = self._new_sender()
        self._where = f"rtp to {options.address} port {options.port}"
        self._socket: socket.socket | None = None
        self._wake = -1  # descriptor of an event
        self._thread: threading.Thread | None = None
        self._blocks: deque[VoiceBlock] = deque()
        self._waiting = 0  # samples of them
        self._guard = threading.Condition()  # of the two above: there is room again
        self._leaving = threading.Event()
        self._failed_at = -1e9
        self._failure = ""
        self._broken = ""  # why the thread has ended
        self._sdp = ""
        self.lost = 0

    @property
    def fault(self) -> str:
        """What is wrong: the latest thing, until it has been well for a while."""
        now = self._clock.now()
        if self._broken:
            return f"{self._where}: {self._broken}"
        if now < self._failed_at + FAILED_S:
            return f"{self._where}: {self._failure}"
        return f"{self._where}: no receiver at this port" if self._sender.listener.is_refused(now) else ""

    @property
    def info(self) -> SinkInfo:
        """Where it goes, and who takes it: who reports, or may take it without a word since nobody refuses it."""
        sender, now = self._sender, self._clock.now()
        return SinkInfo(
            self._options.address,
            self._options.port,
            sender.media.codec,
            sender.media.rate,
            listeners=int(self._thread is not None and sender.listener.may_listen(now)),
            packets_lost=sender.packets_lost,
            unheard_s=sender.listener.unheard(now),
            sdp=self._sdp,
        )

    def write(self, block: VoiceBlock) -> None:
        """Have samples sent.

        Raises
        ------
        AudioError
            When they cannot be encoded any more.
        """
        if self._broken:
            raise AudioError(f"{self._where}: {self._broken}")
        with self._guard:
            if not self._services.live:  # as many samples as in live time would be lost in simulated time
                self._guard.wait_for(lambda: self._has_room(block), LEAVE_S)
            if self._thread is None or not self._has_room(block):
                self.lost += len(block.samples)
                return
            self._blocks.append(block)
            self._waiting += len(block.samples)
            os.eventfd_write(self._wake, 1)

    def _has_room(self, block: VoiceBlock) -> bool:
        return self._waiting + len(block.samples) <= KEPT_S * self._services.rate

    def __enter__(self) -> Self:
        """Open the socket, and begin.

        Raises
        ------
        AudioError
            When the address is out of reach, or the network's broadcast.
        """
        address, port = self._options.address, self._options.port
        family = socket.AF_INET6 if ":" in address else socket.AF_INET
        sock = socket.socket(family, socket.SOCK_DGRAM)
        try:
            sock.setblocking(False)
            sock.connect((address, port))  # the broadcast of a network is refused: it was not asked for
        except OSError as error:
            sock.close()
            raise AudioError(f"{self._where}: {reason(error)}") from error
        self._sender = self._new_sender()
        self._sdp = self._session(sock.getsockname()[0])
        self._socket, self._wake = sock, os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
        self._blocks.clear()
        self._waiting = 0
        self._leaving.clear()
        self._broken = ""
        self._thread = threading.Thread(target=self._run, args=(sock, self._wake), name="rtp", daemon=True)
        self._thread.start()
        return self

    def __exit__(self, *exception: object) -> None:
        """Send what waits, say goodbye and close."""
        thread, sock = self._thread, self._socket
        if thread is None or sock is None:
            return
        self._leaving.set()
        os.eventfd_write(self._wake, 1)
        thread.join(LEAVE_S)
        with self._guard:
            self.lost += self._waiting
            self._thread = self._socket = None
            os.close(self._wake)
        with contextlib.suppress(OSError):
            sock.send(self._sender.goodbye())
        sock.close()

    def _new_sender(self) -> RtpSender:
        rate, options = self._services.rate, self._options
        wanted = options.rate_hz if options.codec == L16 and options.rate_hz else rate
        return RtpSender(rate, Media.of(options.codec, wanted), 1000 * options.bit_rate_kbps)

    def _session(self, origin: str) -> str:
        options, services = self._options, self._services
        media = self._sender.media
        return described(Session(media, options.address, options.port, services.title, origin, services.number + 1))

    # ------------------------------------------------------------------------------------------- the thread

    def _run(self, sock: socket.socket, wake: int) -> None:
        try:
            self._work(sock, wake)
        except Exception as error:  # whatever an encoder may raise: `write` says it, and the sink is opened again
            log.exception("%s has failed", self._where)
            self._broken = str(error) or type(error).__name__

    def _work(self, sock: socket.socket, wake: int) -> None:
        events = select.poll()
        events.register(wake, select.POLLIN)
        events.register(sock, select.POLLIN)
        while not (self._leaving.is_set() and not self._blocks):
            ready = {descriptor for descriptor, _ in events.poll(1000 * IDLE_S)}
            if wake in ready:
                os.eventfd_read(wake)
            if sock.fileno() in ready:
                self._answer(sock)
            while self._blocks:
                with self._guard:
                    block = self._blocks.popleft()
                    self._waiting -= len(block.samples)
                    self._guard.notify()
                for packet in self._sender.packets(block):
                    self.lost += 0 if self._send(sock, packet) else self._sender.media.packet
            report = self._sender.report(self._clock.now(), time.time())
            if report is not None:
                self._send(sock, report)

    def _answer(self, sock: socket.socket) -> None:
        """Take what the listener says; send what it asks for once more."""
        with contextlib.suppress(BlockingIOError):
            try:
                said = sock.recv(MAX_READ_BYTES)
            except ConnectionRefusedError:
                self._sender.listener.refused(self._clock.now())
                return
            except BlockingIOError:
                return
            except OSError as error:  # news of an earlier packet, too: a firewall has refused it
                self._failed_at, self._failure = self._clock.now(), reason(error)
                self._sender.listener.refused(self._failed_at)
                return
            for packet in self._sender.on_report(said, self._clock.now()):
                self._send(sock, packet)

    def _send(self, sock: socket.socket, packet: bytes) -> bool:
        self._sender.listener.sent(self._clock.now())
        for _ in range(2):
            try:
                sock.send(packet)
            except ConnectionRefusedError:  # the news is of an earlier packet; this one was not sent
                self._sender.listener.refused(self._clock.now())
                continue
            except BlockingIOError:  # which tells nothing of who listens
                self._failed_at, self._failure = self._clock.now(), TOO_SLOW
                return False
            except OSError as error:
                self._failed_at, self._failure = self._clock.now(), reason(error)
                self._sender.listener.refused(self._failed_at)
                return False
            return True
        return False


sink = BuiltInSink(RtpOptions, RtpSink)
