"""The file server: files to be read over MAVLink FTP, a few in memory and, where asked for, recordings.

`on_packet` takes what arrives and `tick` the time, both on the thread of the pump. Of a client only what it has open,
and the last answer that took a while, is remembered, so that a request that comes twice is answered twice alike.
Nothing can be written.
"""

from __future__ import annotations

import logging
import math
import struct
from collections import OrderedDict
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from dataclasses import dataclass, replace
from typing import Protocol

from ross_payload.mavlink.component import Component, Received
from ross_payload.mavlink.recording_files import FOLDER, Recordings
from ross_payload.mavlink.router import LOCAL
from ross_payload.token_bucket import TokenBucket
from ross_payload.transport.async_task import begin
from ross_protocols.mavlink.component_id import ComponentId, target_of
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.ftp import MOST, Error, Opcode, Packet, checksum, message_of, packet_of

CLIENTS = 8  # that are served; then the oldest loses what it has open
SPEED = 2700.0  # of a burst [bytes/s]: half of a line of 57600 baud
SHARE = 0.5  # of what a link may carry: telemetry has the rest
AT_ONCE = 8  # portions of a file to one client between two looks at the time
AROUND = 24  # bytes of a frame beside the data
AGAIN = 3.0  # [s] in which the same request is one that came again
BURST, RATE = 40, 20.0  # requests at once, and [1/s]; what is more is as if lost
log = logging.getLogger(__name__)


class Content(Protocol):
    """What a client has open."""

    @property
    def size(self) -> int:
        """Its length [bytes]."""

    def read(self, offset: int, size: int) -> bytes | None:
        """Return a portion, empty behind the end; None: ask again later."""


@dataclass(frozen=True, slots=True)
class _InMemory:
    """A file in memory."""

    content: bytes

    @property
    def size(self) -> int:
        """Its length [bytes]."""
        return len(self.content)

    def read(self, offset: int, size: int) -> bytes:
        """Return a portion, empty behind the end."""
        return self.content[offset:][:size]


_Job = Callable[[], Content | bytes]  # touches the disk


@dataclass(slots=True)
class _Client:
    """What a client has open, and what it waits for."""

    link: str
    content: Content | None = None
    name: str = ""  # of the content, as it was asked for
    waiting: Packet | None = None  # the next portion, as a request
    job: tuple[Packet, Future[Content | bytes]] | None = None  # what it asks of the disk
    last_answer: tuple[Packet, Packet, float] | None = None  # the last request to the disk, its answer, when [s]


class FtpServer:
    """Lets clients read files from our component.

    Parameters
    ----------
    component
        Ours.
    files
        By name, in memory.
    recordings
        Are offered, too; None: they are not.
    rates
        Tells what every link may carry [bytes/s].
    passing
        Tells which files there are beside these at present, by name.
    """

    def __init__(
        self,
        component: Component,
        files: Mapping[str, bytes],
        recordings: Recordings | None = None,
        rates: Callable[[], Mapping[str, float]] = dict,
        passing: Callable[[], Mapping[str, bytes]] = dict,
    ) -> None:
        self._component = component
        self._lasting = files
        self._passing = passing
        self._recordings = recordings
        self._rates = rates
        self._clients: OrderedDict[ComponentId, _Client] = OrderedDict()
        self._bucket = TokenBucket(BURST, RATE)
        self._free: dict[str, float] = {}  # when a link may take the next portion [s]
        self._now = 0.0
        self._answers: dict[int, Callable[[Packet, ComponentId, _Client], Packet | None]] = {
            Opcode.TERMINATE: self._close,
            Opcode.RESET: self._close,
            Opcode.OPEN_RO: self._open,
            Opcode.READ: self._read,
            Opcode.BURST_READ: self._read,
        }
        if recordings is not None:
            self._answers |= {Opcode.LIST: self._list, Opcode.CRC32: self._check}
        component.subscribe(self.on_packet, common.MAVLINK_MSG_ID_FILE_TRANSFER_PROTOCOL)

    def on_packet(self, received: Received) -> None:
        """Take a packet; what is no request for us passes by."""
        message, sender = received.packet.message, received.packet.sender
        request = packet_of(message)
        if request is None or not received.may_order or target_of(message) != self._component.id:
            return
        if request.opcode in (Opcode.ACK, Opcode.NAK) or not self._bucket.spend(self._now):
            return
        client = self._clients.get(sender) or _Client(received.link)
        client.link = received.link
        answer = self._answers.get(request.opcode, self._unknown)(request, sender, client)
        if answer is not None:
            self._send(answer, sender, received.link)

    def tick(self, now: float) -> None:
        """Send what has come from the disk, and the portions of files that are due."""
        self._now = now
        for sender, client in tuple(self._clients.items()):
            if client.job is not None and client.job[1].done():
                self._done(sender, client)
            for _ in range(AT_ONCE):
                if client.waiting is None or now < self._free.get(client.link, -math.inf):
                    break
                answer = self._portion(client, client.waiting)
                if answer is None:
                    break
                self._send(answer, sender, client.link)
                self._clients.move_to_end(sender)  # the others first, the next time

    # ------------------------------------------------------------------------------------- open, list, check

    def _files(self) -> dict[str, bytes]:
        """Return the files in memory of this moment."""
        return {**self._lasting, **self._passing()}

    def _open(self, request: Packet, sender: ComponentId, client: _Client) -> Packet | None:
        name = _name(request)
        content = self._files().get(name)
        if content is not None:
            self._keep(sender, client).content = _InMemory(content)
            client.waiting, client.name = None, name
            return _answered(request, struct.pack("<I", len(content)))
        recordings = self._recordings
        if recordings is None or not recordings.owns(name):
            return _refused(request, Error.FILE_NOT_FOUND)
        return self._begin(request, sender, client, lambda: recordings.opened(name))

    def _list(self, request: Packet, sender: ComponentId, client: _Client) -> Packet | None:
        name, recordings = _name(request).strip("/"), self._recordings
        if not name:
            files = [f"F{each}\t{len(content)}".encode() for each, content in self._files().items()]
            return _listed(request, _entries([*files, b"D" + FOLDER.encode()], request.offset))
        if recordings is None or not recordings.owns(name):
            return _refused(request, Error.FILE_NOT_FOUND)
        return self._begin(request, sender, client, lambda: _entries(recordings.entries(name), request.offset))

    def _check(self, request: Packet, sender: ComponentId, client: _Client) -> Packet | None:
        name, recordings = _name(request), self._recordings
        content = self._files().get(name)
        if content is not None:
            return _answered(request, struct.pack("<I", checksum(content)))
        if recordings is None or not recordings.owns(name):
            return _refused(request, Error.FILE_NOT_FOUND)
        return self._begin(request, sender, client, lambda: struct.pack("<I", recordings.checksum(name)))

    def _begin(self, request: Packet, sender: ComponentId, client: _Client, job: _Job) -> Packet | None:
        """Ask the disk in the background; a request that comes again is answered again, or waited for."""
        if (
            client.last_answer is not None
            and client.last_answer[0] == request
            and self._now < client.last_answer[2] + AGAIN
        ):
            return client.last_answer[1]
        if client.job is None:  # one at a time: what comes meanwhile is as if lost
            self._keep(sender, client).job = request, begin(job)
        return None

    def _done(self, sender: ComponentId, client: _Client) -> None:
        if client.job is None:
            return
        (request, job), client.job = client.job, None
        error = job.exception()
        if error is not None:
            answer = _refused(request, Error.FILE_NOT_FOUND)
        else:
            answer = self._answer(request, sender, client, job.result())
        client.last_answer = request, answer, self._now
        self._send(answer, sender, client.link)

    def _answer(self, request: Packet, sender: ComponentId, client: _Client, found: Content | bytes) -> Packet:
        if isinstance(found, bytes):
            return _listed(request, found) if request.opcode == Opcode.LIST else _answered(request, found)
        client.content, client.waiting, client.name = found, None, _name(request)
        size = f"{found.size / 1e6:.1f} MB"
        log.info("MAVLink FTP: %d/%d reads %s (%s) over %s", *sender, client.name, size, client.link)
        return _answered(request, struct.pack("<I", found.size))

    def _close(self, request: Packet, sender: ComponentId, client: _Client) -> Packet:
        self._clients.pop(sender, None)
        return _answered(request)

    # ------------------------------------------------------------------------------------- read

    def _read(self, request: Packet, sender: ComponentId, client: _Client) -> Packet | None:
        """Answer with a portion; of a burst the others follow in time."""
        if client.content is None:
            return _refused(request, Error.INVALID_SESSION)
        if request.opcode == Opcode.READ and request.size > MOST:
            return _refused(request, Error.INVALID_DATA_SIZE)
        if isinstance(client.content, _InMemory):
            return self._portion(client, request)
        client.waiting = request  # in the time of its link
        return None

    def _portion(self, client: _Client, request: Packet) -> Packet | None:
        """Return the answer to a request for a portion; None: the disk has not given it yet."""
        if client.content is None:
            client.waiting = None
            return _refused(request, Error.INVALID_SESSION)
        try:
            portion = client.content.read(request.offset, min(request.size or MOST, MOST))
        except OSError:
            client.waiting = None
            return _refused(request, Error.FAIL)
        if portion is None:
            return None
        client.waiting = None
        if not portion:
            return _refused(request, Error.END_OF_FILE)
        self._spend(client, len(portion) + AROUND)
        if request.opcode == Opcode.READ:
            return _answered(request, portion)
        after = request.offset + len(portion)
        if after < client.content.size:
            client.waiting = replace(request, sequence=request.sequence + 1, offset=after)
        return replace(_answered(request, portion), burst_complete=client.waiting is None)

    def _spend(self, client: _Client, size: int) -> None:
        """Let a link rest for as long as telemetry needs after so many bytes."""
        disk = self._recordings is not None and not isinstance(client.content, _InMemory)
        most = self._recordings.speed if disk and self._recordings is not None else SPEED
        speed = min(most, SHARE * self._rates().get(client.link, math.inf))
        self._free[client.link] = max(self._now, self._free.get(client.link, self._now)) + size / speed

    # ------------------------------------------------------------------------------------- clients

    def _keep(self, sender: ComponentId, client: _Client) -> _Client:
        """Remember a client; the one that was served longest ago makes room."""
        self._clients[sender] = client
        self._clients.move_to_end(sender)
        if len(self._clients) > CLIENTS:
            self._clients.popitem(last=False)
        return client

    def _unknown(self, request: Packet, sender: ComponentId, client: _Client) -> Packet:
        return _refused(request, Error.UNKNOWN_COMMAND)

    def _send(self, answer: Packet, sender: ComponentId, link: str) -> None:
        self._component.send(message_of(answer, sender), None if link == LOCAL else link)


def _name(request: Packet) -> str:
    return request.data.split(b"\0")[0].decode("ascii", "replace").lstrip("/")


def _entries(entries: list[bytes], offset: int) -> bytes:
    """Return as many entries of a folder, from one on, as one answer takes; empty: there are no more."""
    portion = b""
    for entry in entries[offset:]:
        if len(portion) + len(entry) + 1 > MOST:
            break
        portion += entry + b"\0"
    return portion


def _listed(request: Packet, portion: bytes) -> Packet:
    return _answered(request, portion) if portion else _refused(request, Error.END_OF_FILE)


def _answered(request: Packet, data: bytes = b"") -> Packet:
    return Packet(
        request.sequence + 1, Opcode.ACK, request.session, len(data), request.opcode, offset=request.offset, data=data
    )


def _refused(request: Packet, error: Error) -> Packet:
    return Packet(request.sequence + 1, Opcode.NAK, request.session, 1, request.opcode, data=bytes([error]))
