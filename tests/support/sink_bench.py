"""Sinks with their far ends: what the contract of everything that a voice goes to drives."""

from __future__ import annotations

import contextlib
import socket
import threading

import numpy as np
import soundfile

from clocks import LeapingClock
from ports import free_port
from ross_payload.audio.sinks import SinkServices, checked_options, make_sink
from ross_payload.interfaces import VoiceBlock
from ross_protocols.audio.pcm import Decoder
from waiting import wait_for

RATE, HOP = 16000, 256
GRID = 2.0**-23


def voice(seconds, seed=0):
    counts = np.random.default_rng(seed).integers(-(2**20), 2**20, round(seconds * RATE))
    return (counts * GRID).astype(np.float32)


def blocks(samples, first=0):
    for begin in range(0, len(samples), HOP):
        yield VoiceBlock(samples[begin : begin + HOP], first + begin, 3.0 + (first + begin) / RATE)


class Rig:
    """One sink, and what has come out of it at the other end."""

    def __init__(self, kind, options, services, received):
        self.kind, self.options, self.services, self.received = kind, options, services, received
        self.listen = lambda: None
        self.wait_until_taken = lambda count: None  # in real time there is time for it

    def make(self):
        return make_sink(self.kind, checked_options(self.kind, self.options, "options"), self.services)


class TcpListener:
    """Connects, and keeps what it hears; can stop reading."""

    def __init__(self, port):
        self.samples = np.zeros(0, np.float32)
        self._decoder = Decoder()
        self._socket = socket.create_connection(("127.0.0.1", port), 20)
        self._thread = threading.Thread(target=self._read, daemon=True)

    def begin(self):
        self._thread.start()

    def has_taken(self, count):
        return len(self.samples) >= count

    def _read(self):
        with contextlib.suppress(OSError):
            while data := self._socket.recv(65536):
                frames = self._decoder.feed(data)
                if frames.size:
                    self.samples = np.concatenate([self.samples, frames[:, 0]])

    def close(self):
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()


def file(tmp_path, stack, suffix):
    path = tmp_path / "folder" / f"voice{suffix}"
    rig = Rig("file", {"path": str(path)}, services(tmp_path), lambda: soundfile.read(path, dtype="float32")[0])
    rig.path = path
    return rig


def flac(tmp_path, stack):
    return file(tmp_path, stack, ".flac")


def wav(tmp_path, stack):
    return file(tmp_path, stack, ".wav")


def tcp(tmp_path, stack):
    port = free_port()
    listeners = []
    rig = Rig("tcp", {"port": port}, services(tmp_path), lambda: listeners[0].samples)

    def listen():
        listeners.append(TcpListener(port))
        stack.callback(listeners[-1].close)
        listeners[-1].begin()

    rig.listen = listen
    rig.wait_until_taken = lambda count: wait_for(lambda: len(rig.received()) >= count)
    return rig


def services(folder):
    return SinkServices(LeapingClock(), RATE, 0, "target", folder)


KINDS = {"flac": flac, "wav": wav, "tcp": tcp}
