"""The file server: files to be read over MAVLink FTP, a few in memory and, where asked for, recordings.

`on_packet` takes what arrives and `tick` the time, both on the thread of the pump. A client, a sender on one way, may
have several sessions, each with a number that it chooses and one open file. Of a session only what it has open, and
the last answer that took a while, is remembered, so that a request that comes twice is answered twice alike. Nothing
can be written.
"""

from __future__ import annotations

import logging
import math
import struct
from collections import OrderedDict
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import NamedTuple

from ross_payload.mavlink.component import Component, Received, Way
from ross_payload.mavlink.ftp_session import Content, InMemory, Session
from ross_payload.mavlink.recording_files import FOLDER, Recordings
from ross_payload.mavlink.router import LOCAL
from ross_payload.token_bucket import TokenBucket
from ross_payload.transport.async_task import begin
from ross_protocols.mavlink.component_id import ComponentId, target_of
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.ftp import MOST, Error, Opcode, Packet, checksum, message_of, packet_of

SESSIONS = 8  # that are served; then the oldest loses what it has open
LONGEST_BURST = 2.5  # [s]; who has gone costs no more, and pymavlink's client gives up 3.7 s after its last request
MOST_READS = 16  # portions of one session that wait to be read; what is more is as if lost
SPEED = 2700.0  # of a burst [bytes/s]: half of a line of 57600 baud
SHARE = 0.5  # of what a link may carry: telemetry has the rest
AT_ONCE = 8  # portions of files between two looks at the time: the thread has other things to do
UNSEEN = 0.04  # [s] between two looks, at most, that a link makes up for
AROUND = 27  # bytes of a frame beside the data
AGAIN = 3.0  # [s] in which the same request is one that came again
BURST, RATE = 40, 20.0  # requests at once, and [1/s]; what is more is as if lost
log = logging.getLogger(__name__)

_Job = Callable[[], Content | bytes]  # touches the disk


class _Key(NamedTuple):
    """A client, and the number of one of its sessions; ground stations with the same ids differ in the way."""

    way: Way
    client: ComponentId
    number: int


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
    claim
        Tells whether a link, by its URL, has room for a frame of so many bytes; true: sees to it that it gets it.
    """

    def __init__(
        self,
        component: Component,
        files: Mapping[str, bytes],
        recordings: Recordings | None = None,
        rates: Callable[[], Mapping[str, float]] = dict,
        passing: Callable[[], Mapping[str, bytes]] = dict,
        *,
        claim: Callable[[str, int, bool], bool] = lambda link, size, wait: True,
    ) -> None:
        self._component = component
        self._lasting = files
        self._passing = passing
        self._recordings = recordings
        self._rates = rates
        self._claim = claim
        self._sessions: OrderedDict[_Key, Session] = OrderedDict()
        self._bucket = TokenBucket(BURST, RATE)
        self._free: dict[str, float] = {}  # when a link may take the next portion [s]
        self._now = 0.0
        self._answers: dict[int, Callable[[Packet, _Key, Session], Packet | None]] = {
            Opcode.TERMINATE: self._close,
            Opcode.RESET: self._reset,
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
        key = _Key(received.way, sender, request.session)
        session = self._sessions.get(key) or Session(received.link)
        answer = self._answers.get(request.opcode, self._unknown)(request, key, session)
        if answer is not None:
            self._send(answer, sender, received.link)

    def tick(self, now: float) -> None:
        """Send what has come from the disk, and the portions of files that are due."""
        self._now = now
        left, full = AT_ONCE, set[str]()  # links without room for what is first in line
        for key, session in tuple(self._sessions.items()):
            if session.job is not None and session.job[1].done() and self._room_for(session.link, MOST):
                self._done(key, session)
            while left:
                request, content, link = session.next, session.content, session.link
                if request is None or content is None or link in full or self._rests(link):
                    break
                if not self._has_room(session, content, request):
                    full.add(link)
                    break
                answer = self._portion(session, content, request)
                if answer is None:
                    break
                left -= 1
                session.sent(request, answer)
                self._send(answer, key.client, link)
                self._sessions.move_to_end(key)  # the others first, the next time

    # ------------------------------------------------------------------------------------- open, list, check

    def _files(self) -> dict[str, bytes]:
        """Return the files in memory of this moment."""
        return {**self._lasting, **self._passing()}

    def _open(self, request: Packet, key: _Key, session: Session) -> Packet | None:
        name = _name(request)
        content = self._files().get(name)
        if content is not None:
            self._keep(key, session).open(InMemory(content), name)
            return _answered(request, struct.pack("<I", len(content)))
        recordings = self._recordings
        if recordings is None or not recordings.owns(name):
            return _refused(request, Error.FILE_NOT_FOUND)
        return self._begin(request, key, session, lambda: recordings.opened(name))

    def _list(self, request: Packet, key: _Key, session: Session) -> Packet | None:
        name, recordings = _name(request).strip("/"), self._recordings
        if not name:
            files = [f"F{each}\t{len(content)}".encode() for each, content in self._files().items()]
            return _listed(request, _entries([*files, b"D" + FOLDER.encode()], request.offset))
        if recordings is None or not recordings.owns(name):
            return _refused(request, Error.FILE_NOT_FOUND)
        return self._begin(request, key, session, lambda: _entries(recordings.entries(name), request.offset))

    def _check(self, request: Packet, key: _Key, session: Session) -> Packet | None:
        name, recordings = _name(request), self._recordings
        content = self._files().get(name)
        if content is not None:
            return _answered(request, struct.pack("<I", checksum(content)))
        if recordings is None or not recordings.owns(name):
            return _refused(request, Error.FILE_NOT_FOUND)
        return self._begin(request, key, session, lambda: struct.pack("<I", recordings.checksum(name)))

    def _begin(self, request: Packet, key: _Key, session: Session, job: _Job) -> Packet | None:
        """Ask the disk in the background; a request that comes again is answered again, or waited for."""
        if (
            session.last_answer is not None
            and session.last_answer[0] == request
            and self._now < session.last_answer[2] + AGAIN
        ):
            return session.last_answer[1]
        if session.job is None:  # one at a time: what comes meanwhile is as if lost
            self._keep(key, session).job = request, begin(job)
        return None

    def _done(self, key: _Key, session: Session) -> None:
        if session.job is None:
            return
        (request, job), session.job = session.job, None
        error = job.exception()
        if error is not None:
            answer = _refused(request, Error.FILE_NOT_FOUND)
        else:
            answer = self._answer(request, key, session, job.result())
        session.last_answer = request, answer, self._now
        self._spend(session.link, len(answer.data) + AROUND)
        self._send(answer, key.client, session.link)

    def _answer(self, request: Packet, key: _Key, session: Session, found: Content | bytes) -> Packet:
        if isinstance(found, bytes):
            return _listed(request, found) if request.opcode == Opcode.LIST else _answered(request, found)
        session.open(found, _name(request))
        size = f"{found.size / 1e6:.1f} MB"
        log.info("MAVLink FTP: %d/%d reads %s (%s) over %s", *key.client, session.name, size, session.link)
        return _answered(request, struct.pack("<I", found.size))

    def _close(self, request: Packet, key: _Key, session: Session) -> Packet:
        self._sessions.pop(key, None)
        return _answered(request)

    def _reset(self, request: Packet, key: _Key, session: Session) -> Packet:
        for each in [other for other in self._sessions if other[:2] == key[:2]]:
            del self._sessions[each]
        return _answered(request)

    # ------------------------------------------------------------------------------------- read

    def _read(self, request: Packet, key: _Key, session: Session) -> Packet | None:
        """Answer with a portion, or put it in line; the portions of a burst follow in time.

        A burst goes on beside single portions: clients ask for the gaps while it comes. Its end is put off when
        a client asks for what follows the portions that have come.
        """
        if session.content is None:
            return _refused(request, Error.INVALID_SESSION)
        at_once = isinstance(session.content, InMemory) and self._has_room(session, session.content, request)
        if request.opcode == Opcode.BURST_READ:
            session.ends = self._now + LONGEST_BURST
            if session.goes_on(request):
                return None
            session.burst = request
            answer = self._portion(session, session.content, request) if at_once else None
            if answer is not None:
                session.sent(request, answer)
            return answer
        if request.size > MOST:
            return _refused(request, Error.INVALID_DATA_SIZE)
        if at_once:
            self._sessions.move_to_end(key)
            return self._portion(session, session.content, request)
        session.put_in_line(request, MOST_READS)  # in the time of its link
        return None

    def _has_room(self, session: Session, content: Content, request: Packet) -> bool:
        """Tell whether a portion has room on its link."""
        return self._room_for(session.link, min(request.size or MOST, MOST, max(content.size - request.offset, 1)))

    def _room_for(self, link: str, size: int) -> bool:
        """Tell whether a link has room for so many bytes; where their share allows it, telemetry leaves it to them."""
        return self._claim(link, AROUND + size, not self._rests(link))

    def _rests(self, link: str) -> bool:
        """Tell whether files have had their share of a link for now."""
        return self._now < self._free.get(link, -math.inf)

    def _portion(self, session: Session, content: Content, request: Packet) -> Packet | None:
        """Return the answer to a request for a portion; None: the disk has not given it yet."""
        try:
            portion = content.read(request.offset, min(request.size or MOST, MOST))
        except OSError:
            return _refused(request, Error.FAIL)
        if portion is None:
            return None
        if not portion:
            return _refused(request, Error.END_OF_FILE)
        disk = self._recordings is not None and not isinstance(session.content, InMemory)
        most = self._recordings.speed if disk and self._recordings is not None else SPEED
        self._spend(session.link, len(portion) + AROUND, most)
        complete = request.offset + len(portion) >= content.size or self._now >= session.ends
        return replace(_answered(request, portion), burst_complete=request.opcode == Opcode.BURST_READ and complete)

    def _spend(self, link: str, size: int, most: float = math.inf) -> None:
        """Let a link rest for as long as telemetry needs after so many bytes; ``most`` is a speed [bytes/s].

        What was sent while it rests has taken only what telemetry left, and keeps nobody from his share.
        """
        if self._rests(link):
            return
        speed = min(most, SHARE * self._rates().get(link, math.inf))
        self._free[link] = max(self._free.get(link, -math.inf), self._now - UNSEEN) + size / speed

    # ------------------------------------------------------------------------------------- sessions

    def _keep(self, key: _Key, session: Session) -> Session:
        """Remember a session; the one that was served longest ago makes room."""
        self._sessions[key] = session
        self._sessions.move_to_end(key)
        if len(self._sessions) > SESSIONS:
            self._sessions.popitem(last=False)
        return session

    def _unknown(self, request: Packet, key: _Key, session: Session) -> Packet:
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
    """Return a NAK; pymavlink's client takes one that does not name the offset of its request for an old one."""
    return Packet(
        request.sequence + 1, Opcode.NAK, request.session, 1, request.opcode, offset=request.offset, data=bytes([error])
    )
