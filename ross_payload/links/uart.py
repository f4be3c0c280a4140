"""MAVLink over a serial line, whose baud rate can be found by listening for a heartbeat."""

from __future__ import annotations

import os
import termios
from collections.abc import Callable
from contextlib import suppress
from typing import Protocol

from ross_payload.errors import ConfigError
from ross_payload.extras import install_line
from ross_payload.links.address import Serial
from ross_payload.links.ports import MOST
from ross_payload.links.stream import Handle
from ross_protocols.codec import Decoder

BAUDS = (57600, 115200, 921600, 460800, 230400, 1500000, 500000, 38400, 19200, 9600)
LISTEN = 1.5  # for a heartbeat, which comes once a second [s]


class Line(Handle, Protocol):
    """An open serial device."""

    baudrate: int


class SerialOpener:
    """Opens a serial device; when its baud rate is not told, tries the usual ones until a heartbeat is heard."""

    empty_is_end = False

    def __init__(self, address: Serial, open_line: Callable[[str, int], Line] | None = None) -> None:
        self._address = address
        self._open_line = open_line or open_line_of_system
        self._line: Line | None = None
        self._decoder = Decoder()
        self._until = 0.0
        self.baud = address.baud or 0

    def poll(self, now: float) -> Handle | None:
        """Return the line when it is open at the right rate, None while it listens.

        Raises
        ------
        OSError
            When the device cannot be opened or is gone.
        """
        if self._line is None:
            self._line = self._open_line(self._address.device, self.baud or BAUDS[0])
            self._listen(self._line, self.baud or BAUDS[0], now)
        if self._address.baud is None and not self._beats(self._line):
            if now >= self._until:
                after = BAUDS.index(self.baud) + 1
                self._listen(self._line, BAUDS[after % len(BAUDS)], now)
            return None
        line, self._line = self._line, None
        return line

    def close(self) -> None:
        """Close the line that is being listened to."""
        if self._line is not None:
            self._line.close()
            self._line = None

    def _listen(self, line: Line, baud: int, now: float) -> None:
        self.baud = baud
        if line.baudrate != baud:
            with suppress(OSError, ValueError, termios.error):  # the device lacks this rate: the next one comes soon
                line.baudrate = baud
        self._decoder = Decoder()
        self._until = now + LISTEN

    def _beats(self, line: Line) -> bool:
        try:
            data = os.read(line.fileno(), MOST)
        except BlockingIOError:
            return False
        except OSError:
            self.close()
            raise
        return any(packet.name == "HEARTBEAT" for packet in self._decoder.feed(data))


def open_line_of_system(device: str, baud: int) -> Line:
    """Open a serial device for ourselves alone.

    Raises
    ------
    ConfigError
        When pyserial is not installed.
    OSError
        When the device cannot be opened, or not at this rate.
    """
    try:
        import serial  # noqa: PLC0415  an extra: only those who use it need it
    except ModuleNotFoundError as error:
        raise ConfigError(f"a serial link needs the package pyserial: {install_line('serial')}") from error
    try:
        line: Line = serial.Serial(device, baud, timeout=0, exclusive=True)
    except (ValueError, termios.error) as error:
        raise OSError(0, str(error)) from error
    return line
