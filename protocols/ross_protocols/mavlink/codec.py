"""Values to bytes and bytes to values. No port, no clock, no threads.

An `Encoder` speaks for one component; a `Decoder` listens to one link. Bytes that are not MAVLink are skipped and
counted; a good frame behind them is found.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count
from typing import Any

from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import MESSAGES, ross
from ross_protocols.mavlink.message_map import LAYOUTS
from ross_protocols.mavlink.values import Severity, Text, Value

TEXT_SIZE = 50  # of one STATUSTEXT

_BY_VALUE = {layout.value: layout for layout in LAYOUTS}
_BY_ID = {layout.message.id: layout for layout in LAYOUTS}

_V1, _V2 = 0xFE, 0xFD
_OVERHEAD = {_V1: 8, _V2: 12}  # header and checksum [bytes]
_SIGNED, _SIGNATURE = 1, 13


@dataclass(frozen=True, slots=True)
class Packet:
    """A message that arrived, and from whom."""

    system_id: int
    component_id: int
    sequence: int
    name: str
    message: Any  # pymavlink's object
    frame: bytes  # as it came

    @property
    def sender(self) -> ComponentId:
        """Who has sent it."""
        return ComponentId(self.system_id, self.component_id)

    @property
    def value(self) -> Value | None:
        """The value of the message when it is one that we can say too."""
        layout = _BY_ID.get(self.message.get_msgId())
        return None if layout is None else layout.read(self.message)


class Encoder:
    """One component's frames: values and messages to MAVLink 2 frames with consecutive sequence numbers.

    >>> from ross_protocols.mavlink.values import Health, Heartbeat
    >>> encoder = Encoder(system_id=1, component_id=191)
    >>> [frame[4] for frame in (encoder.encode(Heartbeat(Health.ACTIVE, state=6)) for _ in range(3))]
    [0, 1, 2]

    With a key it signs.
    """

    def __init__(self, system_id: int, component_id: int, key: bytes | None = None, link_id: int = 0) -> None:
        self._mavlink = ross.MAVLink(None, srcSystem=system_id, srcComponent=component_id)
        self._mavlink.signing.secret_key = key
        self._mavlink.signing.link_id = link_id
        self._mavlink.signing.sign_outgoing = key is not None

    def encode(self, content: Any, timestamp: int = 0) -> bytes:
        """Return the frame of a value, or of one of pymavlink's messages; ``timestamp`` is for its signature.

        Raises
        ------
        struct.error
            When a number does not fit into its field.
        """
        self._mavlink.signing.timestamp = timestamp
        frame = bytes(message_of(content).pack(self._mavlink))
        self._mavlink.seq = (self._mavlink.seq + 1) % 256
        return frame


def message_of(content: Any) -> Any:
    """Return pymavlink's message of a value; a message is its own."""
    layout = _BY_VALUE.get(type(content))
    return content if layout is None else layout.write(content)


class Framer:
    """Finds what looks like a frame in a stream of bytes; ``skipped`` counts bytes that do not."""

    def __init__(self) -> None:
        self.buffer = bytearray()
        self.skipped = 0

    def size(self) -> int | None:
        """Skip to a marker; return the size of its frame when all of it is here."""
        buffer = self.buffer
        if buffer and buffer[0] not in _OVERHEAD:
            starts = (place for marker in (_V1, _V2) if (place := buffer.find(marker)) >= 0)
            self.skip(min(starts, default=len(buffer)))
        if len(buffer) < 3:
            return None
        marker = buffer[0]
        size = buffer[1] + _OVERHEAD[marker] + (_SIGNATURE if marker == _V2 and buffer[2] & _SIGNED else 0)
        return size if len(buffer) >= size else None

    def skip(self, count: int) -> None:
        """Drop bytes that belong to no frame."""
        del self.buffer[:count]
        self.skipped += count

    def whole(self, data: bytes) -> bytes:
        """Return the frames that ``data`` completes, one behind the other; keep the one that has begun."""
        self.buffer += data
        frames = bytearray()
        while (size := self.size()) is not None:
            frames += self.buffer[:size]
            del self.buffer[:size]
        return bytes(frames)


class Decoder:
    """What one link delivers: bytes in any portions to packets; MAVLink 1 and 2, our messages and the common ones.

    ``bad`` counts what began like a frame and was none, ``unknown`` frames of messages that nobody here knows;
    ``behind`` tells that the latest call left something for the next one.
    """

    def __init__(self) -> None:
        self._mavlink = ross.MAVLink(None)
        self._framer = Framer()
        self.bad = 0
        self.unknown = 0
        self.behind = False

    @property
    def skipped(self) -> int:
        """Bytes that belong to no frame."""
        return self._framer.skipped

    def feed(self, data: bytes, most: int | None = None) -> list[Packet]:
        """Return the packets that ``data`` completes; look at no more than ``most`` that may be one."""
        if not data and not self._framer.buffer and most != 0:  # as at most looks at a silent wire
            self.behind = False
            return []
        self._framer.buffer += data
        return list(self._packets(most))

    @property
    def waiting(self) -> bool:
        """Whether something that may be a frame has begun, and is kept until its rest comes."""
        return bool(self._framer.buffer)

    def settle(self) -> list[Packet]:
        """Wait no longer for the rest of a frame, because it was silent; return what stands behind its beginning.

        A damaged length promises more than ever comes: what follows, a stop perhaps, must not wait for it.
        """
        packets = self.feed(b"")
        while self.waiting:
            size = self._framer.size()
            if size is None:
                self.bad += 1
                self._framer.skip(1)
            else:  # nothing follows that could prove it wrong
                self.unknown += 1
                del self._framer.buffer[:size]
            packets += self.feed(b"")
        return packets

    def _packets(self, most: int | None) -> Iterator[Packet]:
        buffer = self._framer.buffer
        self.behind = True
        for _ in count() if most is None else range(most):
            size = self._framer.size()
            if size is None:
                break
            frame = buffer[:size]
            try:
                message = self._decode(frame)
            except ross.MAVError:  # it only looked like a frame: a true one may begin one byte later
                self.bad += 1
                self._framer.skip(1)
                continue
            if message is None and len(buffer) == size:
                break  # what follows tells whether it is a frame
            del buffer[:size]
            if message is None:
                self.unknown += 1
            else:
                yield Packet(
                    message.get_srcSystem(),
                    message.get_srcComponent(),
                    message.get_seq(),
                    message.get_type(),
                    message,
                    bytes(frame),
                )
        else:
            return
        self.behind = False

    def _decode(self, frame: bytearray) -> Any:
        if frame[0] == _V2 and frame[2] & ~_SIGNED:
            raise ross.MAVError("flags that change the format")
        number = frame[5] if frame[0] == _V1 else int.from_bytes(frame[7:10], "little")
        if number in MESSAGES:
            return self._mavlink.decode(frame)
        after = self._framer.buffer[len(frame) : len(frame) + 1]
        if after and after[0] not in _OVERHEAD:  # its checksum cannot be checked; what follows can
            raise ross.MAVError("not a frame")
        return None


def chunks(severity: Severity, text: str, number: int) -> list[Text]:
    """Split a text into what STATUSTEXT can carry; ``number`` (1 to 65535) ties the chunks together.

    A text whose last chunk is full is followed by an empty one, as MAVLink wants it.

    >>> [(part.id, part.chunk, len(part.text)) for part in chunks(Severity.INFO, "x" * 60, 7)]
    [(7, 0, 50), (7, 1, 10)]
    """
    if len(text) <= TEXT_SIZE:
        return [Text(severity, text)]
    parts = [text[start : start + TEXT_SIZE] for start in range(0, len(text) + 1, TEXT_SIZE)]
    return [Text(severity, part, number, index) for index, part in enumerate(parts)]
