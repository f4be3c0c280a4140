"""A CAN bus as a wire: behind any interface of python-can, or over TCP in another process."""

from __future__ import annotations

import re
import socket
from contextlib import suppress
from itertools import islice
from typing import Any

import can

from ross_payload.actuators.wires import connect, served_at
from ross_payload.actuators.wires.codecs import CanCodec
from ross_payload.errors import ConfigError, LinkError, reason
from ross_payload.interfaces import Clock, Port
from ross_protocols.can import CanFrame

_URL = re.compile(r"can:(?P<interface>[a-z0-9_]+):(?P<channel>[^:]+)(:(?P<bitrate>\d{4,8}))?")
_HUB = re.compile(r"can:socketcand:(?P<host>[^:\[\]]+):(?P<port>\d{1,5})(:(?P<channel>[A-Za-z0-9_.-]{1,16}))?")
CHANNEL = "can0"  # of a socketcand server, unless told
GREETING_TIMEOUT_S = 5.0  # [s]: so long a socketcand server may be silent; its computer may be busy
MAX_FRAMES_PER_READ = 1000  # frames of one look at the bus
MAX_REFUSED_FRAMES = 10  # with frames that the bus does not take


class CanPort:
    """The frames of a bus; a frame that the bus does not take is lost, ten in a row are an error."""

    def __init__(self, bus: can.BusABC, url: str) -> None:
        self._bus = bus
        self._url = url
        self._refused = 0
        self._open = True

    def send(self, frame: Any) -> None:
        """Send one frame.

        Raises
        ------
        LinkError
            When the bus has taken none for a while.
        """
        message = can.Message(arbitration_id=frame.id, data=frame.data, is_extended_id=frame.extended)
        try:
            self._bus.send(message)
            self._refused = 0
        except (can.CanError, OSError) as error:
            self._refused += 1
            if self._refused >= MAX_REFUSED_FRAMES:
                raise LinkError(f"wire '{self._url}' takes no frames: {_why(error)}") from error

    def receive(self) -> list[Any]:
        """Return the frames that have arrived; error, remote and FD frames are left out.

        Raises
        ------
        LinkError
            When the bus is down.
        """
        try:
            arrived = list(islice(iter(self._next, None), MAX_FRAMES_PER_READ))
        except (can.CanError, OSError) as error:
            raise LinkError(f"wire '{self._url}' is down: {_why(error)}") from error
        return [
            CanFrame(each.arbitration_id, bytes(each.data), each.is_extended_id) for each in arrived if _is_data(each)
        ]

    def _next(self) -> can.Message | None:
        """Return the next frame that has arrived, of a bus without filters.

        It is what `recv` calls, which waits on a silent bus for as long as the system's clock is set back meanwhile.
        """
        return self._bus._recv_internal(0)[0]

    def close(self) -> None:
        """Leave the bus; idempotent."""
        if self._open:
            self._open = False
            with suppress(can.CanError, OSError):  # a bus that is gone cannot be left
                self._bus.shutdown()


def _is_data(message: can.Message) -> bool:
    return not (message.is_error_frame or message.is_remote_frame or message.is_fd)


class CanWire:
    """The scheme ``can``."""

    def open(self, url: str, clock: Clock) -> Port:
        """Join a bus.

        Raises
        ------
        ConfigError
            When the URL is malformed or its interface unknown.
        LinkError
            When the bus cannot be joined.
        """
        if url.startswith("can:tcp:"):
            return connect(url, CanCodec(), clock)
        if url.startswith("can:socketcand:"):
            return _at_hub(url)
        return _joined(url, _bus_of(url))

    def check(self, url: str) -> None:
        """Refuse a URL that is malformed, or whose interface is unknown.

        Raises
        ------
        ConfigError
            When it is one.
        """
        if url.startswith("can:tcp:"):
            served_at(url)
        elif url.startswith("can:socketcand:"):
            _hub_of(url)
        else:
            _bus_of(url)


def _hub_of(url: str) -> re.Match[str]:
    found = _HUB.fullmatch(url)
    if found is None or not 0 < int(found["port"]) < 65536:
        raise ConfigError(f"wire '{url}': expected can:socketcand:HOST:PORT[:CHANNEL], an IPv4 host")
    return found


def _bus_of(url: str) -> re.Match[str]:
    parts = _URL.fullmatch(url)
    if parts is None:
        ways = "can:INTERFACE:CHANNEL[:BITRATE] or can:tcp:HOST:PORT, or can:socketcand:HOST:PORT[:CHANNEL]"
        raise ConfigError(f"wire '{url}': expected {ways}")
    interface = parts["interface"]
    if interface not in can.VALID_INTERFACES or interface == "udp_multicast":  # which hears itself
        there = ", ".join(sorted(set(can.VALID_INTERFACES) - {"udp_multicast"}))
        raise ConfigError(f"wire '{url}': interface '{interface}' cannot be used; there are: {there}")
    return parts


def _at_hub(url: str) -> CanPort:
    """Join a bus that a socketcand server has."""
    found = _hub_of(url)
    host, port = found["host"], int(found["port"])
    try:
        with socket.create_connection((host, port), GREETING_TIMEOUT_S) as probe:  # python-can itself tries for 10 s
            probe.settimeout(GREETING_TIMEOUT_S)
            if probe.recv(16)[:1] != b"<":
                raise LinkError(f"wire '{url}': no socketcand server is there")
        options: dict[str, Any] = {"host": host, "port": port, "tcp_tune": True}
        return CanPort(can.Bus(found["channel"] or CHANNEL, "socketcand", ignore_config=True, **options), url)
    except (can.CanError, OSError, ValueError) as error:
        raise LinkError(f"wire '{url}': cannot join the bus: {_why(error)}") from error


def _joined(url: str, parts: re.Match[str]) -> CanPort:
    interface = parts["interface"]
    rate: dict[str, Any] = {"bitrate": int(parts["bitrate"])} if parts["bitrate"] else {}
    try:
        return CanPort(can.Bus(parts["channel"], interface, ignore_config=True, **rate), url)
    except (can.CanError, OSError, ImportError, ValueError, TypeError) as error:
        raise LinkError(f"wire '{url}': cannot join the bus: {_why(error)}") from error


def _why(error: Exception) -> str:
    r"""Say what a bus complains of, in one line: python-can puts tracebacks into some of its errors.

    >>> _why(can.CanOperationError("Failed to receive: reset  Traceback (most recent call last):\n  File..."))
    'Failed to receive: reset'
    >>> _why(can.CanTimeoutError())
    'CanTimeoutError'
    """
    cause = error.__cause__ if isinstance(error, can.CanError) else error
    if isinstance(cause, OSError):
        return reason(cause)
    return " ".join(str(error).partition("Traceback (")[0].split()) or type(error).__name__


wire = CanWire()
