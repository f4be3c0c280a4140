"""The emulated payloads speak, answer and fail as real ones do, so that what they prove of the ground side holds."""

import socket
import time

import pytest

from fleet_bench import OTHER, FleetThread
from ross_payload.config.parameter_table import TABLE
from ross_payload.ground.model.fleet import Fleet
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common, ross
from ross_protocols.mavlink.values import Heartbeat

TIMEOUT_S = 20.0  # [s]


class Ear:
    """Hears a port, and asks whoever spoke last."""

    def __init__(self):
        self.fleet = Fleet()
        self.heard = []
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", 0))
        self._socket.settimeout(0.2)
        self.port = self._socket.getsockname()[1]
        self._decoder, self._encoder = Decoder(), Encoder(255, 190)
        self._peer = None

    def until(self, claim):
        end = time.monotonic() + TIMEOUT_S
        while not claim():
            assert time.monotonic() < end, "it never became true"
            try:
                data, self._peer = self._socket.recvfrom(4096)
            except TimeoutError:
                continue
            for packet in self._decoder.feed(data):
                self.heard.append(packet)
                self.fleet.on_packet(packet, time.monotonic())

    def ask(self, message):
        self._socket.sendto(self._encoder.encode(message), self._peer)

    def named(self, name):
        return [packet.message for packet in self.heard if packet.name == name]

    def close(self):
        self._socket.close()


@pytest.fixture
def ear():
    ear = Ear()
    yield ear
    ear.close()


def known(ear, system=1):
    return ear.fleet.payloads.get(ComponentId(system, 191))


def test_everything_is_told(ear):
    with FleetThread(ear.port, payloads=2, sources=4):
        ear.until(lambda: known(ear, 1) and known(ear, 2) and known(ear, 2).computer and known(ear, 2).isolations)
    one = known(ear, 2)
    assert (len(one.sources), len(one.densities), len(one.links), one.status.k) == (4, 4, 2, 4)
    assert not one.flaws


def test_a_command_is_answered_to_its_end(ear):
    number = ross.MAV_CMD_ROSS_EXPLORE
    with FleetThread(ear.port):
        ear.until(lambda: known(ear))
        ear.ask(common.MAVLink_command_long_message(1, 191, number, 0, 0, 0, 0, 0, 0, 0, 0))
        ear.until(lambda: any(ack.result == 0 for ack in ear.named("COMMAND_ACK")))
    assert 5 in [ack.result for ack in ear.named("COMMAND_ACK")]  # in progress


@pytest.mark.parametrize(("how", "names"), [("restart", set(TABLE)), ("change", set(OTHER))])
def test_a_start_is_noticed_and_its_parameters_are_told(ear, how, names):
    with FleetThread(ear.port) as bench:
        ear.until(lambda: known(ear) and known(ear).status)
        bench.tell(**{how: [1]})
        ear.until(lambda: known(ear).boots == 2 and known(ear).status)
        ear.ask(common.MAVLink_param_request_list_message(1, 191))
        ear.until(lambda: {value.param_id for value in ear.named("PARAM_VALUE")} == names)


def test_what_goes_wrong_goes_wrong(ear):
    with FleetThread(ear.port, payloads=3) as bench:
        ear.until(lambda: len(ear.fleet.payloads) == 3 and known(ear, 1).status)
        bench.tell(nan=[1], crowd=[2], twin=[3])
        ear.until(lambda: known(ear, 1).flaws and known(ear, 2).announced == 200 and known(ear, 3).twin)
        bench.tell(silence=[1, 2, 3])
        ear.until(lambda: not ear.heard or ear.heard.clear())
        with pytest.raises(AssertionError, match="never"):
            patience(ear, 1.0)
        bench.tell(speak=[2])
        ear.until(lambda: any(isinstance(packet.value, Heartbeat) for packet in ear.heard))


def patience(ear, seconds):
    end = time.monotonic() + seconds

    def spoken():
        assert time.monotonic() < end, "never"
        return ear.heard

    ear.until(spoken)
