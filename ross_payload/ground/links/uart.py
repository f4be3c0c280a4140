"""MAVLink over a serial line, whose baud rate can be found by listening for a heartbeat."""

from __future__ import annotations

import asyncio
import errno
import os
import select
import termios
from collections.abc import Callable
from contextlib import suppress
from itertools import cycle
from typing import NoReturn, Protocol

from ross_payload.ground.links.ports import HERE, Health, Listener, Peer, cancelled, keep
from ross_protocols.address import Serial
from ross_protocols.codec import Decoder

BAUDS = (57600, 115200, 921600, 460800, 230400, 1500000, 500000, 38400, 19200, 9600)
LISTEN = 1.5  # for a heartbeat, which comes once a second [s]
AT_ONCE = 4096  # bytes that are read in one go


class Device(Protocol):
    """An open serial device that does not block."""

    baudrate: int

    def fileno(self) -> int:
        """Return its file descriptor."""

    def close(self) -> None:
        """Close it."""


class Line:
    """An open device on the loop: a frame that is begun is finished before the next one is."""

    def __init__(self, device: Device, came: Callable[[bytes], None]) -> None:
        self._loop = asyncio.get_running_loop()
        self.lost: asyncio.Future[None] = self._loop.create_future()
        self._device = device
        self._came = came
        self._rest = b""
        self._loop.add_reader(device.fileno(), self._read)

    def send(self, frame: bytes) -> None:
        """Send one frame, or drop it when the line is busy."""
        if not self._rest and not self.lost.done():
            self._rest = frame
            self._write()

    def close(self) -> None:
        """Close the device."""
        self._loop.remove_reader(self._device.fileno())
        self._loop.remove_writer(self._device.fileno())
        self._device.close()

    def _read(self) -> None:
        try:
            data = os.read(self._device.fileno(), AT_ONCE)
        except BlockingIOError:
            return
        except OSError as error:
            self._lose(error)
            return
        if data:
            self._came(data)
        elif hung_up(self._device.fileno()):
            self._lose(ConnectionResetError(0, "the device was disconnected"))

    def _write(self) -> None:
        fd = self._device.fileno()
        self._loop.remove_writer(fd)
        try:
            self._rest = self._rest[os.write(fd, self._rest) :]
        except BlockingIOError:
            pass
        except OSError as error:
            self._lose(error)
            return
        if self._rest:
            self._loop.add_writer(fd, self._write)

    def _lose(self, error: OSError) -> None:
        self._loop.remove_reader(self._device.fileno())
        if not self.lost.done():
            self.lost.set_exception(error)


class SerialPort:
    """A serial device, opened again after it was unplugged; without a rate the usual ones are tried."""

    def __init__(
        self, address: Serial, listener: Listener, open_device: Callable[[str, int], Device] | None = None
    ) -> None:
        self.health = Health()
        self._address = address
        self._listener = listener
        self._open_device = open_device or device_of_system
        self._baud = address.baud
        self._line: Line | None = None
        self._task: asyncio.Task[NoReturn] | None = None

    async def open(self) -> None:
        """Begin to open the device."""
        import serial  # noqa: F401, PLC0415  an extra: who lacks it hears of it at once

        self._task = asyncio.create_task(keep(self.health, self._hold))

    def send(self, frame: bytes, peer: Peer) -> None:
        """Send one frame, if the device is open and its rate known."""
        if self._line is not None:
            self._line.send(frame)

    async def close(self) -> None:
        """Close the device."""
        task, self._task = self._task, None
        await cancelled(task)

    async def _hold(self) -> None:
        device = self._open_device(self._address.device, self._baud or BAUDS[0])
        if self._baud is None:
            self._baud = await self._found(device)
        line = Line(device, lambda data: self._listener.came(HERE, data))
        try:
            self._line = line
            self.health.up, self.health.error = True, ""
            self._listener.met(HERE)
            await line.lost
        finally:
            self._line = None
            self._listener.gone(HERE)
            line.close()

    async def _found(self, device: Device) -> int:
        """Listen at one rate after the other until a heartbeat is heard; a failure closes the device."""
        rates = cycle(BAUDS)
        try:
            while True:
                baud = next(rates)
                self.health.error = f"listens for a heartbeat at {baud} baud"
                with suppress(OSError, ValueError, termios.error):  # the device lacks this rate
                    device.baudrate = baud
                if await _beats(device):
                    return baud
        except BaseException:
            device.close()
            raise


async def _beats(device: Device) -> bool:
    """Tell whether a heartbeat is heard within `LISTEN`."""
    loop, decoder = asyncio.get_running_loop(), Decoder()
    heard: asyncio.Future[None] = loop.create_future()

    def look() -> None:
        try:
            found = _is_heard(device, decoder)
        except OSError as error:
            loop.remove_reader(device.fileno())
            heard.set_exception(error)
            return
        if found and not heard.done():
            heard.set_result(None)

    loop.add_reader(device.fileno(), look)
    try:
        async with asyncio.timeout(LISTEN):
            await heard
    except TimeoutError:
        return False
    finally:
        loop.remove_reader(device.fileno())
    return True


def _is_heard(device: Device, decoder: Decoder) -> bool:
    """Tell whether what has arrived completes a heartbeat; OSError: the device is gone."""
    try:
        data = os.read(device.fileno(), AT_ONCE)
    except BlockingIOError:
        return False
    if not data and hung_up(device.fileno()):
        raise ConnectionResetError(0, "the device was disconnected")
    return any(packet.name == "HEARTBEAT" for packet in decoder.feed(data))


def device_of_system(device: str, baud: int) -> Device:
    """Open a serial device for ourselves alone; from now on its DTR stays as it is when somebody closes it.

    A board that resets when DTR becomes active does so when its device is opened first after plugging in, never later.

    Raises
    ------
    OSError
        When the device cannot be opened, or not at this rate.
    """
    import serial  # noqa: PLC0415  an extra: only those who use it need it

    try:
        line = serial.Serial(device, baud, timeout=0, exclusive=True)
        settings = termios.tcgetattr(line.fileno())
        settings[2] &= ~termios.HUPCL
        termios.tcsetattr(line.fileno(), termios.TCSANOW, settings)
    except serial.SerialException as error:
        busy = error.errno == errno.EAGAIN  # somebody else has the lock
        raise OSError(errno.EBUSY if busy else error.errno or 0, str(error)) from error
    except (ValueError, termios.error) as error:
        raise OSError(0, str(error)) from error
    return line


def hung_up(fd: int) -> bool:
    """Tell whether nobody is at the other end of a device or a terminal any more."""
    poll = select.poll()
    poll.register(fd, 0)
    return bool(poll.poll(0))
