"""The owner of every MAVLink port: one ear and one voice per link.

What is sent goes out on every link; what arrives is decoded per link. Nothing here waits.
"""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import ExitStack
from dataclasses import dataclass
from types import TracebackType
from typing import Self

from ross_payload.links.address import parse
from ross_payload.links.ports import Counts, LinkPort, open_port
from ross_protocols.codec import Decoder, Packet

__all__ = ["Counts", "Heard", "LinkPort", "Links", "open_port", "parse"]


@dataclass(frozen=True, slots=True)
class Heard:
    """A packet and the link that it came from."""

    url: str
    packet: Packet


@dataclass(frozen=True, slots=True)
class _Link:
    url: str
    port: LinkPort
    decoder: Decoder


class Links:
    """All links of the payload, for one thread. A context manager.

    >>> with Links.open([]) as links:
    ...     links.send(b"to nobody")
    ...     links.poll()
    []
    """

    def __init__(self, ports: Iterable[tuple[str, LinkPort]]) -> None:
        self._links = [_Link(url, port, Decoder()) for url, port in ports]

    @classmethod
    def open(cls, urls: Iterable[str]) -> Self:
        """Open every URL, or none.

        Raises
        ------
        ConfigError
            When a URL is malformed: before any is opened.
        LinkError
            When a port cannot be opened; those before it are closed again.
        """
        urls = list(urls)
        for url in urls:
            parse(url)
        with ExitStack() as stack:
            ports = []
            for url in urls:
                port = open_port(url)
                stack.callback(port.close)
                ports.append((url, port))
            stack.pop_all()
        return cls(ports)

    def send(self, frame: bytes) -> None:
        """Send one frame on every link."""
        for link in self._links:
            link.port.send(frame)

    def poll(self) -> list[Heard]:
        """Return what has arrived on all links, in the order of their opening."""
        return [
            Heard(link.url, packet)
            for link in self._links
            for data in link.port.receive()
            for packet in link.decoder.feed(data)
        ]

    def counts(self) -> list[tuple[str, Counts]]:
        """Return what went through every link."""
        return [(link.url, link.port.counts) for link in self._links]

    def close(self) -> None:
        """Close every link; idempotent."""
        for link in self._links:
            link.port.close()

    def __enter__(self) -> Self:
        """Links are open from the start."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close every link."""
        self.close()
