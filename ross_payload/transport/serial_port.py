"""Serial lines, whose baud rate can be found by listening for a heartbeat.

Opening must not reset the microcontroller at the other end: a motor controller would lose its position. Most boards
reset when DTR *becomes* active. Linux makes DTR and RTS active when a device is opened, and inactive at the last close
unless HUPCL is off. So they stay as the kernel sets them (to take them back would be one more change), and HUPCL is
switched off: from the second opening on, and when this program dies, they do not change. The first opening after
plugging in resets such a board; only hardware can prevent that.
"""

from __future__ import annotations

import errno
import os
import termios
from collections.abc import Callable
from contextlib import suppress
from typing import Protocol

from ross_payload.errors import ConfigError
from ross_payload.plugins import install_line
from ross_payload.transport.byte_stream import Handle, hung_up
from ross_payload.transport.link_url import Serial
from ross_payload.transport.ports import MAX_READ_BYTES
from ross_protocols.mavlink.codec import Decoder

BAUDS = (57600, 115200, 921600, 460800, 230400, 1500000, 500000, 38400, 19200, 9600)
LISTEN_S = 1.5  # for a heartbeat, which comes once a second


class SerialDevice(Handle, Protocol):
    """An open serial device."""

    baudrate: int


class SerialOpener:
    """Opens a serial device; when its baud rate is not told, tries the usual ones until a heartbeat is heard."""

    empty_is_end = False

    def __init__(self, address: Serial, open_device: Callable[[str, int], SerialDevice] | None = None) -> None:
        self._address = address
        self._open_device = open_device or open_serial
        self._device: SerialDevice | None = None
        self._decoder = Decoder()
        self._until = 0.0
        self.baud = address.baud or 0

    @property
    def progress(self) -> str:
        """At which rate it listens."""
        return "" if self._device is None else f"listens for a heartbeat at {self.baud} baud"

    def poll(self, now: float) -> Handle | None:
        """Return the device when it is open at the right rate, None while it listens.

        Raises
        ------
        OSError
            When the device cannot be opened or is gone.
        ValueError
            When there is no such rate.
        """
        if self._device is None:
            self._device = self._open_device(self._address.device, self.baud or BAUDS[0])
            self._listen(self._device, self.baud or BAUDS[0], now)
        if self._address.baud is None and not self._beats(self._device):
            if now >= self._until:
                after = BAUDS.index(self.baud) + 1
                self._listen(self._device, BAUDS[after % len(BAUDS)], now)
            return None
        device, self._device = self._device, None
        return device

    def close(self) -> None:
        """Close the device that is being listened to."""
        if self._device is not None:
            self._device.close()
            self._device = None

    def _listen(self, device: SerialDevice, baud: int, now: float) -> None:
        self.baud = baud
        if device.baudrate != baud:
            with suppress(OSError, ValueError, termios.error):  # the device lacks this rate: the next one comes soon
                device.baudrate = baud
        self._decoder = Decoder()
        self._until = now + LISTEN_S

    def _beats(self, device: SerialDevice) -> bool:
        try:
            data = os.read(device.fileno(), MAX_READ_BYTES)
            if not data and hung_up(device.fileno()):
                raise ConnectionResetError(0, "the device was disconnected")
        except BlockingIOError:
            return False
        except OSError:
            self.close()
            raise
        return any(packet.name == "HEARTBEAT" for packet in self._decoder.feed(data))


def open_serial(device: str, baud: int) -> SerialDevice:
    """Open a serial device for ourselves alone; from now on its DTR stays as it is when somebody closes it.

    Raises
    ------
    ConfigError
        When pyserial is not installed.
    OSError
        When the device cannot be opened; EBUSY: another program has it open.
    ValueError
        When there is no such rate.
    """
    try:
        import serial  # noqa: PLC0415  an extra: only those who use it need it
    except ModuleNotFoundError as error:
        raise ConfigError(f"serial port {device} needs the package pyserial: {install_line('serial')}") from error
    try:
        opened: SerialDevice = serial.Serial(device, baud, timeout=0, exclusive=True)
    except serial.SerialException as error:
        busy = error.errno in (errno.EBUSY, errno.EAGAIN) or "exclusively lock" in str(error)
        raise OSError(errno.EBUSY if busy else error.errno or 0, str(error)) from error
    except termios.error as error:
        raise ValueError(str(error)) from error
    attributes = termios.tcgetattr(opened.fileno())
    attributes[2] &= ~termios.HUPCL
    termios.tcsetattr(opened.fileno(), termios.TCSANOW, attributes)
    return opened
