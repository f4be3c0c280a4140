"""Serial links: pseudo terminals that know their baud rate, unplugging, and finding the rate by a heartbeat."""

import contextlib
import os
import pty
import socket
import sys
import termios
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from clocks import LeapingClock
from links_bench import BEAT, hears, status
from ross_payload.clock import SystemClock
from ross_payload.config import Link
from ross_payload.errors import ConfigError, LinkError
from ross_payload.mavlink import Router
from ross_payload.transport.byte_stream import ReconnectingStream
from ross_payload.transport.link_url import Serial
from ross_payload.transport.serial_port import BAUDS, SerialOpener
from ross_protocols.mavlink.codec import Decoder, Encoder
from waiting import wait_for

FRAME = Encoder(1, 1).encode(BEAT)
RATES = {57600: termios.B57600, 115200: termios.B115200, 921600: termios.B921600, 460800: termios.B460800}


@pytest.fixture
def terminal() -> Iterator[tuple[int, str]]:
    far, near = pty.openpty()
    yield far, os.ttyname(near)
    os.close(near)
    os.close(far)


# ---------------------------------------------------------------------------------------------------- a known rate


def test_serial_goes_both_ways(terminal: tuple[int, str]) -> None:
    far, name = terminal
    with Router.open([Link(url=f"serial:{name}:57600")], SystemClock()) as links:
        heard = hears(links)
        links.component(191).send(BEAT)
        (packet,) = Decoder().feed(os.read(far, 1000))
        os.write(far, FRAME)
        wait_for(lambda: links.poll() or heard)
    assert (packet.component_id, packet.value) == (191, BEAT)
    assert heard[0].packet.value == BEAT


def test_a_serial_line_gives_us_half_of_its_bytes(terminal: tuple[int, str]) -> None:
    far, name = terminal
    clock = LeapingClock()
    clock.now = lambda: clock.ahead  # type: ignore[method-assign]
    with Router.open([Link(url=f"serial:{name}:57600")], clock) as links:
        got = 0
        for _ in range(10 * 100):
            for _ in range(5):
                links.component(191).send(BEAT)
            clock.ahead += 0.01
            os.set_blocking(far, False)
            with contextlib.suppress(BlockingIOError):
                got += len(os.read(far, 10_000))
        assert status(links).dropped > 0
    assert got == pytest.approx(10 * 57600 / 10 / 2, rel=0.1)


def test_a_serial_line_that_takes_nothing_drops_frames(terminal: tuple[int, str]) -> None:
    with Router.open([Link(url=f"serial:{terminal[1]}:57600", max_bytes_s=10**9)], SystemClock()) as links:
        for _ in range(10_000):
            links.component(191).send(BEAT)
        assert status(links).dropped > 5_000


def test_a_device_that_is_pulled_out_and_put_back_is_used_again(tmp_path: Path) -> None:
    plug, clock = tmp_path / "ttyUSB0", LeapingClock()
    far, near = pty.openpty()
    plug.symlink_to(os.ttyname(near))
    os.close(near)
    with Router.open([Link(url=f"serial:{plug}:57600")], clock) as links:
        heard = hears(links)
        os.close(far)
        plug.unlink()
        wait_for(lambda: links.poll() or not status(links).up)
        links.component(191).send(BEAT)
        clock.ahead += 10.0
        links.poll()
        assert "No such file" in status(links).error
        far, near = pty.openpty()
        plug.symlink_to(os.ttyname(near))
        clock.ahead += 10.0
        wait_for(lambda: links.poll() or status(links).up)
        os.write(far, FRAME)
        wait_for(lambda: links.poll() or heard)
        assert status(links).reconnects == 1
    os.close(near)
    os.close(far)


def test_a_device_that_is_not_there_is_one_clear_line_for_the_impatient() -> None:
    with pytest.raises(
        LinkError, match=r"^link 'serial:/dev/no-such:57600' cannot be opened: No such file or directory$"
    ):
        Router.open([Link(url="serial:/dev/no-such:57600")], SystemClock())


def test_a_device_that_comes_late_is_waited_for_by_the_patient(tmp_path: Path, terminal: tuple[int, str]) -> None:
    plug, clock = tmp_path / "ttyUSB0", LeapingClock()
    with Router.open([Link(url=f"serial:{plug}:57600")], clock, patient=True) as links:
        heard = hears(links)
        links.poll()
        assert not status(links).up
        plug.symlink_to(terminal[1])
        clock.ahead += 10.0
        wait_for(lambda: links.poll() or status(links).up)
        os.write(terminal[0], FRAME)
        wait_for(lambda: links.poll() or heard)


def test_serial_without_its_package_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "serial", None)
    for patient in (False, True):
        with pytest.raises(ConfigError, match="pip install 'pyserial>="):
            Router.open([Link(url="serial:/dev/ttyUSB0:57600")], SystemClock(), patient=patient)


# ---------------------------------------------------------------------------------------------------- an unknown rate


class Autopilot:
    """The far end of a pseudo terminal: a heartbeat while the near end has its rate, else noise."""

    def __init__(self, far: int, baud: int) -> None:
        self._far, self._baud = far, baud
        self._going = True
        self._encoder = Encoder(1, 1)
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        os.set_blocking(self._far, False)
        while self._going:
            right = termios.tcgetattr(self._far)[4] == RATES[self._baud]
            frame = self._encoder.encode(BEAT)
            with contextlib.suppress(BlockingIOError):
                os.write(self._far, frame if right else bytes((byte * 7 + 3) % 256 for byte in frame))
            time.sleep(0.005)

    def stop(self) -> None:
        self._going = False
        self._thread.join()


@pytest.mark.parametrize("baud", [57600, 115200, 460800])
def test_the_rate_of_a_line_is_found_by_its_heartbeat(terminal: tuple[int, str], baud: int) -> None:
    far, name = terminal
    clock = LeapingClock()
    autopilot = Autopilot(far, baud)
    with Router.open([Link(url=f"serial:{name}:auto")], clock) as links:
        heard = hears(links)
        for _ in range(200):
            links.poll()
            clock.ahead += 0.1
            time.sleep(0.01)
            if status(links).up:
                break
        wait_for(lambda: links.poll() or heard)
        assert status(links).room == pytest.approx(max(baud / 40, 293)), "half a second of half of the line"
        assert termios.tcgetattr(far)[4] == RATES[baud]
        autopilot.stop()


class Bench:
    """A fake line: what its far end sends is readable at one rate only; says at which rates it was tried."""

    def __init__(self, right: int) -> None:
        self._near, self._far = socket.socketpair()
        self._near.setblocking(False)
        self._right = right
        self._baudrate = BAUDS[0]
        self.tried = [self._baudrate]

    @property
    def baudrate(self) -> int:
        return self._baudrate

    @baudrate.setter
    def baudrate(self, baud: int) -> None:
        self.tried.append(baud)
        if baud == 1500000:
            raise ValueError("this device is too slow")
        self._baudrate = baud

    def beat(self) -> None:
        self._far.send(FRAME if self._baudrate == self._right else FRAME[::-1])

    def fileno(self) -> int:
        return self._near.fileno()

    def close(self) -> None:
        self._near.close()
        self._far.close()


def find(bench: Bench, clock: LeapingClock, seconds: float) -> ReconnectingStream:
    """Let the port look for a while, with one heartbeat per second."""
    clock.now = lambda: clock.ahead  # type: ignore[method-assign]
    port = ReconnectingStream(SerialOpener(Serial("/dev/bench", None), lambda device, baud: bench), clock.now)
    for tick in range(round(seconds * 100)):
        clock.ahead = tick / 100
        if tick % 100 == 50:
            bench.beat()
        port.receive()
        if port.counts.up:
            break
    return port


@pytest.mark.parametrize("right", BAUDS)
def test_every_usual_rate_is_found_where_the_device_has_it(right: int) -> None:
    bench, clock = Bench(right), LeapingClock()
    port = find(bench, clock, seconds=40.0)
    if right == 1500000:
        assert not port.counts.up, "the rate that the device refuses"
    else:
        assert (port.counts.up, port.counts.baud) == (True, right)
        assert clock.now() < 1.5 * (BAUDS.index(right) + 1) + 0.1
    port.close()
    bench.close()


def test_a_silent_line_is_tried_at_all_rates_again_and_again() -> None:
    bench = Bench(right=0)
    port = find(bench, LeapingClock(), seconds=1.5 * 2 * len(BAUDS) + 1)
    assert bench.tried[: 2 * len(BAUDS)] == list(BAUDS) * 2
    assert not port.counts.up
    port.send(FRAME)
    assert port.counts.failed == 1, "nothing is said at a rate that is only guessed"
    port.close()
    bench.close()
