"""PCM over TCP as a feed: the payload connects, a thread copies what comes; see ``ross_protocols.audio.pcm``."""

from __future__ import annotations

import contextlib
import socket
import threading

from ross_payload.audio.channel_map import ChannelMap
from ross_payload.audio.live_source import LiveSource, OnSamples
from ross_payload.audio.open_source import SourceServices
from ross_payload.errors import AudioError, refused_as
from ross_payload.transport.link_url import host_and_port, tcp_endpoint
from ross_protocols.audio.pcm import Decoder, PcmError

CONNECT_TIMEOUT_S = 3.0  # [s] within which the other end answers and says what it sends
LARGEST = 65536  # of one read [bytes]


class PcmClient:
    """Connects to a server of PCM, each time it is called."""

    def __init__(self, address: str, rate: int, wiring: ChannelMap) -> None:
        self._address = tcp_endpoint(f"tcp:{address}", "audio.source")
        self._rate = rate
        self._wiring = wiring

    def __call__(self, on_samples: OnSamples) -> Connection:
        """Connect and read the header.

        Raises
        ------
        AudioError
            When nobody answers, or what they send does not fit.
        """
        where = f"tcp:{host_and_port(*self._address)}"
        with refused_as(AudioError, f"{where}: no audio"):
            sock = socket.create_connection(self._address, CONNECT_TIMEOUT_S)
        try:
            decoder = self._header(sock)
        except (OSError, PcmError, AudioError) as error:
            sock.close()
            raise AudioError(f"{where}: {error}") from error
        return Connection(sock, decoder, on_samples)

    def _header(self, sock: socket.socket) -> Decoder:
        decoder = Decoder()
        while decoder.header is None:
            data = sock.recv(1)  # the samples behind the header are for the thread
            if not data:
                raise AudioError("closed before it sent a PCM header")
            decoder.feed(data)
        header = decoder.header
        if header.rate != self._rate:
            raise AudioError(f"expected {self._rate} Hz (audio.rate_hz), got {header.rate} Hz")
        if header.channels < self._wiring.needed:
            raise AudioError(
                f"expected at least {self._wiring.needed} channels (audio.channels), got {header.channels}"
            )
        return decoder


class Connection:
    """A connection that audio comes through."""

    def __init__(self, sock: socket.socket, decoder: Decoder, on_samples: OnSamples) -> None:
        self._socket = sock
        self._decoder = decoder
        self._on_samples = on_samples
        self._thread = threading.Thread(target=self._receive, name="pcm", daemon=True)
        sock.settimeout(None)
        self._thread.start()

    @property
    def alive(self) -> bool:
        """Whether frames may still come."""
        return self._thread.is_alive()

    def close(self) -> None:
        """Hang up; idempotent."""
        with contextlib.suppress(OSError):  # the other end hung up first
            self._socket.shutdown(socket.SHUT_RDWR)
        self._thread.join()
        self._socket.close()

    def _receive(self) -> None:
        with contextlib.suppress(OSError):  # the end, like hanging up: it is opened again
            while data := self._socket.recv(LARGEST):
                self._on_samples(self._decoder.feed(data))


def audio_source(address: str, services: SourceServices) -> LiveSource:
    """Make the source ``tcp:HOST:PORT``.

    Raises
    ------
    ConfigError
        When the address is something else.
    """
    return services.live(PcmClient(address, services.audio.rate_hz, services.wiring))
