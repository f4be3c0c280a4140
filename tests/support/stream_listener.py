"""Who hears a payload over UDP: a ground station that orders, and what is streamed as L16, packet by packet."""

from __future__ import annotations

import socket
import threading
import time
from dataclasses import dataclass

import numpy as np

from ross_protocols.mavlink import stream_command
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.dialect import common, ross
from ross_protocols.mavlink.stream_command import StreamCommand
from ross_protocols.mavlink.stream_values import Selection

HEADER_BYTES = 12
DYNAMIC = range(96, 128)  # payload types; what else comes is RTCP


@dataclass(frozen=True)
class Heard:
    """One packet."""

    at: float  # monotonic [s]
    number: int
    index: int  # of its first sample, from an arbitrary origin
    samples: np.ndarray


def place_of(heard, mixture, step=2**-14):
    """Return where samples are in a mixture, to within ``step``; -1: nowhere."""
    places = np.flatnonzero(np.abs(mixture[: len(mixture) - len(heard) + 1] - heard[0]) < step)
    for sample in (1, len(heard) // 2, len(heard) - 1):
        places = places[np.abs(mixture[places + sample] - heard[sample]) < step]
    return next((at for at in places if np.abs(mixture[at : at + len(heard)] - heard).max() < step), -1)


class UdpListener:
    """A UDP port of this computer and a thread that takes what comes there. A context manager."""

    def __init__(self):
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        self._socket.bind(("127.0.0.1", 0))
        self._socket.settimeout(0.1)
        self.port = self._socket.getsockname()[1]
        self.packets = []
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._listen)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *error):
        self._over.set()
        self._thread.join()
        self._socket.close()

    def _listen(self):
        while not self._over.is_set():
            try:
                data, peer = self._socket.recvfrom(65536)
            except TimeoutError:
                continue
            self._take(data, peer)


class GroundListener(UdpListener):
    """Hears the payload, and orders what it is given: the first at once, the others when the one before is answered."""

    def __init__(self, *orders):
        super().__init__()
        self.link = f"udpout:127.0.0.1:{self.port}"
        self._orders, self._asked = list(orders), 0
        self._decoder, self._encoder = Decoder(), Encoder(255, 190)

    def messages(self, name):
        return [packet.message for packet in self.packets if packet.name == name]

    def texts(self):
        return "".join(str(message.text) for message in self.messages("STATUSTEXT"))

    def _take(self, data, peer):
        self.packets += self._decoder.feed(data)
        if self._orders and self._asked == len(self.messages("COMMAND_ACK")):
            self._socket.sendto(self._encoder.encode(self._orders.pop(0)), peer)
            self._asked += 1


class StreamListener(UdpListener):
    """Takes one stream."""

    @property
    def order(self):
        """The command that has the mixture streamed here."""
        wanted = StreamCommand(None, Selection.MIXTURE, 0, 0.0, None, "127.0.0.1", self.port, "L16")
        numbers = stream_command.numbers_of(wanted)
        return common.MAVLink_command_long_message(1, 191, ross.MAV_CMD_ROSS_STREAM, 0, *numbers)

    @property
    def missing(self):
        """Packets that never came between the first and the last."""
        numbers = [packet.number for packet in self.packets]
        return (numbers[-1] - numbers[0]) % 2**16 + 1 - len(set(numbers))

    @property
    def seconds(self):
        """From the first sample to the last at 16 kHz [s]."""
        return sum(len(packet.samples) for packet in self.packets) / 16000

    def _take(self, data, _peer):
        if len(data) > HEADER_BYTES and data[1] & 127 in DYNAMIC:
            number, index = int.from_bytes(data[2:4], "big"), int.from_bytes(data[4:8], "big")
            samples = np.frombuffer(data[HEADER_BYTES:], ">i2").astype(np.int16)
            self.packets.append(Heard(time.monotonic(), number, index, samples))
