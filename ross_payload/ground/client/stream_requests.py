"""What a payload is asked about live listening, by scripts: streams, their session descriptions, enrolment."""

from __future__ import annotations

import asyncio
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any

from ross_payload.ground.client.command_status import CommandStatus
from ross_payload.ground.client.command_types import Order
from ross_payload.ground.client.events import AudioStream, SourceEstimate
from ross_payload.ground.client.ftp_client import FileReader
from ross_payload.ground.client.order_json import order_of
from ross_payload.ground.client.stream_orders import Enrol, StopStream, Stream, is_shown
from ross_payload.ground.client.streams import NOT_OPEN, Wakeup
from ross_payload.ground.errors import LinkLost, RefusedByPayload
from ross_payload.ground.model.payload_state import PayloadState
from ross_protocols.mavlink.codec import Packet
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.stream_values import description_file

STREAM_TIMEOUT_S = 6.0  # for a stream to be announced: a link may lose it, and it is repeated every 5 s


class StreamRequests(ABC):
    """The part of a `Payload` that is about live listening; ``send`` sends to it, ``us`` are our ids."""

    _state: PayloadState

    def __init__(self, send: Callable[[Any], None], who: ComponentId, us: ComponentId) -> None:
        self._changed = Wakeup(NOT_OPEN)
        self._send_to, self._who, self._us = send, who, us
        self._one_stream_order = asyncio.Lock()  # of two at once nobody could tell which one was refused
        self._one_file = asyncio.Lock()  # the payload has one open for us
        self._reader: FileReader | None = None
        self._sequence = 0  # of the last request for a file

    @abstractmethod
    async def request(self, order: Order) -> CommandStatus:
        """Send a command and wait until it is done."""

    @abstractmethod
    def _reads_files(self) -> bool:
        """Tell whether something else reads files from the payload."""

    async def stream(
        self,
        what: str | None = None,
        which: float | SourceEstimate = 0,
        *,
        to: tuple[str, int] | None = None,
        codec: str = "",
        gain_db: float | None = None,
        muted: bool | None = None,
        number: int | None = None,
    ) -> AudioStream | None:
        """Let somebody listen, live, or change a stream; return it as announced, None: no announcement came.

        ``what`` is "target", "mixture", "source" (``which``: its index) or "azimuth" (``which``: degrees). ``to`` is
        the IPv4 address and port of one computer, as the payload reaches it; RTP goes there, as ``codec`` "opus" or
        "L16". A stream is known by its ``number``, or by where it goes. What is not given stays as it is.

        Raises
        ------
        ValueError
            When the address is no unicast address, or something else cannot be meant.
        """
        index = which.source if isinstance(which, SourceEstimate) else which
        goes_to = {} if to is None else dict(zip(("address", "port"), _pair(to), strict=True))
        order = order_of(
            {"kind": "stream", "stream": number, "what": what, what or "source": index, "codec": codec}
            | goes_to
            | {"gain": gain_db, "muted": muted}
        )
        async with self._one_stream_order:
            await self.request(order)
        return await self._changed.within(STREAM_TIMEOUT_S, lambda: self._showing(order))

    def _showing(self, order: Order) -> AudioStream | None:
        """Return the stream that is as it was ordered; None: there is none yet."""
        return next((each for each in self.streams if isinstance(order, Stream) and is_shown(order, each)), None)

    async def stop_stream(self, number: int | None = None, *, to: tuple[str, int] | None = None) -> None:
        """End a stream, by its number or by the address and port that it goes ``to``; without either, all of them.

        Raises
        ------
        ValueError
            When both are given, or the address is no unicast address.
        """
        address, port = ("", 0) if to is None else _pair(to)
        if to is not None and not address:
            raise ValueError("address: expected IPv4, got none")  # which would end all
        order = StopStream(number, address, port)
        async with self._one_stream_order:
            await self.request(order)

    async def enrol(
        self,
        source: int | SourceEstimate | None = None,
        *,
        azimuth_deg: float | None = None,
        consent: bool,
        voice: int = 0,
        duration_s: float = 0.0,
    ) -> None:
        """Enrol the talker at a source or an azimuth, who has agreed to it (``consent``), as talker-``voice``.

        Without ``voice`` it is the lowest number that is free; without ``duration_s`` as long as the payload's
        configuration says.
        """
        index = source.source if isinstance(source, SourceEstimate) else source
        await self.request(Enrol(index, azimuth_deg, duration_s, consent, voice))

    async def session_description(self, number: int) -> str:
        """Return the session description (SDP) of a stream, which players want; it is read over MAVLink FTP.

        Raises
        ------
        RefusedByPayload
            When the stream has none.
        LinkLost
            When nothing answers.
        """
        name = f"/{description_file(number)}"
        self._changed.check_open(f"session description of stream {number}")
        async with self._one_file:
            await self._changed.until(lambda: not self._reads_files())
            reader = self._reader = FileReader(self._send_to, self._who, self._us, name, self._sequence)
            try:
                await self._changed.until(lambda: reader.over)
            finally:
                self._reader, self._sequence = None, reader.sequence
        if reader.content is None:
            kind = LinkLost if reader.unanswered else RefusedByPayload
            raise kind(f"session description of stream {number}", reader.trouble)
        return reader.content.decode("utf-8", "replace")

    def _read_files(self, now: float) -> bool:
        """Go on with the file that is read; tell whether there is one."""
        if self._reader is not None:
            self._reader.tick(now)
        return self._reader is not None

    def _on_file_packet(self, packet: Packet, now: float) -> None:
        if self._reader is not None:
            self._reader.on_packet(packet, now)

    @property
    def streams(self) -> tuple[AudioStream, ...]:
        """The streams of live listening, also those that have ended."""
        return tuple(map(AudioStream.of, self._state.streams))


def _pair(to: tuple[str, int]) -> tuple[str, int]:
    """Return the address and the port where a stream goes.

    Raises
    ------
    ValueError
        When it is no such pair.
    """
    if not isinstance(to, tuple | list) or len(to) != 2:
        raise ValueError(f'to: expected an address and a port as in ("192.168.1.20", 5004), got {to!r}')
    return to[0], to[1]
