"""From a URL to an open port."""

from __future__ import annotations

import socket
from collections.abc import Callable

from ross_payload.errors import ConfigError, LinkError, reason
from ross_payload.transport.byte_stream import ReconnectingStream
from ross_payload.transport.link_url import Address, Serial, Tcp, Udp, parse
from ross_payload.transport.ports import DEFAULTS, PortOptions
from ross_payload.transport.serial_port import SerialOpener
from ross_payload.transport.tcp import TcpOpener, TcpServer, open_listeners, prepared
from ross_payload.transport.udp import UdpPeer, UdpServer, open_udp

Server = UdpServer | TcpServer  # anybody can speak to it: it tells its peers apart, and may answer only some
OpenPort = UdpPeer | ReconnectingStream | Server


def open_port(
    url: str, now: Callable[[], float], *, patient: bool = False, options: PortOptions = DEFAULTS
) -> OpenPort:
    """Open the port of a URL; a ``patient`` one goes on trying when the other side is not there yet.

    ``now`` tells the time [s].

    Raises
    ------
    ConfigError
        When the URL is malformed or needs an extra that is missing.
    LinkError
        When the port cannot be opened, in one line.
    """
    address = parse(url)
    try:
        return _opened(address, now, patient, options)
    except OSError as error:  # pyserial's errors and name resolution are OSErrors too
        raise LinkError(f"link '{url}' cannot be opened: {reason(error)}") from error
    except ValueError as error:  # a name or a baud rate that the system cannot take
        raise ConfigError(f"link '{url}': {error}") from error


def _opened(address: Address, now: Callable[[], float], patient: bool, options: PortOptions) -> OpenPort:
    match address:
        case Udp(listen=True):
            return UdpServer(open_udp(address), now)
        case Udp():
            return UdpPeer(address, now, None if patient else open_udp(address), options)
        case Tcp(listen=True):
            return TcpServer(open_listeners(address), options)
        case Tcp():
            return _client(address, now, patient, options)
        case Serial():
            return _line(address, now, patient, options)


def _client(address: Tcp, now: Callable[[], float], patient: bool, options: PortOptions) -> ReconnectingStream:
    if patient:
        return ReconnectingStream(TcpOpener(address, options), now, None, options)
    sock = socket.create_connection((address.host, address.port), timeout=options.connect_timeout_s)
    return ReconnectingStream(TcpOpener(address, options), now, prepared(sock, options), options)


def _line(address: Serial, now: Callable[[], float], patient: bool, options: PortOptions) -> ReconnectingStream:
    opener, handle = SerialOpener(address), None
    try:
        handle = opener.poll(now())
    except (OSError, ValueError):
        if not patient:
            raise
    return ReconnectingStream(opener, now, handle, options)
