"""The CAN wire on python-can's virtual bus, with nodes of the package `dronecan` as neighbours."""

import math
import subprocess
import sys
import time

import pytest

from ross_payload.actuators.dronecan_servo.driver import backend
from ross_payload.actuators.dronecan_servo.options import Options
from ross_payload.actuators.wires import open_wire
from ross_payload.actuators.wires.codecs import CanCodec
from ross_payload.clock import SystemClock
from ross_payload.errors import ConfigError, LinkError
from ross_payload.interfaces import Services
from ross_protocols.can import CanFrame
from ross_sim.clock import QUANTUM, SimClock
from ross_sim.devices.dronecan_far_end import far_end
from ross_sim.devices.wire_servers import WireServer, side_of

can = pytest.importorskip("can")


@pytest.fixture
def channel(request):
    return f"{request.node.name}-{id(request)}"


@pytest.fixture
def bus(channel):
    with can.Bus(channel, "virtual", ignore_config=True) as bus:
        yield bus


@pytest.fixture
def wire(channel):
    port = open_wire(f"can:virtual:{channel}", SystemClock())
    yield port
    port.close()


def test_frames_cross_both_ways(bus, wire):
    wire.send(CanFrame(0x1234567, b"abc"))
    there = bus.recv(1.0)
    assert (there.arbitration_id, bytes(there.data), there.is_extended_id) == (0x1234567, b"abc", True)
    bus.send(can.Message(arbitration_id=0x89, data=b"xy", is_extended_id=True))
    assert wire.receive() == [CanFrame(0x89, b"xy")]


def test_short_identifiers_cross_both_ways(bus, wire):
    wire.send(CanFrame(0x601, b"abc", extended=False))
    there = bus.recv(1.0)
    assert (there.arbitration_id, bytes(there.data), there.is_extended_id) == (0x601, b"abc", False)
    bus.send(can.Message(arbitration_id=0x581, data=b"xy", is_extended_id=False))
    assert wire.receive() == [CanFrame(0x581, b"xy", extended=False)]


def test_other_kinds_of_frames_are_not_ours(bus, wire):
    bus.send(can.Message(arbitration_id=0x89, is_remote_frame=True))
    bus.send(can.Message(arbitration_id=0x89, is_error_frame=True))
    assert wire.receive() == []


def test_looking_at_a_silent_bus_never_waits(bus, wire):
    begin = time.monotonic()
    for _ in range(200):
        assert wire.receive() == []
    assert time.monotonic() - begin < 20.0  # 0.1 s a look, on a computer that has much else to do


def test_looking_at_a_silent_bus_never_waits_for_a_clock_that_is_set_back_meanwhile(wire, monkeypatch):
    times = iter([5.0, 2.0])
    monkeypatch.setattr("can.bus.time", lambda: next(times, 9.0))
    begin = time.monotonic()
    assert wire.receive() == []
    assert time.monotonic() - begin < 2.0


def test_closing_twice_is_once(wire):
    wire.close()
    wire.close()


def test_a_bus_that_is_gone_is_a_link_error(wire):
    wire.close()
    with pytest.raises(LinkError, match="is down"):
        wire.receive()
    with pytest.raises(LinkError, match="takes no frames"):
        for _ in range(10):
            wire.send(CanFrame(1, b""))


@pytest.mark.parametrize(
    ("url", "words"),
    [
        ("can:virtual", r"expected can:INTERFACE:CHANNEL\[:BITRATE\] or can:tcp"),
        ("can:virtual:x:fast", "expected can:INTERFACE:CHANNEL"),
        ("can:carrier_pigeon:x", "'carrier_pigeon' cannot be used; there are: .*socketcan"),
        ("can:udp_multicast:239.0.0.1", "cannot be used"),
    ],
)
def test_a_wrong_url_says_what_was_wanted(url, words):
    with pytest.raises(ConfigError, match=words):
        open_wire(url, SystemClock())


def test_a_bus_that_is_not_there_cannot_be_joined():
    with pytest.raises(LinkError, match="cannot join the bus"):
        open_wire("can:socketcan:nosuchcan9", SystemClock())


def test_the_driver_turns_a_servo_made_of_the_package_dronecan(bus, channel):
    """A servo of three lines: it stands where it was told last, and says so."""
    dronecan = pytest.importorskip("dronecan")
    transport, place = dronecan.transport, [0.0]
    status = dronecan.uavcan.equipment.actuator.Status
    number = 0

    def servo(now):
        nonlocal number
        number += 1
        while (heard := bus.recv(0)) is not None:
            transfer = transport.Transfer()
            transfer.from_frames([transport.Frame(heard.arbitration_id, heard.data)])
            if hasattr(transfer.payload, "commands"):
                place[0] = transfer.payload.commands[0].command_value
        report = status(actuator_id=1, position=place[0], force=math.nan, speed=math.nan, power_rating_pct=127)
        for frame in transport.Transfer(number, source_node_id=50, payload=report).to_frames():
            bus.send(can.Message(arbitration_id=frame.message_id, data=frame.bytes, is_extended_id=True))

    clock = SimClock()
    clock.before_calls(servo)
    options = Options(port=f"can:virtual:{channel}", command="position")
    with backend.open(options, Services(clock, lambda url: open_wire(url, clock))) as driver:
        cancel = clock.every(QUANTUM, lambda: driver.poll(clock.now()))
        clock.sleep(0.2)
        driver.command(1.0)
        clock.sleep(2.5)
        cancel()
        assert driver.state().settled
        assert place[0] == pytest.approx(1.0, abs=0.001)


def test_a_servo_in_another_process_is_turned_over_tcp():
    clock, options = SystemClock(), Options()
    servo, epoch = far_end.make(options), clock.now()
    side = side_of("can", servo.port, epoch)
    with WireServer("127.0.0.1", 0, side, clock) as server:
        there = options.model_copy(update={"port": f"can:tcp:127.0.0.1:{server.port}"})
        with backend.open(there, Services(clock, lambda url: open_wire(url, clock))) as driver:
            deadline, told = clock.now() + 60, False
            while not (told and driver.state().settled):
                assert clock.now() < deadline, driver.state()
                clock.sleep(0.005)
                side.exchange(clock.now() - epoch)
                servo.advance(round(clock.now() - epoch, 3))
                driver.poll(clock.now())
                if driver.state().homed and not told:
                    driver.command(0.2)
                    told = True
    assert servo.angle() == pytest.approx(0.2, abs=options.resolution)


DRIVE = """
from ross_payload.actuators.dronecan_servo.options import Options
from ross_payload.actuators.dronecan_servo.driver import backend
from ross_payload.actuators.wires import open_wire
from ross_payload.clock import SystemClock
from ross_payload.interfaces import Services

clock, told = SystemClock(), False
with backend.open(Options(port={url!r}), Services(clock, lambda url: open_wire(url, clock))) as driver:
    while True:
        driver.poll(clock.now())
        if driver.state().homed and not told:
            driver.command(3.0, 0.5)
            told = True
        clock.sleep(0.005)
"""


def looks(count):
    """Say whether it was asked so often."""
    asked = iter(range(count))
    return lambda: next(asked, None) is None


def test_when_our_process_is_killed_the_servo_stops_at_the_last_set_point():
    clock = SystemClock()
    servo, epoch = far_end.make(Options()), clock.now()
    side = side_of("can", servo.port, epoch)

    def live(until):
        deadline = clock.now() + 60
        while not until():
            assert clock.now() < deadline
            clock.sleep(0.005)
            side.exchange(clock.now() - epoch)
            servo.advance(round(clock.now() - epoch, 3))

    with WireServer("127.0.0.1", 0, side, clock) as server:
        script = DRIVE.format(url=f"can:tcp:127.0.0.1:{server.port}")
        with subprocess.Popen([sys.executable, "-c", script]) as payload:
            live(lambda: servo.angle() > 0.3)
            here, since = servo.angle(), clock.now()
            payload.kill()
        killed = clock.now()
        live(looks(200))  # and no time: this process may have been held up for a second
        stopped = servo.angle()
        live(looks(200))
    assert servo.angle() == pytest.approx(stopped, abs=1e-9)
    assert stopped - here < 0.5 * (killed - since + 0.2)  # what was on its way, at 0.5 rad/s


@pytest.mark.parametrize("damaged", [b"\0\x08" + bytes(14), b"\x01\0\0\x80\x09" + bytes(11), b"\xff" * 16])
def test_bytes_that_are_no_frame_are_a_link_error(damaged):
    with pytest.raises(LinkError, match="not a CAN frame"):
        CanCodec().feed(damaged)
