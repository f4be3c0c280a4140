"""Session descriptions over HTTP: what ffplay, VLC and ``ross listen`` are given to play a stream of RTP.

They name addresses, and hold no sound. The server binds the loopback unless told otherwise, reads one short request
from each client, and waits for none of them longer than a moment.
"""

from __future__ import annotations

import contextlib
import logging
import socket
import threading
from collections.abc import Callable, Iterator, Mapping
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, Self

from ross_payload.errors import AudioError, refused_as
from ross_payload.transport.link_url import LOOPBACK
from ross_protocols.mavlink.stream_values import description_file

REQUEST_TIMEOUT_S = 2.0  # for a client's request
MOST_CLIENTS = 8  # at a time; others are turned away
log = logging.getLogger(__name__)
Texts = Callable[[], Mapping[int, str]]  # session descriptions by the number of their stream


class SdpFiles(Mapping[str, bytes]):
    """The session descriptions of this moment as files by name, which are those of MAVLink FTP.

    >>> list(SdpFiles(lambda: {0: "v=0", 2: ""}))
    ['stream-0.sdp']

    Parameters
    ----------
    texts
        Tells them; empty ones are left out.
    """

    def __init__(self, texts: Texts) -> None:
        self._texts = texts

    def _files(self) -> dict[str, bytes]:
        return {description_file(number): text.encode() for number, text in self._texts().items() if text}

    def __getitem__(self, name: str) -> bytes:
        """Return one of them."""
        return self._files()[name]

    def __iter__(self) -> Iterator[str]:
        """Go through their names."""
        return iter(self._files())

    def __len__(self) -> int:
        """Count them."""
        return len(self._files())


class _Handler(BaseHTTPRequestHandler):
    timeout = REQUEST_TIMEOUT_S
    server_version, sys_version = "ross", ""

    def do_GET(self) -> None:  # as the library calls it
        server: Any = self.server
        files: Mapping[str, bytes] = server.files
        name = self.path.partition("?")[0].strip("/")
        content = dict(files).get(name) if name else "".join(f"{each}\n" for each in files).encode()
        if content is None:
            self.send_error(HTTPStatus.NOT_FOUND)
            return
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", "application/sdp" if name else "text/plain; charset=utf-8")
        self.send_header("Content-Length", str(len(content)))
        self.send_header("Cache-Control", "no-store")
        self.send_header("X-Content-Type-Options", "nosniff")
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, *_: object) -> None:  # what is asked for is no news
        pass


class _Server(ThreadingHTTPServer):
    daemon_threads = True
    files: Mapping[str, bytes]

    def __init__(self, address: tuple[str, int], files: Mapping[str, bytes]) -> None:
        self.address_family = socket.AF_INET6 if ":" in address[0] else socket.AF_INET
        self.files = files
        self._room = threading.BoundedSemaphore(MOST_CLIENTS)
        super().__init__(address, _Handler)

    def process_request(self, request: Any, client_address: Any) -> None:
        if self._room.acquire(blocking=False):
            super().process_request(request, client_address)
        else:
            self.shutdown_request(request)

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        patience = threading.Timer(REQUEST_TIMEOUT_S, _hang_up, (request,))  # for all of it: a byte a second is none
        patience.daemon = True
        patience.start()
        try:
            super().process_request_thread(request, client_address)
        finally:
            patience.cancel()
            self._room.release()

    def handle_error(self, *_: object) -> None:
        log.debug("a request for a session description ended early", exc_info=True)


def _hang_up(request: socket.socket) -> None:
    with contextlib.suppress(OSError):
        request.shutdown(socket.SHUT_RDWR)


class SdpServer:
    """Serves the session descriptions of this moment; a context manager.

    Parameters
    ----------
    texts
        Tells them; called by threads of its own.
    port
        To listen on; 0: one that is free.
    host
        Address to listen on.
    """

    def __init__(self, texts: Texts, port: int, host: str = LOOPBACK) -> None:
        self._files = SdpFiles(texts)
        self._address = host, port
        self._server: _Server | None = None

    def __enter__(self) -> Self:
        """Listen.

        Raises
        ------
        AudioError
            When the port is in use, or the address is none of this computer.
        """
        host, port = self._address
        with refused_as(AudioError, f"session descriptions: cannot listen on {host} port {port}"):
            self._server = _Server(self._address, self._files)
        serve = self._server.serve_forever
        threading.Thread(target=serve, args=(0.2,), name="sdp", daemon=True).start()
        return self

    def __exit__(self, *exception: object) -> None:
        """Stop listening."""
        server, self._server = self._server, None
        if server is not None:
            with contextlib.suppress(OSError):
                server.shutdown()
            server.server_close()

    @property
    def port(self) -> int:
        """Where it listens."""
        return int(self._server.server_address[1]) if self._server is not None else self._address[1]
