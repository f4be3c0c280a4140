"""Two ground stations with the same ids on a listening port, as QGroundControl and Mission Planner have by default."""

import socket
from types import SimpleNamespace

import pytest

from command_bench import ACCEPTED, IN_PROGRESS, RECORD, STOP, TURN, Payload
from ports import free_port
from ross_payload.config import Config, Link
from ross_payload.config.parameter_store import Parameters
from ross_payload.mavlink import Router
from ross_payload.mavlink.ftp_server import FtpServer
from ross_payload.mavlink.param_server import ParamServer
from ross_payload.orders import TurnTo
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import ross
from ross_protocols.mavlink.ftp import Opcode, Packet, message_of, packet_of
from ross_sim.clock import SimClock

BEAT = ross.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3)


class Datagrams:
    """The port of a ground station."""

    def __init__(self, port):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.setblocking(False)
        self.socket.connect(("127.0.0.1", port))

    def call(self, frame):
        self.socket.send(frame)

    def listen(self):
        found = []
        while True:
            try:
                found.append(self.socket.recv(2048))
            except BlockingIOError:
                return found


@pytest.fixture
def stations(sky):
    """Links of a payload, and two stations that have both been heard; the second one's frames have lower numbers."""
    port, clock = free_port(), SimClock()
    links = Router.open([Link(url=f"udpin::{port}")], clock)
    station_of = type(sky().ground)
    pair = [station_of(Datagrams(port)) for _ in range(2)]
    for station, sequence in zip(pair, (150, 100), strict=True):
        station.mavlink.seq = sequence
        station.send(BEAT)
    links.poll()
    yield SimpleNamespace(clock=clock, links=links, ground=pair[0], other=pair[1])
    links.close()
    for station in pair:
        station.air.socket.close()


def test_what_one_orders_after_the_other_is_obeyed(stations):
    payload = Payload(stations)
    assert payload.command(TURN, 40, seconds=2.0) == [IN_PROGRESS, ACCEPTED]
    stations.ground.send(BEAT)
    payload.ground = stations.other
    payload.ground.listen()  # it hears what the first one is answered, too
    assert payload.command(TURN, -40, seconds=2.0) == [IN_PROGRESS, ACCEPTED]
    assert [type(order) for order in payload.given] == [TurnTo, TurnTo]


def test_what_one_orders_after_a_stop_of_the_other_is_not_taken_for_an_earlier_order(stations):
    payload = Payload(stations)
    assert payload.command(STOP, seconds=0.1) == [ACCEPTED]
    payload.ground = stations.other
    assert payload.command(RECORD, 1, seconds=0.1) == [ACCEPTED]
    assert "refused: sent before the stop" not in "".join(payload.texts)
    payload.ground.long(54009)
    assert payload.results(54009, seconds=0.2)[-1] == ACCEPTED


def test_each_is_told_a_parameter_unasked(stations):
    server = ParamServer(
        stations.links.component(191), Parameters(Config(), None), lambda *change: None, lambda *text: None
    )
    for station in (stations.ground, stations.other):
        stations.other.listen()
        station.send(BEAT)
        station.send(ross.MAVLink_param_request_read_message(1, 99, b"", 0))  # as of an autopilot
        stations.links.poll()
        for _ in range(10):
            stations.clock.advance()
            server.tick(stations.clock.now())
        assert "PARAM_VALUE" in [message.get_type() for message in station.listen()]


def test_what_one_sends_more_often_than_the_other_is_no_loss(stations):
    for _ in range(100):
        for station in (stations.ground, *[stations.other] * 3):
            station.send(BEAT)
            stations.links.poll()
    assert stations.links.status()[0].lost == 0


def test_each_reads_the_file_that_it_has_opened(stations):
    """Both choose session 0, as clients that take a number from the server do."""
    server = FtpServer(stations.links.component(191), {"a": b"A" * 9, "b": b"B" * 9})

    def ask(station, opcode, data=b"", size=0):
        station.listen()
        station.send(message_of(Packet(1, opcode, data=data, size=size or len(data)), ComponentId(1, 191)))
        stations.links.poll()
        server.tick(stations.clock.now())
        return next(packet for message in station.listen() if (packet := packet_of(message)) is not None)

    for station, name in ((stations.ground, b"a"), (stations.other, b"b")):
        assert ask(station, Opcode.OPEN_RO, name).opcode == Opcode.ACK
    assert ask(stations.ground, Opcode.READ, size=9).data == b"A" * 9
    assert ask(stations.other, Opcode.READ, size=9).data == b"B" * 9
    ask(stations.other, Opcode.RESET)
    assert ask(stations.ground, Opcode.READ, size=9).data == b"A" * 9
