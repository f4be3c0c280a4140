"""From a URL to an open port."""

from __future__ import annotations

import os
import socket

from ross_payload.errors import ConfigError, LinkError
from ross_payload.interfaces import Clock
from ross_payload.links.address import Serial, Tcp, Udp, parse
from ross_payload.links.ports import LinkPort
from ross_payload.links.stream import StreamPort
from ross_payload.links.tcp import CONNECT_TIMEOUT, TcpOpener, open_server, prepared
from ross_payload.links.uart import SerialOpener
from ross_payload.links.udp import PatientUdpPort, open_udp


def open_port(url: str, clock: Clock, *, patient: bool = False) -> LinkPort:
    """Open the port of a URL; a ``patient`` one goes on trying when the other side is not there yet.

    Raises
    ------
    ConfigError
        When the URL is malformed or needs an extra that is missing.
    LinkError
        When the port cannot be opened, in one line.
    """
    address = parse(url)
    try:
        match address:
            case Udp(listen=False) if patient:
                return PatientUdpPort(address, clock)
            case Udp():
                return open_udp(address)
            case Tcp(listen=True):
                return open_server(address)
            case Tcp():
                return _client(address, clock, patient)
            case Serial():
                return _line(address, clock, patient)
    except OSError as error:  # pyserial's errors and name resolution are OSErrors too
        reason = os.strerror(error.errno) if error.errno and error.errno > 0 else error.strerror or str(error)
        raise LinkError(f"link '{url}' cannot be opened: {reason}") from error
    except ValueError as error:  # a name or a baud rate that the system cannot take
        raise ConfigError(f"link '{url}': {error}") from error


def _client(address: Tcp, clock: Clock, patient: bool) -> StreamPort:
    if patient:
        return StreamPort(TcpOpener(address), clock)
    sock = socket.create_connection((address.host, address.port), timeout=CONNECT_TIMEOUT)
    return StreamPort(TcpOpener(address), clock, prepared(sock))


def _line(address: Serial, clock: Clock, patient: bool) -> StreamPort:
    opener, handle = SerialOpener(address), None
    try:
        handle = opener.poll(clock.now())
    except OSError:
        if not patient:
            raise
    return StreamPort(opener, clock, handle)
