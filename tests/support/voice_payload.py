"""A payload that streams tones to whoever orders it to: telemetry and commands over UDP, sound over RTP.

The mixture is a tone of 500 Hz, the target one of 1000 Hz, source N one of 1500 + 250 N Hz, each at half of full scale.
"""

import math
import socket
import threading
import time
from dataclasses import replace

import numpy as np

from emulated_scene import full
from ross_payload.audio.sinks.rtp_sender import RtpSender
from ross_payload.interfaces import VoiceBlock
from ross_payload.transport.rtp.session_description import Media
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.commands import Result, acknowledgement
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import ross
from ross_protocols.mavlink.stream_command import command_of
from ross_protocols.mavlink.stream_values import Codec, Selection, StreamReport
from ross_protocols.mavlink.values import Audio

RATE = 16000
MEASURED_RATE = 15999.6  # as a payload tells it
HOP_S = 0.02
TELL_S = 0.2
TONES = {Selection.MIXTURE: 500.0, Selection.TARGET: 1000.0}
BIT_RATE = 48000
LONGEST_S = 20.0


class VoicePayload:
    """A context manager with a thread.

    ``lose``: every so many-th packet never leaves, and none is sent once more; ``refuse``: no stream begins."""

    def __init__(self, port, *, lose=0, refuse=False):
        self._ground, self._lose, self._refuse = ("127.0.0.1", port), lose, refuse
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", 0))
        self._rtp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._rtp.bind(("127.0.0.1", 0))
        for each in (self._socket, self._rtp):
            each.setblocking(False)
        self._encoder, self._decoder = Encoder(1, 191), Decoder()
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="voice payload")
        self._sender, self._samples, self._sent = None, 0, 0
        self.orders = []  # stream commands as they came
        self.stream = StreamReport(0, 3, 4, "rtp", Selection.NONE, True, RATE, codec=Codec.OPUS)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *error):
        self._ended.set()
        self._thread.join(LONGEST_S)
        self._socket.close()
        self._rtp.close()

    def go_to(self, address, port):
        """Tell of a stream of the target that somebody else has ordered."""
        self.stream = replace(self.stream, on=True, selection=Selection.TARGET, address=address, port=port)

    def give_up(self):
        """End the stream since nobody was heard to take it."""
        self.stream = replace(self.stream, on=False, listeners=0, detail="no listener for 25 s")

    def stop(self):
        """End the stream as if another ground station had ordered that."""
        self.stream = replace(self.stream, on=False)

    def resume(self):
        """Stream again to where it was, unasked."""
        self.stream = replace(self.stream, on=True)

    def _run(self):
        began = due = told = time.monotonic()
        while not self._ended.is_set():
            now = time.monotonic()
            if now >= told:
                told = now + TELL_S
                self._tell(now - began + 20.0)
            self._hear(now)
            if now >= due:
                due += HOP_S
                self._stream(now)
            self._ended.wait(0.004)

    def _tell(self, age):
        said = [each for each in full(age, 3, 1) if not isinstance(each, Audio)]
        for each in [*said, Audio(time_usec=0, rate=MEASURED_RATE)]:
            self._say(each)
        if self.stream.selection is not Selection.NONE:
            self._say(self.stream)

    def _say(self, message):
        self._socket.sendto(self._encoder.encode(message), self._ground)

    def _hear(self, now):
        for data in _arrived(self._socket):
            for packet in self._decoder.feed(data):
                message = packet.message
                if message.get_type() == "COMMAND_LONG" and message.command == ross.MAV_CMD_ROSS_STREAM:
                    self._obey(command_of([getattr(message, f"param{index}") for index in range(1, 8)]), packet)
        for data in _arrived(self._rtp):
            again = [] if self._sender is None else self._sender.on_report(data, now)
            for packet in [] if self._lose else again:
                self._send(packet)

    def _obey(self, command, packet):
        self.orders.append(command)
        result = Result.DENIED if self._refuse else Result.ACCEPTED
        self._say(acknowledgement(ross.MAV_CMD_ROSS_STREAM, result, ComponentId(packet.system_id, packet.component_id)))
        if self._refuse:
            return
        if command.selection is Selection.NONE:
            if not command.address or (command.address, command.port) == (self.stream.address, self.stream.port):
                self.stream = replace(self.stream, on=False)
        else:
            place = {"address": command.address, "port": command.port} if command.address else {}
            new = not self.stream.on or place.get("port", self.stream.port) != self.stream.port
            self.stream = replace(
                self.stream, on=True, selection=command.selection, source=command.source, delay=0.05,
                listeners=None, detail="", **place,
            )  # fmt: skip
            if new:
                self._sender = RtpSender(RATE, Media.of("opus", RATE), BIT_RATE)
        self._say(self.stream)

    def _stream(self, now):
        if not self.stream.on or self._sender is None:
            return
        n = round(HOP_S * RATE)
        tone = TONES.get(self.stream.selection, 1500.0 + 250.0 * (self.stream.source or 0))
        times = np.arange(self._samples, self._samples + n) / RATE
        block = VoiceBlock((0.5 * np.sin(2 * math.pi * tone * times)).astype(np.float32), self._samples, now - HOP_S)
        self._samples += n
        for packet in self._sender.packets(block):
            self._sent += 1
            if not self._lose or self._sent % self._lose:
                self._send(packet)
        if (report := self._sender.report(now, time.time())) is not None:
            self._send(report)

    def _send(self, packet):
        self._rtp.sendto(packet, (self.stream.address, self.stream.port))


def _arrived(sock):
    while True:
        try:
            yield sock.recv(65536)
        except BlockingIOError:
            return
        except ConnectionRefusedError:
            continue
