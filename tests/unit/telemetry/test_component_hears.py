"""The MAVLink component on its links: what the ground asks, and how things stand."""

from dataclasses import replace

import pytest

from ross_payload.config import Config, Link
from ross_payload.config.parameter_store import Parameters
from ross_payload.config.parameter_table import TABLE
from ross_payload.events import Answer, Answered
from ross_payload.health import AudioHealth, AudioTrouble, RecordingState, RecordingStatus
from ross_payload.interfaces import ActuatorState, Capabilities, Feedback
from ross_payload.mavlink.component_info import files
from ross_payload.telemetry.snapshot import information
from ross_payload.timebase import Timebase
from ross_protocols.mavlink import values as v
from ross_protocols.mavlink.codec import Encoder
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common, ross
from ross_protocols.mavlink.ftp import Opcode, Packet, message_of, packet_of
from ross_sim.clock import SimClock

GROUND = Link(url="udpout:127.0.0.1:14550")
RADIO = Link(url="udpout:127.0.0.1:14551", max_bytes_s=350)


# ---------------------------------------------------------------------------------------------------- what comes in


def test_a_command_becomes_an_order_and_its_answer_an_acknowledgement(aloft) -> None:
    orders: list = []
    with aloft(GROUND, give=orders.append) as sky:
        sky.ports[0].call(common.MAVLink_command_long_message(1, 191, ross.MAV_CMD_ROSS_EXPLORE, 0, *[0] * 7))
        sky.live(0.05)
        sky.telemetry.on_event(Answered(0.0, orders[0].number, Answer.ACCEPTED), sky.hop())
        sky.live(0.1)
        sky.telemetry.on_event(Answered(0.0, orders[0].number, Answer.DONE), sky.hop())
        sky.live(0.1)
    results = [ack.result for ack in sky.ports[0].messages("COMMAND_ACK")]
    assert results[0] == common.MAV_RESULT_IN_PROGRESS
    assert results[-1] == common.MAV_RESULT_ACCEPTED


def test_parameters_are_listed_and_a_rate_is_set_in_flight(aloft) -> None:
    told: list = []
    with (
        Parameters(Config()) as parameters,
        aloft(GROUND, parameters=parameters, changed=lambda *change: told.append(change)) as sky,
    ):
        sky.ports[0].call(common.MAVLink_param_request_list_message(1, 191))
        sky.live(3.0)
        assert len({value.param_id for value in sky.ports[0].messages("PARAM_VALUE")}) == len(TABLE)
        sky.ports[0].call(common.MAVLink_param_set_message(1, 191, b"TLM_STATUS_HZ", 1.0, 9))
        sky.ports[0].call(common.MAVLink_param_set_message(1, 191, b"XPL_CRITERION", 2.5, 9))
        sky.live(2.0)
        sky.ports[0].packets.clear()
        sky.live(10.0)
    assert told == [("TLM_STATUS_HZ", 1.0), ("XPL_CRITERION", 2.5)]
    assert len(sky.ports[0].values(v.Status)) == pytest.approx(10, abs=1)
    assert sky.ports[0].values(v.Status)[-1].criterion == 2.5


def test_how_many_sources_may_be_found_depends_on_the_explorer() -> None:
    told = {method: Config.model_validate({"explore": {"method": method}}) for method in ("joint", "markov", "mine")}
    assert [information(config, None, 0).k_max for config in told.values()] == [6, 16, 16]


def test_each_link_is_told_as_often_as_it_asks_for(aloft) -> None:
    with aloft(GROUND, RADIO, give=lambda order: None) as sky:
        sky.live(1.0)
        interval = common.MAVLink_command_long_message(1, 191, 511, 0, 54001, 1e6, 0, 0, 0, 0, 0)
        sky.ports[1].call(interval)
        sky.live(1.0)
        for port in sky.ports:
            port.packets.clear()
        sky.live(10.0)
    rich, radio = (len(port.values(v.Status)) for port in sky.ports)
    assert (rich, radio) == (pytest.approx(40, abs=1), pytest.approx(10, abs=1))


def test_a_file_is_read_on_a_slow_link_on_which_more_waits_than_it_carries(aloft) -> None:
    """A portion takes most of what 350 bytes/s may save up: what repeats itself leaves it the room."""
    with aloft(RADIO, give=lambda order: None) as sky:
        (port,) = sky.ports
        sky.live(0.1)
        port.call(common.MAVLink_command_long_message(1, 191, 511, 0, 54001, 50_000, 0, 0, 0, 0, 0))
        sky.live(5.0)
        port.packets.clear()
        port.call(message_of(Packet(3, Opcode.OPEN_RO, size=14, data=b"parameter.json"), ComponentId(1, 191)))
        for number in range(10):
            port.call(message_of(Packet(5 + number, Opcode.READ, size=239, offset=239 * number), ComponentId(1, 191)))
        sent = sky.links.status()[0].sent_bytes
        sky.live(20.0)
        spent = sky.links.status()[0].sent_bytes - sent
    told = [packet_of(message) for message in port.messages("FILE_TRANSFER_PROTOCOL")]
    assert b"".join(answer.data for answer in told if answer.asked == Opcode.READ) == files()["parameter.json"][:2390]
    assert spent < 20 * 350 + 300
    assert len(port.values(v.Heartbeat)) >= 19
    assert len(port.values(v.Status)) >= 10
    assert sky.links.status()[0].dropped == 0


def opened(sky):
    """Open the parameters as a file; return the port of who reads them."""
    (port,) = sky.ports
    sky.live(5.0)
    port.call(message_of(Packet(3, Opcode.OPEN_RO, size=14, data=b"parameter.json"), ComponentId(1, 191)))
    return port


def test_a_portion_that_is_asked_for_again_while_it_waits_is_sent_once(aloft) -> None:
    """A client that waits a second for an answer asks for it twenty times before a slow link has carried ten."""
    with aloft(RADIO, give=lambda order: None) as sky:
        port = opened(sky)
        port.packets.clear()
        for number in range(40):
            request = Packet(5 + number, Opcode.READ, size=239, offset=239 * (number % 10))
            port.call(message_of(request, ComponentId(1, 191)))
            sky.live(0.1)
        sky.live(40.0)
    told = [packet_of(message) for message in port.messages("FILE_TRANSFER_PROTOCOL")]
    offsets = [answer.offset for answer in told if answer.asked == Opcode.READ]
    assert set(offsets) == {239 * number for number in range(10)}
    assert len(offsets) <= 16


def test_who_asks_for_portions_without_end_leaves_a_slow_link_half_for_the_rest(aloft) -> None:
    with aloft(RADIO, give=lambda order: None) as sky:
        port = opened(sky)
        sky.live(1.0)
        port.packets.clear()
        for number in range(300):
            request = Packet(5 + number, Opcode.READ, size=239, offset=239 * (number % 16))
            port.call(message_of(request, ComponentId(1, 191)))
            sky.live(0.1)
    portions = len(port.messages("FILE_TRANSFER_PROTOCOL"))
    assert 14 <= portions <= 0.5 * 350 * 30 / 266 + 1
    assert len(port.values(v.Status)) >= 20
    assert len(port.values(v.Heartbeat)) >= 29


def test_a_command_is_answered_while_a_file_takes_its_share_of_a_slow_link(aloft) -> None:
    with aloft(RADIO, give=lambda order: None) as sky:
        port = opened(sky)
        port.packets.clear()
        for number in range(300):
            if number % 20 == 0:
                port.call(message_of(Packet(5 + number, Opcode.BURST_READ, size=239), ComponentId(1, 191)))
            if number % 7 == 0:
                port.call(common.MAVLink_command_long_message(1, 191, ross.MAV_CMD_ROSS_RECORD, 0, *[0] * 7))
            sky.live(0.1)
    assert len(port.messages("FILE_TRANSFER_PROTOCOL")) > 15
    assert len(port.messages("COMMAND_ACK")) == 43
    assert sky.links.status()[0].dropped == 0


def test_nobody_can_silence_a_heartbeat(aloft) -> None:
    with aloft(GROUND, give=lambda order: None) as sky:
        sky.live(1.0)
        for interval in (-1, 3e6, 3.6e9):
            sky.ports[0].call(common.MAVLink_command_long_message(1, 191, 511, 0, 0, interval, 0, 0, 0, 0, 0))
        sky.live(1.0)
        sky.ports[0].packets.clear()
        sky.live(10.0)
    assert len(sky.ports[0].values(v.Heartbeat)) >= 9


def test_a_payload_with_another_dialect_is_named_once(aloft) -> None:
    stranger = replace(information(Config(), None, 0), dialect_version=99)
    with aloft(GROUND) as sky:
        for _ in range(3):
            sky.ports[0].call(None, Encoder(2, 191).encode(stranger))
            sky.ports[0].call(None, Encoder(3, 191).encode(information(Config(), None, 0)))
            sky.live(0.5)
    said = [text for text in sky.ports[0].texts() if "dialect" in text]
    assert said == [f"RoSS: payload 2/191: dialect 99, expected {v.DIALECT_VERSION}"]


def test_somebody_else_with_our_component_id_is_said_once(aloft) -> None:
    with aloft(GROUND) as sky:
        twin = Encoder(1, 191)
        for _ in range(5):
            sky.ports[0].call(None, twin.encode(v.Heartbeat(v.Health.ACTIVE, 6)))
            sky.live(1.0)
    said = "".join(sky.ports[0].texts())
    assert said == "RoSS: another sender uses our component id 191: change one"


AUTOPILOT = Link(url="udpin:127.0.0.1:14540", role="autopilot")
BEAT = common.MAVLink_heartbeat_message(2, 3, 0, 0, 3, 3)


def test_an_autopilot_of_another_system_is_told_of_once_and_in_the_log(aloft, caplog) -> None:
    with aloft(GROUND, AUTOPILOT) as sky:
        for _ in range(14):
            sky.ports[1].call(None, Encoder(5, 1).encode(BEAT))
            sky.live(1.0)
    said = "RoSS: autopilot ignored: its system id is 5, not 1"
    assert [text for text in sky.ports[0].texts() if "autopilot" in text] == [said]
    assert [record.message for record in caplog.records if "autopilot" in record.message] == [
        said.removeprefix("RoSS: ")
    ]


@pytest.mark.parametrize("ids", [(1, 5), (5, 1), (5, 200)])
def test_other_autopilots_beside_ours_and_what_is_none_are_not_told_of(aloft, ids) -> None:
    no_autopilot = common.MAVLink_heartbeat_message(6, 8, 0, 0, 3, 3)
    with aloft(GROUND, AUTOPILOT) as sky:
        for _ in range(14):
            for system in ids:
                sky.ports[1].call(None, Encoder(system, 1).encode(BEAT if 1 in ids else no_autopilot))
            sky.live(1.0)
    assert not [text for text in sky.ports[0].texts() if "autopilot" in text]


# ---------------------------------------------------------------------------------------------------- how things stand


class Motor:
    """An actuator that stands where it is put."""

    capabilities = Capabilities(-2.0, 2.0, 4.0, 2.0, 0.002, continuous=False, feedback=Feedback.MODEL)

    def __init__(self) -> None:
        self.now = ActuatorState(0.01, 0.0, settled=True, homed=True, healthy=True, time=0.0)

    def state(self) -> ActuatorState:
        return self.now


def test_before_anything_was_heard_the_actuator_speaks(aloft) -> None:
    motor = Motor()
    with aloft(GROUND, actuator=motor) as sky:
        sky.clock.sleep(0.5)
    status = sky.ports[0].values(v.Status)[-1]
    assert (status.actuator_present, status.homed, status.open_loop) == (True, True, True)
    assert (status.joint, status.heading) == (pytest.approx(0.01), None)


def test_while_the_mission_computes_the_array_is_seen_to_turn(aloft) -> None:
    motor = Motor()
    with aloft(GROUND, actuator=motor) as sky:
        sky.telemetry.on_input(sky.hop(start=0.51, end=0.51))
        sky.clock.sleep(0.5)
        motor.now = replace(motor.now, angle=0.61, rate=1.5)
        sky.clock.sleep(0.5)
    status = sky.ports[0].values(v.Status)[-1]
    assert (status.joint, status.joint_rate) == pytest.approx((0.61, 1.5))
    assert status.heading == pytest.approx(0.61), "0.1 rad on from what was heard, at joint angle 0.51"


def test_a_fault_is_said_once_and_flagged_while_it_lasts(aloft) -> None:
    with aloft(GROUND) as sky:
        sky.telemetry.on_input(sky.hop(fault="the motor is hot"))
        sky.clock.sleep(3.0)
        assert sky.ports[0].texts() == ["RoSS: fault: the motor is hot"]
        assert sky.ports[0].values(v.Status)[-1].fault
        sky.telemetry.on_input(sky.hop())
        sky.clock.sleep(0.5)
    assert not sky.ports[0].values(v.Status)[-1].fault


def test_a_fault_that_lasts_is_said_once_whatever_is_measured_of_it(aloft) -> None:
    """As of an actuator that was unplugged: the operator got twelve texts in a second."""
    with aloft(GROUND) as sky:
        for hundredth in range(50, 350):
            sky.telemetry.on_input(sky.hop(fault=f"no report for {hundredth / 100:.2f} s"))
            sky.clock.sleep(0.01)
        (said,) = sky.ports[0].texts()
        assert said.startswith("RoSS: fault: no report for 0.5")
        sky.telemetry.on_input(sky.hop(fault="the motor is hot"))
        sky.clock.sleep(0.5)
    assert sky.ports[0].texts()[1:] == ["RoSS: fault: the motor is hot"]


def test_ears_and_recorder_are_told_and_trouble_is_said(aloft) -> None:
    health = [AudioHealth(level_db=(-40.0, -41.0), rate=16000.5)]
    recorder = Recorder()
    with aloft(GROUND, health=lambda: health[-1], recorder=recorder) as sky:
        sky.live(2.0)
        health.append(AudioHealth(AudioTrouble.CLIPPING, lost=160))
        recorder.now = RecordingStatus(RecordingState.FULL, "take-1", 12.0, 0.25, "the disk is full")
        sky.live(2.0)
    first, last = sky.ports[0].values(v.Audio)[0], sky.ports[0].values(v.Audio)[-1]
    assert (first.level, first.rate, first.trouble) == ((-40.0, -41.0), 16000.5, 0)
    assert (last.trouble, last.lost) == (AudioTrouble.CLIPPING, 160)
    told = sky.ports[0].values(v.Recording)[-1]
    assert (told.state, told.name, told.duration) == (v.RecordingState.FULL, "take-1", 12.0)
    assert told.free == pytest.approx(0.25e9, rel=1e-6)
    assert sky.ports[0].texts() == ["RoSS: microphones: clipping", "RoSS: recording stopped: the disk is full"]


def test_a_trouble_that_comes_and_goes_is_said_once_and_its_end_when_it_stays_away(aloft) -> None:
    """A talker who clips now and then would use up the lines that an operator reads."""
    well, ill = AudioHealth(), AudioHealth(AudioTrouble.CLIPPING)
    health = [well]
    with aloft(GROUND, health=lambda: health[-1]) as sky:
        for _ in range(10):
            health.append(ill)
            sky.live(2.0)
            health.append(well)
            sky.live(4.0)
        assert sky.ports[0].texts() == ["RoSS: microphones: clipping"]
        assert {told.trouble for told in sky.ports[0].values(v.Audio)} == {0, AudioTrouble.CLIPPING}
        sky.live(9.0)
    assert sky.ports[0].texts() == ["RoSS: microphones: clipping", "RoSS: microphones recovered"]


class Recorder:
    """Records nothing."""

    now = RecordingStatus()

    def record(self, on: bool) -> str:
        return ""

    def status(self) -> RecordingStatus:
        return self.now


@pytest.mark.parametrize("epoch", [None, 1.7e9])
def test_time_is_flagged_as_unix_or_since_boot(aloft, epoch: float | None) -> None:
    clock = SimClock()
    with aloft(GROUND, timebase=Timebase(clock, lambda: epoch)) as sky:
        sky.live(0.5)
    status = sky.ports[0].values(v.Status)[-1]
    assert status.time_unix is (epoch is not None)
    assert (status.time_usec > 1e15) is (epoch is not None)
