"""The file server: a few files in memory, to be read over MAVLink FTP; nothing can be written.

``heard`` takes what arrives and ``tick`` the time, both on the thread of the pump. Of a client only what it has open is
remembered, so that a request that comes twice is answered twice alike.
"""

from __future__ import annotations

import struct
from collections import OrderedDict
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from ross_payload.links import Heard
from ross_payload.telemetry.allowance import Allowance
from ross_payload.telemetry.identity import Endpoint
from ross_payload.telemetry.ledger import Sender
from ross_protocols.ftp import MOST, Error, Opcode, Packet, message_of, packet_of

CLIENTS = 8  # that have a file open; then the oldest loses it
SPEED = 2700.0  # of a burst [bytes/s]: half of a line of 57600 baud
AROUND = 24  # bytes of a frame beside the data
BURST, RATE = 40, 20.0  # requests at once, and [1/s]; what is more is as if lost


@dataclass(slots=True)
class _Client:
    """What a client has open, and how far a burst has come."""

    content: bytes
    burst: Packet | None = None  # the next portion, as a request
    due: float = 0.0  # [s]


class FileServer:
    """Lets clients read ``files``, by name, from our component."""

    def __init__(self, endpoint: Endpoint, files: Mapping[str, bytes]) -> None:
        self._endpoint = endpoint
        self._files = files
        self._clients: OrderedDict[Sender, _Client] = OrderedDict()
        self._allowance = Allowance(BURST, RATE)
        self._now = 0.0
        self._answers: Mapping[int, Callable[[Packet, Sender], Packet]] = {
            Opcode.TERMINATE: self._close,
            Opcode.RESET: self._close,
            Opcode.OPEN_RO: self._open,
            Opcode.READ: self._read,
            Opcode.BURST_READ: self._begin,
        }

    def heard(self, heard: Heard) -> None:
        """Take a packet; what is no request for us passes by."""
        request, message = packet_of(heard.packet.message), heard.packet.message
        ours = self._endpoint.system_id, self._endpoint.component_id
        if request is None or not heard.may_order or (message.target_system, message.target_component) != ours:
            return
        if request.opcode in (Opcode.ACK, Opcode.NAK) or not self._allowance.take(self._now):
            return
        sender = heard.packet.system_id, heard.packet.component_id
        answer = self._answers.get(request.opcode, self._unknown)(request, sender)
        self._send(answer, sender)

    def tick(self, now: float) -> None:
        """Send the next portion of every burst that is due."""
        self._now = now
        for sender, client in self._clients.items():
            if client.burst is not None and now >= client.due:
                self._send(self._portion(client, client.burst), sender)

    def _open(self, request: Packet, sender: Sender) -> Packet:
        name = request.data.split(b"\0")[0].decode("ascii", "replace").lstrip("/")
        if name not in self._files:
            return _refused(request, Error.FILE_NOT_FOUND)
        self._clients.pop(sender, None)
        self._clients[sender] = _Client(self._files[name])
        if len(self._clients) > CLIENTS:
            self._clients.popitem(last=False)
        return _answered(request, struct.pack("<I", len(self._files[name])))

    def _close(self, request: Packet, sender: Sender) -> Packet:
        self._clients.pop(sender, None)
        return _answered(request)

    def _read(self, request: Packet, sender: Sender) -> Packet:
        if sender not in self._clients:
            return _refused(request, Error.INVALID_SESSION)
        if request.size > MOST:
            return _refused(request, Error.INVALID_DATA_SIZE)
        portion = self._clients[sender].content[request.offset :][: request.size or MOST]
        return _answered(request, portion) if portion else _refused(request, Error.END_OF_FILE)

    def _begin(self, request: Packet, sender: Sender) -> Packet:
        """Answer with the first portion of a burst; the others follow in time."""
        if sender not in self._clients:
            return _refused(request, Error.INVALID_SESSION)
        return self._portion(self._clients[sender], request)

    def _portion(self, client: _Client, request: Packet) -> Packet:
        portion = client.content[request.offset :][: min(request.size or MOST, MOST)]
        client.burst = None
        if not portion:
            return _refused(request, Error.END_OF_FILE)
        after = request.offset + len(portion)
        if after < len(client.content):
            client.burst = replace(request, sequence=request.sequence + 1, offset=after)
            client.due = self._now + (len(portion) + AROUND) / SPEED
        return replace(_answered(request, portion), burst_complete=client.burst is None)

    def _unknown(self, request: Packet, sender: Sender) -> Packet:
        return _refused(request, Error.UNKNOWN_COMMAND)

    def _send(self, answer: Packet, sender: Sender) -> None:
        self._endpoint.send(message_of(answer, *sender))


def _answered(request: Packet, data: bytes = b"") -> Packet:
    return Packet(
        request.sequence + 1, Opcode.ACK, request.session, len(data), request.opcode, offset=request.offset, data=data
    )


def _refused(request: Packet, error: Error) -> Packet:
    return Packet(request.sequence + 1, Opcode.NAK, request.session, 1, request.opcode, data=bytes([error]))
