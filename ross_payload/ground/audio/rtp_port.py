"""A UDP port of this computer that plays one stream of RTP, on the loop of the ground station."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any, Self, cast

from ross_payload.errors import refused_as
from ross_payload.ground.errors import GroundError
from ross_payload.interfaces import Samples
from ross_payload.plugins import install_line

PERIOD_S = 0.02  # between two answers to the sender


class RtpPort(asyncio.DatagramProtocol):
    """Open from `open` to `close`.

    Parameters
    ----------
    rate
        Wanted of the samples [Hz]; what Opus does not know becomes 48 kHz.
    now, wall
        Tell the time [s], and that since 1970 [s].

    Raises
    ------
    GroundError
        When what decodes is not installed.
    """

    def __init__(self, rate: int, now: Callable[[], float], wall: Callable[[], float]) -> None:
        try:
            from ross_payload.transport.rtp.receiver import RtpReceiver  # noqa: PLC0415 - an extra
            from ross_payload.transport.rtp.session_description import OPUS, Media  # noqa: PLC0415
        except ModuleNotFoundError as error:
            raise GroundError(
                f"listening needs {str(error.name).partition('.')[0]}: {install_line('stream')}"
            ) from error
        self.receiver = RtpReceiver(Media.of(OPUS, rate))
        self.codec = OPUS
        self._now, self._wall = now, wall
        self._transport: asyncio.DatagramTransport | None = None
        self._answering: asyncio.Task[None] | None = None

    @property
    def rate(self) -> int:
        """Of the samples [Hz]."""
        return self.receiver.rate

    @property
    def place(self) -> tuple[str, int]:
        """Where it listens: address and port."""
        if self._transport is None:
            raise RuntimeError("the port is not open")
        host, port = self._transport.get_extra_info("sockname")[:2]
        return str(host), int(port)

    async def open(self, host: str) -> Self:
        """Listen at an address of this computer, on a free port.

        Raises
        ------
        GroundError
            When that is none.
        """
        loop = asyncio.get_running_loop()
        with refused_as(GroundError, f"cannot listen at {host}"):
            transport, _ = await loop.create_datagram_endpoint(lambda: self, local_addr=(host, 0))
        self._transport = transport
        self._answering = loop.create_task(self._answer())
        return self

    def close(self) -> None:
        """Listen no more; idempotent."""
        if self._answering is not None:
            self._answering.cancel()
        if self._transport is not None:
            self._transport.close()

    def datagram_received(self, data: bytes, addr: Any) -> None:
        """Take what has arrived."""
        self.receiver.on_datagram(data, self._now(), addr)

    def error_received(self, exc: Exception) -> None:
        """Pay no attention to the news that nobody takes the answers."""

    def read(self, n: int) -> tuple[Samples, float | None]:
        """Return the next ``n`` samples, (n,), and how long ago the first was at the microphone [s], where known."""
        samples = self.receiver.read(n, self._now())
        age = self.receiver.total_delay(self._wall())
        return samples, None if age is None else age + n / self.rate

    async def _answer(self) -> None:
        """Tell the sender what came and what is wanted once more, until cancelled."""
        while True:
            for answer in self.receiver.feedback(self._now()):
                if self._transport is not None:
                    self._transport.sendto(answer, cast("tuple[str, int]", self.receiver.sender))
            await asyncio.sleep(PERIOD_S)
