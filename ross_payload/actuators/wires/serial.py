"""A serial line as a wire: a device of this computer, or raw bytes over TCP."""

from __future__ import annotations

import errno
import grp
from pathlib import Path
from typing import Any

from ross_payload.actuators.wires import StreamWire, connect, served_at
from ross_payload.actuators.wires.codecs import RawCodec
from ross_payload.errors import ConfigError, LinkError
from ross_payload.interfaces import Clock, Port
from ross_payload.transport.byte_stream import Handle
from ross_payload.transport.link_url import Serial, parse
from ross_payload.transport.serial_port import open_serial

REOPEN_PAUSE_S = 1.0  # between two attempts to open a device that has gone


class SerialLine(StreamWire):
    """An open device."""

    empty_is_end = False
    max_waiting_bytes = 4096
    backlog = "the device does not accept data"


class SerialPort:
    """A line that is opened again, once a second, when its device has gone, and says so until then.

    Parameters
    ----------
    address
        Device and baud rate.
    url
        For messages.
    clock
        Tells when to try again.
    """

    def __init__(self, address: Serial, url: str, clock: Clock) -> None:
        self._address = address
        self._url = url
        self._clock = clock
        self._retry_at = 0.0  # [s]
        self._line = self._open()

    def send(self, frame: Any) -> None:
        """Send bytes; what the line does not take now goes later, what is sent into a gone one is lost."""
        self._line.send(frame)

    def receive(self) -> list[Any]:
        """Return the bytes that have arrived.

        Raises
        ------
        LinkError
            When the device has gone.
        """
        if self._line.gone and self._clock.now() >= self._retry_at:
            self._retry_at = self._clock.now() + REOPEN_PAUSE_S
            self._line.close()
            self._line = self._open()
        return self._line.receive()

    def close(self) -> None:
        """Give the device back; idempotent."""
        self._retry_at = float("inf")
        self._line.close()

    def _open(self) -> SerialLine:
        return SerialLine(opened(self._address, self._url), RawCodec(), f"wire '{self._url}'")


def opened(address: Serial, url: str) -> Handle:
    """Open a device for ourselves alone.

    Raises
    ------
    ConfigError
        When pyserial is not installed, or the baud rate is none.
    LinkError
        When there is no such device, it is busy, or we may not.
    """
    try:
        return open_serial(address.device, address.baud or 0)
    except ValueError as error:
        raise ConfigError(f"wire '{url}': {error}") from error
    except OSError as error:
        raise LinkError(f"wire '{url}': {_why(error, address.device)}") from error


def _why(error: OSError, device: str) -> str:
    if error.errno == errno.ENOENT:
        from serial.tools import list_ports  # noqa: PLC0415  an extra

        there = ", ".join(sorted(port.device for port in list_ports.comports())) or "none"
        return f"there is no {device}; serial ports: {there}"
    if error.errno == errno.EACCES:
        return f"not allowed to open {device}: add this user to the group '{group_name(Path(device).stat().st_gid)}'"
    if error.errno == errno.EBUSY:
        return f"{device} is busy: another program has it open"
    return f"cannot open {device}: {error.strerror or error}"


def group_name(number: int) -> str:
    """Return the name of a group of this computer, or its number when it has none."""
    try:
        return grp.getgrgid(number).gr_name
    except KeyError:
        return str(number)


class SerialWire:
    """The scheme ``serial``."""

    def open(self, url: str, clock: Clock) -> Port:
        """Open a device, or connect to one that is served over TCP without any protocol around its bytes.

        Raises
        ------
        ConfigError
            When the URL is malformed.
        LinkError
            When the line cannot be opened.
        """
        address = self.check(url)
        return connect(url, RawCodec(), clock) if address is None else SerialPort(address, url, clock)

    def check(self, url: str) -> Serial | None:
        """Read the URL of a device; None: it is served over TCP.

        Raises
        ------
        ConfigError
            When it is malformed.
        """
        if url.startswith("serial:tcp:"):
            served_at(url)
            return None
        address = parse(url)
        if not isinstance(address, Serial) or address.baud is None:
            raise ConfigError(f"wire '{url}': expected serial:DEVICE:BAUD or serial:tcp:HOST:PORT")
        return address


wire = SerialWire()
