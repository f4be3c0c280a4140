"""A serial line as a wire: a device of this computer, or raw bytes over TCP.

Opening must not reset the microcontroller at the other end, for a reset loses the position. Most boards reset when DTR
*becomes* active. Linux makes DTR and RTS active when a device is opened, and inactive at the last close unless HUPCL is
off. So they stay as the kernel sets them (to take them back would be one more change), and HUPCL is switched off: from
the second opening on, and when this program dies, they do not change. The first opening after plugging in resets such a
board; only hardware can prevent that.
"""

from __future__ import annotations

import errno
import grp
import os
import termios
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ross_payload.actuators.wires import connect, served_at
from ross_payload.errors import ConfigError, LinkError
from ross_payload.extras import install_line
from ross_payload.interfaces import Clock, Port
from ross_payload.links.address import Serial, Tcp, parse

if TYPE_CHECKING:
    import serial

MOST = 65536  # bytes of one look
AGAIN = 1.0  # between two attempts to open a device that has gone [s]
MOST_WAITING = 4096  # bytes that a line has not taken


class RawCodec:
    """Bytes with nothing around them.

    >>> RawCodec().feed(RawCodec().pack(b"ok"))
    [b'ok']
    """

    name = ""

    def pack(self, frame: Any) -> bytes:
        """Return the bytes."""
        return bytes(frame)

    def feed(self, data: bytes) -> list[Any]:
        """Return the bytes, if there are any."""
        return [data] if data else []


class SerialPort:
    """An open line; one that has gone is opened again, once a second, and says so until then.

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
        self._waiting = bytearray()
        self._gone = ""
        self._again = 0.0  # [s]
        self._line: serial.Serial | None = opened(address, url)

    def send(self, frame: Any) -> None:
        """Send bytes; what the line does not take now goes later, what is sent into a gone one is lost."""
        if self._line is not None:
            self._waiting += frame
            self._flush(self._line)

    def receive(self) -> list[Any]:
        """Return the bytes that have arrived.

        Raises
        ------
        LinkError
            When the device has gone.
        """
        line = self._line or self._reopened()
        data = self._read(line)
        self._flush(line)
        if self._line is None and not data:
            raise LinkError(self._gone)
        return [data] if data else []

    def close(self) -> None:
        """Give the device back; idempotent."""
        self._again = float("inf")
        self._leave("closed")

    def _reopened(self) -> serial.Serial:
        if self._clock.now() < self._again:
            raise LinkError(self._gone)
        self._again = self._clock.now() + AGAIN
        self._line = opened(self._address, self._url)
        return self._line

    def _read(self, line: serial.Serial) -> bytes:
        try:
            data = os.read(line.fileno(), MOST)
        except BlockingIOError:
            return b""
        except OSError as error:
            self._leave(error.strerror or str(error))
            return b""
        if not data and not Path(self._address.device).exists():
            self._leave("the device was disconnected")
        return data

    def _flush(self, line: serial.Serial) -> None:
        try:
            while self._waiting and self._line is line:
                del self._waiting[: os.write(line.fileno(), self._waiting)]
        except BlockingIOError:
            if len(self._waiting) > MOST_WAITING:
                self._leave("the device does not accept data")
        except OSError as error:
            self._leave(error.strerror or str(error))

    def _leave(self, why: str) -> None:
        if self._line is not None:
            self._gone = f"wire '{self._url}': {why}"
            self._waiting.clear()
            self._line.close()
            self._line = None


def opened(address: Serial, url: str) -> serial.Serial:
    """Open a device for ourselves alone, and leave its modem lines as the kernel sets them, for ever.

    Raises
    ------
    ConfigError
        When pyserial is not installed, or the baud rate is none.
    LinkError
        When there is no such device, it is busy, or we may not.
    """
    try:
        import serial  # noqa: PLC0415  an extra: only those who use it need it
    except ModuleNotFoundError as error:
        raise ConfigError(f"a serial wire needs the package pyserial: {install_line('serial')}") from error
    try:
        line = serial.Serial(address.device, address.baud or 0, timeout=0, exclusive=True)
    except (ValueError, termios.error) as error:
        raise ConfigError(f"wire '{url}': {error}") from error
    except OSError as error:
        raise LinkError(f"wire '{url}': {_why(error, address.device)}") from error
    attributes = termios.tcgetattr(line.fileno())
    attributes[2] &= ~termios.HUPCL
    termios.tcsetattr(line.fileno(), termios.TCSANOW, attributes)
    return line


def _why(error: OSError, device: str) -> str:
    if error.errno == errno.ENOENT:
        from serial.tools import list_ports  # noqa: PLC0415  an extra

        there = ", ".join(sorted(port.device for port in list_ports.comports())) or "none"
        return f"there is no {device}; serial ports: {there}"
    if error.errno == errno.EACCES:
        return f"not allowed to open {device}: add this user to the group '{_group(device)}'"
    if error.errno in (errno.EBUSY, errno.EAGAIN) or "exclusively lock" in str(error):
        return f"{device} is busy: another program has it open"
    return f"cannot open {device}: {error.strerror or error}"


def _group(device: str) -> str:
    number = Path(device).stat().st_gid
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
        return connect(url, RawCodec(), clock) if isinstance(address, Tcp) else SerialPort(address, url, clock)

    def check(self, url: str) -> Serial | Tcp:
        """Read a URL.

        Raises
        ------
        ConfigError
            When it is malformed.
        """
        if url.startswith("serial:tcp:"):
            return served_at(url)
        address = parse(url)
        if not isinstance(address, Serial) or address.baud is None:
            raise ConfigError(f"wire '{url}': expected serial:DEVICE:BAUD or serial:tcp:HOST:PORT")
        return address


wire = SerialWire()
