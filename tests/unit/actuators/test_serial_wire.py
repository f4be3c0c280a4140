"""Serial wires on real pseudo terminals: bytes cross, nothing waits, every trouble is one clear line."""

from __future__ import annotations

import os
import socket
import termios
import time
import tty

import pytest

from clocks import LeapingClock
from ross_payload.actuators.wires import open_wire
from ross_payload.actuators.wires.serial import REOPEN_PAUSE_S, SerialWire, _why
from ross_payload.errors import ConfigError, LinkError
from ross_sim.devices.connections import PtyServer
from ross_sim.devices.wire_servers import SerialSide, WireServer
from waiting import wait_for


class Terminal:
    """A pseudo terminal behind a name that stays, as udev's links do."""

    def __init__(self, link):
        self.link = link
        self.plug()

    def plug(self):
        self.ours, self.theirs = os.openpty()
        tty.setraw(self.theirs)
        self.link.symlink_to(os.ttyname(self.theirs))

    def unplug(self):
        self.link.unlink()
        os.close(self.theirs)
        os.close(self.ours)


@pytest.fixture
def terminal(tmp_path):
    terminal = Terminal(tmp_path / "ttyTest")
    yield terminal
    if terminal.link.is_symlink():
        terminal.unplug()


@pytest.fixture
def clock():
    return LeapingClock()


@pytest.fixture
def url(terminal):
    return f"serial:{terminal.link}:115200"


def all_of(wire, wanted):
    got = b""
    deadline = time.monotonic() + 20.0
    while len(got) < len(wanted):
        got += b"".join(wire.receive())
        assert time.monotonic() < deadline, got
    return got


def test_bytes_cross_both_ways_as_they_are(terminal, url, clock):
    wire = open_wire(url, clock)
    everything = bytes(range(256))
    wire.send(everything)
    got = b""
    while len(got) < 256:
        got += os.read(terminal.ours, 4096)
    assert got == everything
    os.write(terminal.ours, everything)
    assert all_of(wire, everything) == everything
    wire.close()


def test_receiving_nothing_does_not_wait(url, clock):
    wire = open_wire(url, clock)
    begin = time.monotonic()
    for _ in range(100):
        assert wire.receive() == []
    assert time.monotonic() - begin < 2.0
    wire.close()


def test_what_the_line_does_not_take_now_goes_later(terminal, url, clock):
    wire = open_wire(url, clock)
    sent = bytes(1000) * 12
    for n in range(12):
        wire.send(sent[n * 1000 : (n + 1) * 1000])
        if n == 3:
            got = os.read(terminal.ours, 100)
    os.set_blocking(terminal.ours, False)
    deadline = time.monotonic() + 20
    while len(got) < len(sent):
        wire.receive()
        try:
            got += os.read(terminal.ours, 4096)
        except BlockingIOError:
            assert time.monotonic() < deadline, len(got)
    assert got == sent
    wire.close()


def test_the_modem_lines_stay_when_it_is_closed(terminal, url, clock):
    wire = open_wire(url, clock)
    assert not termios.tcgetattr(terminal.theirs)[2] & termios.HUPCL
    wire.close()
    assert not termios.tcgetattr(terminal.theirs)[2] & termios.HUPCL


def test_a_device_that_somebody_else_uses_is_busy(url, clock):
    wire = open_wire(url, clock)
    with pytest.raises(LinkError, match="is busy: another program has it open"):
        open_wire(url, clock)
    wire.close()
    open_wire(url, clock).close()


def test_a_device_that_is_not_there_is_named_with_those_that_are(clock):
    with pytest.raises(LinkError, match="there is no /dev/ttyNONE; serial ports: "):
        open_wire("serial:/dev/ttyNONE:115200", clock)


def test_without_permission_the_group_is_named(tmp_path):
    path = tmp_path / "tty"
    path.touch()
    assert "add this user to the group '" in _why(PermissionError(13, "Permission denied"), str(path))


@pytest.mark.parametrize(
    "url", ["serial:", "serial:/dev/ttyUSB0", "serial:/dev/ttyUSB0:auto", "serial:/dev/ttyUSB0:fast", "serial:tcp:here"]
)
def test_a_wrong_url_says_what_is_wanted(url, clock):
    with pytest.raises(ConfigError, match="expected"):
        SerialWire().open(url, clock)


def test_a_file_is_not_a_serial_device(tmp_path, clock):
    path = tmp_path / "file"
    path.touch()
    with pytest.raises((LinkError, ConfigError), match="file"):
        open_wire(f"serial:{path}:115200", clock)


def test_a_device_that_vanishes_is_an_error_and_comes_back(terminal, url, clock):
    wire = open_wire(url, clock)
    terminal.unplug()

    def gone():
        try:
            wire.receive()
        except LinkError as error:
            return str(error)
        return ""

    assert url in wait_for(gone)
    wire.send(b"lost")
    clock.ahead += 2 * REOPEN_PAUSE_S
    assert "there is no" in gone()
    terminal.plug()
    assert gone()  # not before the pause is over
    clock.ahead += 2 * REOPEN_PAUSE_S
    assert wire.receive() == []
    wire.send(b"back")
    assert os.read(terminal.ours, 100) == b"back"
    wire.close()


def test_a_closed_wire_stays_closed(url, clock):
    wire = open_wire(url, clock)
    wire.close()
    wire.close()
    clock.ahead += 100.0
    with pytest.raises(LinkError, match="closed"):
        wire.receive()


class Echo:
    """A device that says what it hears."""

    def __init__(self):
        self.said = []

    def send(self, frame):
        self.said.append(frame)

    def receive(self):
        said, self.said = self.said, []
        return said

    def close(self):
        pass


def test_raw_bytes_cross_over_tcp_without_a_greeting(clock):
    side = SerialSide(Echo(), epoch=clock.now())
    with WireServer("127.0.0.1", 0, side, clock) as server:
        wire = open_wire(f"serial:tcp:127.0.0.1:{server.port}", clock)
        wire.send(b"$$\n\x85?")
        got = b""

        def echoed():
            nonlocal got
            side.exchange(float("inf"))
            got += b"".join(wire.receive())
            return got == b"$$\n\x85?"

        wait_for(echoed)
        wire.close()


def test_a_server_that_goes_is_an_error(clock):
    with socket.create_server(("127.0.0.1", 0)) as listener:
        wire = open_wire(f"serial:tcp:127.0.0.1:{listener.getsockname()[1]}", clock)
        listener.accept()[0].close()

        def gone():
            try:
                wire.receive()
            except LinkError as error:
                return str(error)
            return ""

        assert "closed the connection" in wait_for(gone)
        wire.close()


def test_a_pseudo_terminal_serves_one_program_after_the_other(clock):
    side = SerialSide(Echo(), epoch=clock.now())
    with PtyServer(side, clock) as server:
        for _ in range(2):
            wire = open_wire(f"serial:{server.name}:115200", clock)
            wire.send(b"hello\n")
            got = b""

            def echoed(wire=wire):
                nonlocal got
                side.exchange(float("inf"))
                got += b"".join(wire.receive())
                return got == b"hello\n"

            wait_for(echoed)
            wire.close()
