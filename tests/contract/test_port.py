"""What every port of a link promises, on real sockets and pseudo terminals, with its far end alive, deaf and gone."""

import contextlib
import os
import pty
import socket
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass

import pytest

from ports import free_port
from ross_payload.clock import SystemClock
from ross_payload.transport.open_port import open_port
from ross_payload.transport.ports import Transport
from waiting import wait_for

FRAMES = [bytes([0xFD, 200, 0, 0, number, 1, 191, 1, 0, 0]) + bytes([number]) * 202 for number in range(50)]


@dataclass
class Rig:
    """A port and its far end."""

    port: Transport
    say: Callable[[bytes], object]
    hear: Callable[[], bytes]  # what has arrived there, maybe nothing


def hearing(read: Callable[[], bytes]) -> Callable[[], bytes]:
    def hear() -> bytes:
        with contextlib.suppress(BlockingIOError):
            return read()
        return b""

    return hear


def udpout(stack: ExitStack, patient: bool) -> Rig:
    far = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
    far.bind(("127.0.0.1", 0))
    port = open_port(f"udpout:127.0.0.1:{far.getsockname()[1]}", SystemClock().now, patient=patient)
    wait_for(lambda: port.receive() or port.counts.up)
    port.send(b"hello")
    far.settimeout(20.0)
    _, where = far.recvfrom(2048)
    far.setblocking(False)
    return Rig(port, lambda data: far.sendto(data, where), hearing(lambda: far.recv(2048)))


def udpin(stack: ExitStack, patient: bool) -> Rig:
    where = ("127.0.0.1", free_port())
    port = open_port(f"udpin::{where[1]}", SystemClock().now, patient=patient)
    far = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
    far.setblocking(False)
    far.sendto(b"hello", where)
    wait_for(port.receive)
    return Rig(port, lambda data: far.sendto(data, where), hearing(lambda: far.recv(2048)))


def tcp(stack: ExitStack, patient: bool) -> Rig:
    server = stack.enter_context(socket.create_server(("127.0.0.1", 0)))
    port = open_port(f"tcp:127.0.0.1:{server.getsockname()[1]}", SystemClock().now, patient=patient)
    wait_for(lambda: port.receive() or port.counts.up)
    far = stack.enter_context(server.accept()[0])
    far.setblocking(False)
    return Rig(port, far.send, hearing(lambda: far.recv(65536)))


def tcpin(stack: ExitStack, patient: bool) -> Rig:
    number = free_port()
    port = open_port(f"tcpin::{number}", SystemClock().now, patient=patient)
    far = stack.enter_context(socket.create_connection(("127.0.0.1", number)))
    far.setblocking(False)
    far.send(FRAMES[0])
    wait_for(port.receive)
    return Rig(port, far.send, hearing(lambda: far.recv(65536)))


def serial(stack: ExitStack, patient: bool) -> Rig:
    far, near = pty.openpty()
    stack.callback(os.close, far)
    stack.callback(os.close, near)
    os.set_blocking(far, False)
    port = open_port(f"serial:{os.ttyname(near)}:57600", SystemClock().now, patient=patient)
    return Rig(port, lambda data: os.write(far, data), hearing(lambda: os.read(far, 65536)))


@pytest.fixture(params=[False, True], ids=["impatient", "patient"])
def patient(request: pytest.FixtureRequest) -> bool:
    return bool(request.param)


@pytest.fixture(params=[udpout, udpin, tcp, tcpin, serial], ids=lambda maker: maker.__name__)
def rig(request: pytest.FixtureRequest, patient: bool) -> Iterator[Rig]:
    with ExitStack() as stack:
        rig = request.param(stack, patient)
        stack.callback(rig.port.close)
        yield rig


def test_frames_go_out_whole_and_in_order(rig: Rig) -> None:
    got = b""
    for frame in FRAMES:
        rig.port.send(frame)
        while len(piece := rig.hear()) or frame not in got:
            got += piece
            rig.port.receive()
    assert got == b"".join(FRAMES)


def test_frames_come_in_whole_and_in_order(rig: Rig) -> None:
    got: list[bytes] = []
    for frame in FRAMES:
        rig.say(frame)
        wait_for(lambda frame=frame: got.extend(rig.port.receive()) or b"".join(got).endswith(frame))
    assert b"".join(got) == b"".join(FRAMES)


def test_nothing_to_hear_is_nothing_at_once(rig: Rig) -> None:
    assert rig.port.receive() == []


def test_a_far_end_that_does_not_read_holds_nobody_up(rig: Rig) -> None:
    before = rig.port.counts
    worked = time.thread_time()
    for _ in range(100):
        for frame in FRAMES:
            rig.port.send(frame)
    assert time.thread_time() - worked < 5.0
    after = rig.port.counts
    handed, failed = after.sent - before.sent, after.dropped + after.failed - before.dropped - before.failed
    assert handed + failed == 100 * len(FRAMES), "each frame is counted once"


def test_after_closing_nothing_happens_and_nothing_is_raised(rig: Rig) -> None:
    rig.port.close()
    rig.port.close()
    rig.port.send(FRAMES[0])
    assert rig.port.receive() == []
