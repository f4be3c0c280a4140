"""The simulated autopilot passes on what an ArduPilot would, and nothing else."""

import math
import socket
import subprocess
import time

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from ports import free_port
from processes import ROSS
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.dialect import ross
from ross_protocols.mavlink.values import Health, Heartbeat
from ross_protocols.mavlink.vehicle import euler
from ross_sim.autopilot.simulated_autopilot import BOOT, Autopilot, CarriedGimbal
from ross_sim.autopilot.yaw import Yaw
from ross_sim.clock import SimClock
from ross_sim.devices.far_end import wire

PAYLOAD, GROUND, OTHER = (1, 191), (255, 190), (254, 190)
TEXT = mavlink.MAVLink_statustext_message(6, b"hello")
NAMED = mavlink.MAVLink_named_value_float_message(0, b"K", 3.0)
ARRAY = mavlink.MAVLink_debug_float_array_message(0, b"a", 0)


def tunnel(system, component):
    return mavlink.MAVLink_tunnel_message(system, component, 32768, 3, [1, 2, 3] + [0] * 125)


class Party:
    """Whoever speaks and listens at the end of a link."""

    def __init__(self, clock, autopilot, name, who):
        self.port, far = wire(clock, 0.0, 0.0, seed=0)
        autopilot.plug(name, far)
        self.encoder, self.decoder = Encoder(*who), Decoder()

    def say(self, *messages):
        for message in messages:
            self.port.send(self.encoder.encode(message))

    def heard(self):
        return [packet for data in self.port.receive() for packet in self.decoder.feed(data)]

    def names(self, of=None):
        return [packet.name for packet in self.heard() if of in (None, (packet.system_id, packet.component_id))]


class Air:
    """An autopilot with three links."""

    def __init__(self):
        self.clock = SimClock()
        self.autopilot = Autopilot(Yaw())
        self.clock.every(0.01, lambda: self.autopilot.advance(self.clock.now()))
        self.payload, self.ground, self.other = (
            Party(self.clock, self.autopilot, name, who)
            for name, who in (("payload", PAYLOAD), ("ground", GROUND), ("other", OTHER))
        )

    def greet(self):
        """Let everybody be heard once."""
        for party in (self.payload, self.ground, self.other):
            party.say(Heartbeat(Health.ACTIVE, state=0))
        self.pass_time()
        for party in (self.payload, self.ground, self.other):
            party.heard()

    def pass_time(self, seconds=0.03):
        self.clock.sleep(seconds)


@pytest.fixture
def air():
    made = Air()
    made.greet()
    return made


@pytest.mark.parametrize("message", [TEXT, NAMED, ARRAY, tunnel(0, 0)])
def test_what_an_ardupilot_knows_is_passed_on_to_everybody_else(air, message):
    air.payload.say(message)
    air.pass_time()
    assert air.ground.names(PAYLOAD) == air.other.names(PAYLOAD) == [message.get_type()]


def test_nothing_goes_back_to_where_it_came_from(air):
    air.payload.say(TEXT, NAMED)
    air.pass_time()
    assert not air.payload.names(PAYLOAD)


def test_messages_of_our_dialect_are_dropped(air):
    air.payload.say(ross.MAVLink_ross_status_message(**dict.fromkeys(ross.MAVLink_ross_status_message.fieldnames, 0)))
    air.payload.say(TEXT)
    air.pass_time()
    assert air.ground.names(PAYLOAD) == ["STATUSTEXT"]


def test_what_has_a_target_goes_only_where_that_component_was_heard(air):
    air.payload.say(tunnel(*GROUND))
    air.pass_time()
    assert air.ground.names(PAYLOAD) == ["TUNNEL"]
    assert not air.other.names(PAYLOAD)


def test_what_has_a_target_that_nobody_has_heard_goes_nowhere(air):
    air.ground.say(tunnel(9, 9))
    air.pass_time()
    assert not air.payload.names(GROUND)
    assert not air.other.names(GROUND)


def test_nothing_goes_to_a_link_on_which_nobody_was_heard():
    air = Air()
    air.payload.say(Heartbeat(Health.ACTIVE, state=0), TEXT)
    air.pass_time()
    assert not air.ground.names(PAYLOAD)


def test_frames_are_passed_on_as_they_came(air):
    """Also signed ones: 13 bytes more, which only their receiver can judge."""
    signer = mavlink.MAVLink(None, *PAYLOAD)
    signer.signing.secret_key, signer.signing.sign_outgoing, signer.signing.link_id = bytes(range(32)), True, 1
    signer.signing.timestamp = 1
    frame = bytes(TEXT.pack(signer))
    air.payload.port.send(frame)
    air.pass_time()
    assert frame in air.ground.port.receive()


def test_commands_are_for_their_target_only(air):
    ask = mavlink.MAVLink_command_long_message(*PAYLOAD, 512, 0, 397, 0, 0, 0, 0, 0, 0)
    air.ground.say(ask)
    air.pass_time()
    assert air.payload.names(GROUND) == ["COMMAND_LONG"]
    assert "COMMAND_ACK" not in air.ground.names((1, 1))


def answer(air, command, *parameters):
    values = [*parameters, *(0.0,) * (7 - len(parameters))]
    air.ground.say(mavlink.MAVLink_command_long_message(1, 1, command, 0, *values))
    air.pass_time()
    return [packet.message.result for packet in air.ground.heard() if packet.name == "COMMAND_ACK"]


def test_the_rate_of_attitudes_is_what_somebody_asked_for(air):
    assert answer(air, 511, 30, 20_000) == [mavlink.MAV_RESULT_ACCEPTED]
    air.pass_time(2.0)
    assert air.ground.names().count("ATTITUDE") == pytest.approx(100, abs=2)
    assert air.other.names().count("ATTITUDE") == pytest.approx(8, abs=1)
    assert answer(air, 511, 30, -1) == [mavlink.MAV_RESULT_ACCEPTED]
    air.ground.heard()
    air.pass_time(1.0)
    assert "ATTITUDE" not in air.ground.names()


@pytest.mark.parametrize("command", [(400, 1), (511, 24, 1000)])
def test_what_it_cannot_do_it_says(air, command):
    assert answer(air, *command) == [mavlink.MAV_RESULT_UNSUPPORTED]


@pytest.mark.parametrize("number", [283, 24, float("nan")])
def test_a_message_that_it_cannot_give_fails(air, number):
    assert answer(air, 512, number) == [mavlink.MAV_RESULT_FAILED]


class Carrier(Air):
    """An autopilot that carries a gimbal and manages it."""

    def __init__(self):
        super().__init__()
        carried = CarriedGimbal(self.clock, 1, lambda now: 0.0, BOOT)
        self.autopilot = Autopilot(Yaw(), manager=carried.manager)
        self.autopilot.plug("gimbal", carried.port)
        self.clock.every(0.01, lambda: carried.advance(self.clock.now()))
        self.clock.every(0.01, lambda: self.autopilot.advance(self.clock.now()))
        self.payload, self.ground, self.other = (
            Party(self.clock, self.autopilot, name, who)
            for name, who in (("payload", PAYLOAD), ("ground", GROUND), ("other", OTHER))
        )

    def yaw(self):
        """Where the gimbal says that it is [deg], clockwise."""
        said = [packet.message for packet in self.ground.heard() if packet.name == "GIMBAL_DEVICE_ATTITUDE_STATUS"]
        return math.degrees(euler(said[-1].q)[0])


@pytest.fixture
def carrier():
    made = Carrier()
    made.greet()
    made.pass_time(1.5)
    return made


def test_a_gimbal_that_it_carries_is_turned_by_anybody_and_reports_to_everybody(carrier):
    assert answer(carrier, 1000, 0.0, 50.0, math.nan, math.nan, 12.0) == [mavlink.MAV_RESULT_ACCEPTED]
    carrier.pass_time(3.0)
    assert carrier.yaw() == pytest.approx(50.0, abs=0.5)
    assert "GIMBAL_DEVICE_ATTITUDE_STATUS" in carrier.payload.names((1, 154))
    assert "GIMBAL_DEVICE_SET_ATTITUDE" not in carrier.payload.names((1, 1))


def test_as_a_gimbal_manager_it_records_control_and_tells_it_to_everybody_on_change(carrier):
    assert answer(carrier, 1001, -2.0, -2.0, -1.0, -1.0) == [mavlink.MAV_RESULT_ACCEPTED]
    carrier.pass_time(1.0)
    said = [one.message for one in carrier.payload.heard() if one.name == "GIMBAL_MANAGER_STATUS"]
    assert [(one.primary_control_sysid, one.primary_control_compid) for one in said] == [GROUND]
    assert answer(carrier, 512, 280) == [mavlink.MAV_RESULT_ACCEPTED]
    assert answer(carrier, 512, 283) == [mavlink.MAV_RESULT_FAILED]


def test_a_time_request_is_answered_by_the_autopilots_clock(air):
    air.payload.say(mavlink.MAVLink_timesync_message(0, 1234))
    air.pass_time()
    (said,) = [packet.message for packet in air.payload.heard() if packet.name == "TIMESYNC"]
    assert (said.ts1, said.tc1 / 1e9) == (1234, pytest.approx(air.clock.now() + 100.0, abs=0.05))


def test_heartbeat_time_and_attitude_come_unasked(air):
    air.pass_time(10.0)
    names = air.ground.names((1, 1))
    counts = {name: names.count(name) for name in ("HEARTBEAT", "SYSTEM_TIME", "ATTITUDE", "TIMESYNC")}
    assert counts["HEARTBEAT"] == pytest.approx(10, abs=1)
    assert counts["SYSTEM_TIME"] == pytest.approx(10, abs=1)
    assert counts["ATTITUDE"] == pytest.approx(40, abs=2)
    assert counts["TIMESYNC"] == 1


def test_as_a_process_it_passes_messages_between_sockets():
    ports = free_port(), free_port()
    links = [part for port in ports for part in ("--link", f"udpin:127.0.0.1:{port}")]
    command = [*ROSS, "autopilot", *links]
    with (
        subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as payload,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as ground,
    ):
        try:
            assert process.stdout.readline() == "ready\n"
            encoders, decoder, heard = (Encoder(*PAYLOAD), Encoder(*GROUND)), Decoder(), set()
            ground.settimeout(0.2)
            deadline = time.monotonic() + 30
            while not {(1, 1, "ATTITUDE"), (*PAYLOAD, "STATUSTEXT")} <= heard and time.monotonic() < deadline:
                ground.sendto(encoders[1].encode(Heartbeat(Health.ACTIVE, state=0)), ("127.0.0.1", ports[1]))
                payload.sendto(encoders[0].encode(TEXT), ("127.0.0.1", ports[0]))
                try:
                    packets = decoder.feed(ground.recv(4096))
                except TimeoutError:
                    continue
                heard |= {(packet.system_id, packet.component_id, packet.name) for packet in packets}
        finally:
            process.terminate()
            process.communicate(timeout=30)
    assert {(1, 1, "ATTITUDE"), (*PAYLOAD, "STATUSTEXT")} <= heard
