"""What is listened to over TCP: PCM of the sink ``tcp``, kept near a constant delay; see `ross_protocols.audio.pcm`.

What waits goes up and down as blocks come and are taken. It is corrected when it has been too much all the time, or too
little, so that blocks that come unevenly alone change no sample.
"""

from __future__ import annotations

import contextlib
import socket
import threading
import time
from collections import deque
from typing import Self

import numpy as np

from ross_payload.audio.listener.feed import Feed, Progress
from ross_payload.errors import AudioError, reason
from ross_payload.interfaces import Samples
from ross_payload.transport.link_url import host_and_port
from ross_payload.transport.rtp.waveforms import lengthened, shortened
from ross_protocols.audio.pcm import Decoder, PcmError

CONNECT_S = 3.0  # within which the other end answers and says what it sends
LARGEST = 65536  # of one read [bytes]
DELAY_S = 0.1  # of samples that wait, when it begins
NEAR_S = 0.04  # by which it may differ, before it is corrected
FARTHEST_S = 2.0  # that may wait; the oldest make room
STEP_S = 0.02  # of sound that is made shorter or longer at once
CHECK_S = 0.1  # between two corrections
LOOKED_AT = 50  # times that samples were taken, about a second
FEWEST = 10  # of them, before anything is concluded


class PcmFeed(Feed):
    """Connects to a server of PCM and takes its first channel.

    Parameters
    ----------
    address
        Host and port.
    """

    def __init__(self, address: tuple[str, int]) -> None:
        self._address = address
        self.where = f"tcp:{host_and_port(*address)}"
        self._rate = 0
        self._waiting: Samples = np.zeros(0, np.float32)
        self._guard = threading.Lock()  # of what waits, and counts
        self._flowing = False
        self._levels: deque[int] = deque(maxlen=LOOKED_AT)  # samples that waited when some were taken
        self._received = self._lost = self._made_up = self._since = 0
        self._over, self._heard_at = "", 0.0
        self._socket: socket.socket | None = None
        self._thread: threading.Thread | None = None

    @property
    def rate(self) -> int:
        """Of the samples [Hz]."""
        return self._rate

    def __enter__(self) -> Self:
        """Connect.

        Raises
        ------
        AudioError
            When nobody answers, or what they send is no PCM.
        """
        decoder = Decoder()
        try:
            self._socket = sock = socket.create_connection(self._address, CONNECT_S)
            samples = np.zeros((0, 0), np.float32)
            while decoder.header is None:
                data = sock.recv(1)
                if not data:
                    raise AudioError(f"{self.where}: closed before it sent a PCM header")
                samples = decoder.feed(data)
            sock.settimeout(None)
        except (OSError, PcmError, UnicodeError) as error:  # a name may be none
            self.__exit__()
            raise AudioError(f"{self.where}: no audio: {reason(error)}") from error
        self._rate = decoder.header.rate
        self._keep(samples)
        self._thread = threading.Thread(target=self._run, args=(sock, decoder), name="pcm", daemon=True)
        self._thread.start()
        return self

    def __exit__(self, *exception: object) -> None:
        """Hang up."""
        if self._socket is not None:
            with contextlib.suppress(OSError):
                self._socket.shutdown(socket.SHUT_RDWR)
            self._socket.close()
        if self._thread is not None:
            self._thread.join()

    def read(self, n: int) -> Samples:
        """Return the next ``n`` samples, (n,), zeros where there is nothing; begins when enough has come."""
        with self._guard:
            if not self._flowing and len(self._waiting) < DELAY_S * self.rate and not self._over:
                return np.zeros(n, np.float32)
            self._flowing = True
            self._correct(n)
            taken, self._waiting = self._waiting[:n], self._waiting[n:]
            if len(taken) < n and not self._over:
                self._flowing = False
                self._levels.clear()
                self._made_up += n - len(taken)
            return np.pad(taken, (0, n - len(taken)))

    def progress(self, wall: float) -> Progress:
        """Tell how it goes."""
        with self._guard:
            delay, rate = len(self._waiting) / self.rate, self.rate
            words = f"delay {1000 * delay:.0f} ms here, lost {1000 * self._lost / rate:.0f} ms"
            words += f", silent {1000 * self._made_up / rate:.0f} ms" + (f", {self._over}" if self._over else "")
            over = bool(self._over) and not len(self._waiting)
            silent = 0.0 if self._over else time.monotonic() - self._heard_at
            return Progress(self._flowing, self._received > 0, words, ended=over, final=over, silent_s=silent)

    def _correct(self, n: int) -> None:
        """Shorten or lengthen what is played next by a period, when what waits has become more or less."""
        self._since += n
        self._levels.append(len(self._waiting))
        wanted, step = round(DELAY_S * self.rate), round(STEP_S * self.rate)
        error = max(min(self._levels) - wanted, 0) + min(max(self._levels) - wanted, 0)
        few = len(self._levels) < FEWEST or self._since < CHECK_S * self.rate
        if self._over or few or abs(error) < NEAR_S * self.rate:
            return
        next_ones = self._waiting[:step]
        fitted = shortened(next_ones, error) if error > 0 else lengthened(next_ones, -error)
        self._waiting, self._since = np.concatenate([fitted, self._waiting[step:]]), 0
        self._levels = deque((level + len(fitted) - len(next_ones) for level in self._levels), LOOKED_AT)

    def _keep(self, frames: Samples) -> None:
        with self._guard:
            self._heard_at = time.monotonic()
            samples = frames[:, 0] if frames.size else np.zeros(0, np.float32)
            self._received += len(samples)
            waiting = np.concatenate([self._waiting, samples])
            most = round(FARTHEST_S * self.rate)
            self._lost += max(len(waiting) - most, 0)
            self._waiting = waiting[-most:]

    def _run(self, sock: socket.socket, decoder: Decoder) -> None:
        why = "the sender has ended it"
        try:
            while data := sock.recv(LARGEST):
                self._keep(decoder.feed(data))
        except (OSError, PcmError) as error:
            why = reason(error)
        with self._guard:
            self._over = why
