"""What is listened to over RTP: a socket, a thread that takes what arrives and answers, and the receiver."""

from __future__ import annotations

import contextlib
import select
import socket
import threading
from typing import Any, Self

from ross_payload.audio.listener.feed import Feed, Progress
from ross_payload.errors import AudioError, reason
from ross_payload.interfaces import Clock, Samples
from ross_payload.transport.ports import MAX_READ_BYTES
from ross_payload.transport.rtp.receiver import Reception, RtpReceiver
from ross_payload.transport.rtp.session_description import Session

LOOK_S = 0.01  # between two answers
AT_ONCE = 64  # datagrams taken before the next answer
BUFFER_BYTES = 1 << 19  # of datagrams that may wait with the system


class RtpFeed(Feed):
    """Listens at an address of this computer.

    Parameters
    ----------
    session
        What comes, and where.
    clock
        Tells the time, and the time of day.
    delay_s
        That packets wait [s]; 0: as short as the network allows.

    Raises
    ------
    ConfigError
        When it is Opus, and there is no libopus.
    """

    def __init__(self, session: Session, clock: Clock, delay_s: float = 0.0) -> None:
        self._session, self._clock = session, clock
        self._receiver = RtpReceiver(session.media, delay_s)
        self._guard = threading.Lock()  # of the receiver
        self._leaving = threading.Event()
        self._thread: threading.Thread | None = None
        self._socket: socket.socket | None = None
        self.where = f"{session.host} port {session.port}"

    @property
    def rate(self) -> int:
        """Of the samples [Hz]."""
        return self._session.media.rate

    @property
    def port(self) -> int:
        """Where it listens; another than asked for when that was 0."""
        return self._socket.getsockname()[1] if self._socket is not None else self._session.port

    def __enter__(self) -> Self:
        """Listen.

        Raises
        ------
        AudioError
            When the port is in use, or the address is none of this computer.
        """
        host, port = self._session.host, self._session.port
        sock = socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET, socket.SOCK_DGRAM)
        try:
            sock.setblocking(False)
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER_BYTES)
            sock.bind((host, port))
        except OSError as error:
            sock.close()
            raise AudioError(f"cannot listen on {self.where}: {reason(error)}") from error
        self._socket = sock
        self._thread = threading.Thread(target=self._run, args=(sock,), name="rtp", daemon=True)
        self._thread.start()
        return self

    def __exit__(self, *exception: object) -> None:
        """Listen no more."""
        self._leaving.set()
        if self._thread is not None:
            self._thread.join()
        if self._socket is not None:
            self._socket.close()

    def read(self, n: int) -> Samples:
        """Return the next ``n`` samples, (n,), zeros where there is nothing."""
        with self._guard:
            return self._receiver.read(n, self._clock.now())

    def progress(self, wall: float) -> Progress:
        """Tell how it goes, when the time of day is ``wall`` [s since 1970]."""
        with self._guard:
            reception = self._receiver.reception(self._clock.now())
            total = self._receiver.total_delay(wall)
        received, over = reception.received > 0, reception.ended and not reception.playing
        return Progress(reception.playing, received, _words(reception, total), ended=over, silent_s=reception.silent_s)

    def _run(self, sock: socket.socket) -> None:
        events = select.poll()
        events.register(sock, select.POLLIN)
        while not self._leaving.is_set():
            events.poll(1000 * LOOK_S)
            with self._guard:
                self._take(sock)
                answers = self._receiver.feedback(self._clock.now())
                sender: Any = self._receiver.sender  # as `recvfrom` tells it
            for answer in answers:
                with contextlib.suppress(OSError):  # it hears the next one
                    sock.sendto(answer, sender)

    def _take(self, sock: socket.socket) -> None:
        for _ in range(AT_ONCE):
            try:
                datagram, sender = sock.recvfrom(MAX_READ_BYTES)
            except OSError:  # nothing, or the news that nobody takes the answers
                return
            self._receiver.on_datagram(datagram, self._clock.now(), sender)


def _words(reception: Reception, total: float | None) -> str:
    sent = reception.received + reception.lost
    delay = f"delay {1000 * reception.delay_s:.0f} ms here"
    if total is not None and 0 <= total < 60:
        delay += f", {1000 * total:.0f} ms since the microphone"
    parts = [delay, f"lost {reception.lost} of {sent} ({100 * reception.lost_share:.1f} %)"]
    parts += [f"late {reception.late}", f"twice {reception.duplicates}"]
    parts += [f"made up {1000 * reception.concealed_s:.0f} ms"]
    parts += [f"other datagrams {reception.bad}"] * (reception.bad > 0) + ["the sender has ended it"] * reception.ended
    return ", ".join(parts)
