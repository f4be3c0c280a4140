"""An actuator's wire to another process: frames exact, every loss of the other end said, nothing waits."""

from __future__ import annotations

import json
import socket
import threading
from contextlib import contextmanager

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ross_payload.actuators.tb6600.options import Options
from ross_payload.actuators.tb6600.pulse_segments import (
    EDGE,
    Level,
    Played,
    PulseCodec,
    PulseLine,
    RanOut,
    RecordingPulses,
    Segment,
)
from ross_payload.actuators.wires import TcpWire, greeting, open_wire
from ross_payload.clock import SystemClock
from ross_payload.errors import ConfigError, LinkError
from ross_sim.devices.far_end import Fault
from ross_sim.devices.ideal import Goal, Halt, IdealFarEnd, Report
from ross_sim.devices.tb6600_far_end import Tb6600FarEnd
from ross_sim.devices.wire_servers import IdealCodec, IdealSide, PulseSide, WireServer, side_of
from waiting import wait_for

CLOCK = SystemClock()
EDGES = np.array([(0.0, 1, True), (20e-6, 0, True), (30e-6, 0, False)], dtype=EDGE)


@contextmanager
def device(greet):
    """A listener that greets one client with these bytes; gives its port and, once connected, the connection."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        connections = []

        def attend():
            connection = listener.accept()[0]
            connection.sendall(greet)
            connections.append(connection)

        thread = threading.Thread(target=attend)
        thread.start()
        yield listener.getsockname()[1], connections
        thread.join(10)
        for connection in connections:
            connection.close()


@contextmanager
def served(side):
    with WireServer("127.0.0.1", 0, side, CLOCK) as server:
        wire = open_wire(f"{side.codec.name}:tcp:127.0.0.1:{server.port}", CLOCK)
        try:
            yield wire, server
        finally:
            wire.close()


@contextmanager
def pair():
    """Both ends of a TCP connection with small buffers."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 8192)
        with socket.create_connection(listener.getsockname(), 10) as ours, listener.accept()[0] as theirs:
            ours.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 8192)
            yield ours, theirs


def same(found, wanted):
    return (found.start, found.duration) == (wanted.start, wanted.duration) and (found.edges == wanted.edges).all()


@given(sizes=st.lists(st.integers(1, 40), min_size=1, max_size=30))
def test_pulses_cross_exactly_in_pieces_of_any_size(sizes):
    reports = [Played(2 / 7), Level(PulseLine.HOME, True, 1 / 7), RanOut(5 / 7), Level(PulseLine.STEP, False, 0.0)]
    sent = [Segment(1 / 3, 0.02, EDGES), *reports, Segment(0.4, 0.0, EDGES[:0])]
    data = b"".join(PulseCodec().pack(frame) for frame in sent)
    codec, got, position = PulseCodec(), [], 0
    for size in [*sizes, len(data)]:
        got += codec.feed(data[position : position + size])
        position += size
    assert same(got[0], sent[0])
    assert got[1:-1] == reports
    assert same(got[-1], sent[-1])


@pytest.mark.parametrize("data", [b"GET / HTTP/1.1\r\n\r\n", b"S" + bytes(16) + b"\xff" * 4, b"L\x09" + bytes(9)])
def test_bytes_that_are_no_pulses_are_refused(data):
    with pytest.raises(LinkError, match="not a frame of pulses"):
        PulseCodec().feed(data)


@pytest.mark.parametrize("frame", [Goal(0.1, 1.0, 2.0), Halt(2.0), Report(0.1, -0.2, 1 / 3)])
def test_goals_halts_and_reports_cross_exactly(frame):
    assert IdealCodec().feed(IdealCodec().pack(frame)) == [frame]


@pytest.mark.parametrize("line", [b"hello", b"[]", b'{"go": {}}', b'{"goal": {"angle": 1}}', b'{"halt": 3}'])
def test_a_line_that_is_no_frame_of_an_ideal_actuator_is_refused(line):
    with pytest.raises(LinkError, match="not a frame"):
        IdealCodec().feed(line + b"\n")


def test_a_segment_is_reported_when_the_clock_has_passed_it_and_played_in_the_time_of_the_world():
    port = RecordingPulses()
    side = PulseSide(port, epoch=CLOCK.now() - 5.0)
    segment = Segment(CLOCK.now(), 0.05, EDGES)
    with served(side) as (wire, _):
        wire.send(segment)
        reports = []
        wait_for(lambda: reports.extend(wire.receive()) or reports)
        assert CLOCK.now() >= segment.end
        assert reports == [Played(segment.end)]
        side.exchange(begin=5.0)
    (played,) = port.sent
    assert played.start == pytest.approx(5.0, abs=1.0)
    assert (played.edges == EDGES).all()


def test_what_the_module_notices_crosses_in_the_time_of_the_clock():
    port, epoch = RecordingPulses(), CLOCK.now() - 5.0
    side = PulseSide(port, epoch)
    with served(side) as (wire, _):
        for report in (Played(4.0), Level(PulseLine.HOME, False, 4.5), RanOut(4.75)):
            port.report(report)
        side.exchange(begin=5.0)
        reports = []
        wait_for(lambda: reports.extend(wire.receive()) or len(reports) == 2)
    assert reports == [Level(PulseLine.HOME, False, 4.5 + epoch), RanOut(4.75 + epoch)]


def test_a_stepper_that_falls_silent_reports_no_segment_to_another_process_either():
    far_end = Tb6600FarEnd.make(Options())
    side = PulseSide(far_end.port, epoch=0.0)
    side.arrived(Segment(1.0, 0.05, EDGES), 0.9)
    for suffers, due in ((True, []), (False, [Played(1.05)])):
        far_end.afflict(Fault.SILENT, on=suffers)
        side.exchange(begin=1.0)
        assert side.due(2.0) == due


def test_a_goal_takes_effect_when_it_has_arrived_and_the_report_tells_the_time_of_both():
    far_end, epoch = IdealFarEnd(), 2000.0  # what is added to it and taken away again stays exact
    side = IdealSide(far_end.port, epoch)
    side.arrived(Goal(1.0, 1.0, 1.0), epoch + 0.5)
    side.exchange(0.49)
    assert far_end.port.sent == []
    side.exchange(0.5)
    assert far_end.port.sent == [Goal(1.0, 1.0, 1.0)]
    far_end.advance(0.51)
    side.exchange(0.51)
    (report,) = side.due(0.0)
    assert report.time == pytest.approx(epoch + 0.51)


def test_the_next_payload_is_served_when_the_first_has_left():
    side = PulseSide(RecordingPulses(), epoch=0.0)
    with WireServer("127.0.0.1", 0, side, CLOCK) as server:
        for _ in range(2):
            wire = open_wire(f"pulses:tcp:127.0.0.1:{server.port}", CLOCK)
            wire.send(Segment(0.0, 0.01, EDGES))
            wait_for(wire.receive)
            wire.close()


def test_a_payload_that_sends_rubbish_is_hung_up_on_and_the_next_one_served():
    side = PulseSide(RecordingPulses(), epoch=0.0)
    with WireServer("127.0.0.1", 0, side, CLOCK) as server:
        with socket.create_connection(("127.0.0.1", server.port), 10) as rude:
            rude.sendall(b"GET / HTTP/1.1\r\n\r\n")
            rude.settimeout(10)
            assert json.loads(rude.recv(200))["ross_wire"] == "pulses"
            wait_for(lambda: not rude.recv(200))
        open_wire(f"pulses:tcp:127.0.0.1:{server.port}", CLOCK).close()


def test_a_device_that_goes_is_said_after_its_last_frame():
    with device(greeting(PulseCodec(), CLOCK)) as (port, connections):
        wire = open_wire(f"pulses:tcp:127.0.0.1:{port}", CLOCK)
        wait_for(lambda: connections)
        connections[0].sendall(PulseCodec().pack(Played(1.0)))
        connections[0].close()
        got = []
        wait_for(lambda: got.extend(wire.receive()) or got)
        with pytest.raises(LinkError, match="closed the connection"):
            wait_for(wire.receive)
        wire.send(Segment(0.0, 0.01, EDGES))  # lost, not raised: whoever sends on the way out must not fall over it
        wire.close()
        wire.close()


def test_all_that_was_sent_arrives_although_the_wire_is_closed_at_once():
    long = Segment(0.0, 10.0, np.zeros(40_000, dtype=EDGE))
    with pair() as (ours, theirs):
        wire = TcpWire(ours, PulseCodec(), "test")
        wire.send(long)
        got, codec = [], PulseCodec()

        def read():
            while data := theirs.recv(65536):
                got.extend(codec.feed(data))

        reader = threading.Thread(target=read)
        reader.start()
        wire.close()
        reader.join(10)
        assert len(got) == 1


def test_a_device_that_does_not_read_is_given_up():
    with pair() as (ours, _):
        wire = TcpWire(ours, PulseCodec(), "test")
        for _ in range(20):
            wire.send(Segment(0.0, 10.0, np.zeros(40_000, dtype=EDGE)))
        with pytest.raises(LinkError, match="does not read"):
            wire.receive()


GREETINGS = {
    "no greeting of a device": b"SSH-2.0-OpenSSH\n",
    "expected pulses version 1, got ideal version 1": greeting(IdealCodec(), CLOCK),
    "it uses a different clock": b'{"ross_wire": "pulses", "version": 1, "now": -1000.0}\n',
    "closed without a greeting": b"",
}


@pytest.mark.parametrize("words", GREETINGS)
def test_somebody_else_at_the_other_end_is_told_apart(words):
    with device(GREETINGS[words]) as (port, connections):
        if not GREETINGS[words]:
            hang_up = threading.Thread(target=lambda: (wait_for(lambda: connections), connections[0].close()))
            hang_up.start()
        with pytest.raises(LinkError, match=words):
            open_wire(f"pulses:tcp:127.0.0.1:{port}", CLOCK)
        if not GREETINGS[words]:
            hang_up.join(10)


def test_nobody_at_the_other_end_is_one_clear_line():
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
    with pytest.raises(LinkError, match="cannot connect"):
        open_wire(f"pulses:tcp:127.0.0.1:{port}", CLOCK)


@pytest.mark.parametrize("url", ["gpio:17", "pulses:gpio17", "pulses:tcp:127.0.0.1", "ideal:udpin:127.0.0.1:1", ""])
def test_a_url_that_names_no_wire_is_refused(url):
    with pytest.raises(ConfigError):
        open_wire(url, CLOCK)


def test_a_scheme_without_a_far_end_is_refused():
    with pytest.raises(ConfigError, match=r"there are: .*ideal"):
        side_of("socketcand", RecordingPulses(), 0.0)
