"""The MAVLink component on its links: who listens is told, on every link what fits, whatever the mission computes."""

import math
import threading
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ross_payload.clock import SystemClock
from ross_payload.config import Config, Link
from ross_payload.errors import ConfigError
from ross_payload.events import Answer, Answered, Estimate, SourceEstimate, SourcesEstimated, State, StateChanged
from ross_payload.health import AudioHealth, AudioTrouble, RecordingState, RecordingStatus
from ross_payload.interfaces import ActuatorState, Attitude, AudioBlock, Capabilities, Feedback, Input
from ross_payload.links import Links
from ross_payload.links.ports import Counts
from ross_payload.orders import Explore
from ross_payload.parameters import TABLE, Parameters
from ross_payload.telemetry.service import Telemetry, information
from ross_payload.timebase import Timebase
from ross_protocols import values as v
from ross_protocols.codec import Decoder, Encoder
from ross_protocols.dialect import common, ross
from ross_protocols.tunnel import unwrap
from ross_sim.clock import SimClock

GROUND = Link(url="udpout:127.0.0.1:14550")
RADIO = Link(url="udpout:127.0.0.1:14551", max_bytes_s=350)
AUTOPILOT = Link(url="udpout:127.0.0.1:14552", role="autopilot")
SOURCES = tuple(SourceEstimate(azimuth, 0.02, 0.9, resolved=True) for azimuth in (-1.4, 0.7, 2.7))
THREE = SourcesEstimated(0.0, Estimate(SOURCES, certain=True), 12, final=True)


def hop(index: int = 16000, start: float = 0.0, end: float = 0.01, known: bool = True, fault: str = "") -> Input:
    block = AudioBlock(np.zeros((2, 160), np.float32), index, index / 16000)
    return Input(block, start, end, end, settled=False, attitude=Attitude(0.5, known=known), fault=fault)


class Port:
    """One end of a link; the other end reads what came and may speak."""

    def __init__(self) -> None:
        self.counts = Counts()
        self.decoder = Decoder()
        self.packets: list = []
        self.times: list[float] = []
        self._arriving: list[bytes] = []
        self._mavlink = ross.MAVLink(None, srcSystem=255, srcComponent=190)

    def send(self, frame: bytes) -> None:
        got = self.decoder.feed(frame)
        self.packets += got
        self.times += [time.monotonic()] * len(got)

    def receive(self) -> list[bytes]:
        arrived, self._arriving = self._arriving, []
        return arrived

    def close(self) -> None:
        """Nothing to give back."""

    def call(self, message, frame: bytes | None = None) -> None:
        self._arriving.append(message.pack(self._mavlink) if frame is None else frame)
        self._mavlink.seq = (self._mavlink.seq + 1) % 256

    def values(self, kind: type) -> list:
        return [packet.value for packet in self.packets if type(packet.value) is kind]

    def names(self) -> set[str]:
        return {packet.name for packet in self.packets}

    def texts(self) -> list[str]:
        return [text.text for text in self.values(v.Text)]

    def messages(self, name: str) -> list:
        return [packet.message for packet in self.packets if packet.name == name]


class Sky:
    """A payload's telemetry on simulated time, with some links."""

    def __init__(self, *links: Link, **parts) -> None:
        self.clock = SimClock()
        self.links = Links(self.clock, 1)
        self.ports = [Port() for _ in links]
        for link, port in zip(links, self.ports, strict=True):
            self.links.attach(link, port)
        self.telemetry = Telemetry(Config(), self.clock, self.links, **parts)
        self.clock.every(0.01, self.links.poll)

    def __enter__(self) -> "Sky":
        self.telemetry.__enter__()
        return self

    def __exit__(self, *error) -> None:
        self.telemetry.__exit__(*error)
        self.links.close()

    def live(self, seconds: float) -> None:
        for index in range(round(seconds * 100)):
            self.telemetry.heard(hop(index * 160))
            self.clock.advance()


# ---------------------------------------------------------------------------------------------------- what goes out


def test_who_only_listens_is_told_everything_at_its_rate() -> None:
    with Sky(GROUND) as sky:
        sky.live(20.0)
    (port,) = sky.ports
    assert len(port.values(v.Heartbeat)) == pytest.approx(20, abs=1)
    assert len(port.values(v.Status)) == pytest.approx(80, abs=1)
    assert len(port.values(v.Information)) == pytest.approx(4, abs=1)
    assert {value.name for value in port.values(v.Named)} == {"ross_state", "ross_head"}
    assert port.values(v.Array)[0].numbers == ()


def test_what_the_mission_says_goes_out_on_the_pump() -> None:
    with Sky(GROUND) as sky:
        sky.live(0.1)
        before = len(sky.ports[0].packets)
        sky.telemetry.said(THREE, hop())
        sky.telemetry.heard(hop())
        assert len(sky.ports[0].packets) == before
        sky.clock.sleep(0.02)
        assert [source.source for source in sky.ports[0].values(v.Source)] == [0, 1, 2]


def test_what_is_said_last_is_told_before_the_end(tmp_path: Path) -> None:
    with Sky(GROUND, tlog=tmp_path / "a.tlog") as sky:
        sky.live(0.1)
        sky.telemetry.said(StateChanged(0.0, State.DONE), hop())
    assert sky.ports[0].values(v.Heartbeat)[-1] == v.Heartbeat(v.Health.STANDBY, State.DONE)
    assert logged(tmp_path / "a.tlog")[-1].state == State.DONE


def test_a_computing_mission_delays_no_heartbeat() -> None:
    """Two seconds of linear algebra on the mission's thread, and the pump goes on."""
    port, clock = Port(), SystemClock()
    with Links(clock, 1) as links:
        links.attach(GROUND, port)
        with Telemetry(Config(), clock, links) as telemetry:
            end = time.monotonic() + 3.5

            def mission() -> None:
                telemetry.heard(hop())
                matrix = np.eye(200)
                while time.monotonic() < end:
                    matrix = matrix @ matrix

            thread = threading.Thread(target=mission)
            thread.start()
            thread.join()
    beats = [when for when, packet in zip(port.times, port.packets, strict=True) if packet.name == "HEARTBEAT"]
    assert len(beats) >= 3
    assert max(np.diff(beats)) < 1.5


def test_a_link_with_a_small_budget_is_told_what_matters() -> None:
    with Sky(GROUND, RADIO) as sky:
        sky.telemetry.said(THREE, hop())
        sky.live(30.0)
    rich, poor = sky.ports
    assert len(poor.values(v.Heartbeat)) == pytest.approx(30, abs=1)
    assert len(poor.values(v.Status)) > 30
    assert {source.source for source in poor.values(v.Source)} == {0, 1, 2}
    assert len(poor.packets) < len(rich.packets)
    assert sky.links.status()[1].sent_bytes < 30 * 350 + 300
    assert sky.links.status()[1].dropped == 0, "nothing is sent that has no room"


def test_who_comes_late_knows_everything_after_ten_seconds() -> None:
    with Sky(GROUND) as sky:
        sky.telemetry.said(StateChanged(0.0, State.RUN), hop())
        sky.telemetry.said(THREE, hop())
        sky.live(13.0)
        early, late = sky.ports[0], Port()
        sky.links.attach(RADIO, late)
        sky.live(10.0)
    assert late.names() == early.names() - {"STATUSTEXT"}
    assert len(late.values(v.Source)) >= 3


def test_every_link_counts_without_gaps() -> None:
    with Sky(GROUND, RADIO) as sky:
        sky.live(5.0)
    for port in sky.ports:
        assert [packet.sequence for packet in port.packets] == list(range(len(port.packets)))


# ---------------------------------------------------------------------------------------------------- autopilot


def test_an_autopilot_hands_everything_on_that_a_ground_station_needs() -> None:
    """It hands on what it knows: the common dialect without ours."""
    with Sky(AUTOPILOT) as sky:
        sky.telemetry.said(THREE, hop())
        sky.live(6.0)
    handed_on = [packet for packet in sky.ports[0].packets if packet.message.id in common.mavlink_map]
    assert len(handed_on) == len(sky.ports[0].packets)
    names = {packet.name for packet in handed_on}
    assert names == {"HEARTBEAT", "STATUSTEXT", "NAMED_VALUE_FLOAT", "DEBUG_FLOAT_ARRAY", "TUNNEL"}
    inside = [unwrap(packet.message) for packet in handed_on if packet.name == "TUNNEL"]
    assert all(packet is not None for packet in inside)
    assert [packet.sequence for packet in inside] == list(range(len(inside)))
    azimuths = {packet.value.source: packet.value.azimuth for packet in inside if packet.name == "ROSS_SOURCE"}
    assert azimuths == pytest.approx({0: -1.4, 1: 0.7, 2: 2.7})
    assert {"ROSS_STATUS", "ROSS_INFORMATION"} <= {packet.name for packet in inside}


def test_what_arrives_in_a_tunnel_is_no_order(tmp_path: Path) -> None:
    orders: list = []
    command = common.MAVLink_command_long_message(1, 191, ross.MAV_CMD_ROSS_EXPLORE, 0, 0, 0, 0, 0, 0, 0, 0)
    frame = Encoder(255, 190).encode(command)
    tunnel = common.MAVLink_tunnel_message(
        1, 191, ross.ROSS_TUNNEL_TYPE_FRAME, len(frame), list(frame.ljust(128, b"\0"))
    )
    with Sky(AUTOPILOT, GROUND, give=orders.append) as sky:
        for port in sky.ports:
            port.call(tunnel)
        sky.live(0.5)
        assert orders == []
        sky.ports[0].call(command)
        sky.live(0.5)
    assert [type(order) for order in orders] == [Explore], "outside of it, it is one"


# ---------------------------------------------------------------------------------------------------- what comes in


def test_a_command_becomes_an_order_and_its_answer_an_acknowledgement() -> None:
    orders: list = []
    with Sky(GROUND, give=orders.append) as sky:
        sky.ports[0].call(common.MAVLink_command_long_message(1, 191, ross.MAV_CMD_ROSS_EXPLORE, 0, *[0] * 7))
        sky.live(0.05)
        sky.telemetry.said(Answered(0.0, orders[0].number, Answer.ACCEPTED), hop())
        sky.live(0.1)
        sky.telemetry.said(Answered(0.0, orders[0].number, Answer.DONE), hop())
        sky.live(0.1)
    results = [ack.result for ack in sky.ports[0].messages("COMMAND_ACK")]
    assert results[0] == common.MAV_RESULT_IN_PROGRESS
    assert results[-1] == common.MAV_RESULT_ACCEPTED


def test_parameters_are_listed_and_a_rate_is_set_in_flight() -> None:
    told: list = []
    with (
        Parameters(Config()) as parameters,
        Sky(GROUND, parameters=parameters, changed=lambda *change: told.append(change)) as sky,
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


def test_each_link_is_told_as_often_as_it_asks_for() -> None:
    with Sky(GROUND, RADIO, give=lambda order: None) as sky:
        sky.live(1.0)
        interval = common.MAVLink_command_long_message(1, 191, 511, 0, 54001, 1e6, 0, 0, 0, 0, 0)
        sky.ports[1].call(interval)
        sky.live(1.0)
        for port in sky.ports:
            port.packets.clear()
        sky.live(10.0)
    rich, radio = (len(port.values(v.Status)) for port in sky.ports)
    assert (rich, radio) == (pytest.approx(40, abs=1), pytest.approx(10, abs=1))


def test_nobody_can_silence_a_heartbeat() -> None:
    with Sky(GROUND, give=lambda order: None) as sky:
        sky.live(1.0)
        for interval in (-1, 3.6e9):
            sky.ports[0].call(common.MAVLink_command_long_message(1, 191, 511, 0, 0, interval, 0, 0, 0, 0, 0))
        sky.live(1.0)
        sky.ports[0].packets.clear()
        sky.live(10.0)
    assert len(sky.ports[0].values(v.Heartbeat)) >= 9


def test_a_payload_with_another_dialect_is_named_once() -> None:
    stranger = replace(information(Config(), None, 0), dialect_version=99)
    with Sky(GROUND) as sky:
        for _ in range(3):
            sky.ports[0].call(None, Encoder(2, 191).encode(stranger))
            sky.ports[0].call(None, Encoder(3, 191).encode(information(Config(), None, 0)))
            sky.live(0.5)
    said = [text for text in sky.ports[0].texts() if "speaks" in text]
    assert said == ["RoSS: payload 2/191 speaks version 99 of the diale"]


def test_somebody_else_with_our_component_id_is_said_once() -> None:
    with Sky(GROUND) as sky:
        twin = Encoder(1, 191)
        for _ in range(5):
            sky.ports[0].call(None, twin.encode(v.Heartbeat(v.Health.ACTIVE, 6)))
            sky.live(1.0)
    said = "".join(sky.ports[0].texts())
    assert said == "RoSS: somebody else speaks as our component 191: change one component_id"


# ---------------------------------------------------------------------------------------------------- how things stand


class Motor:
    """An actuator that stands where it is put."""

    capabilities = Capabilities(-2.0, 2.0, 4.0, 2.0, 0.002, continuous=False, feedback=Feedback.MODEL)

    def __init__(self) -> None:
        self.now = ActuatorState(0.01, 0.0, settled=True, homed=True, healthy=True, time=0.0)

    def state(self) -> ActuatorState:
        return self.now


def test_before_anything_was_heard_the_actuator_speaks() -> None:
    motor = Motor()
    with Sky(GROUND, actuator=motor) as sky:
        sky.clock.sleep(0.5)
    status = sky.ports[0].values(v.Status)[-1]
    assert (status.actuator_present, status.homed, status.open_loop) == (True, True, True)
    assert (status.joint, status.heading) == (pytest.approx(0.01), None)


def test_while_the_mission_computes_the_array_is_seen_to_turn() -> None:
    motor = Motor()
    with Sky(GROUND, actuator=motor) as sky:
        sky.telemetry.heard(hop(start=0.51, end=0.51))
        sky.clock.sleep(0.5)
        motor.now = replace(motor.now, angle=0.61, rate=1.5)
        sky.clock.sleep(0.5)
    status = sky.ports[0].values(v.Status)[-1]
    assert (status.joint, status.joint_rate) == pytest.approx((0.61, 1.5))
    assert status.heading == pytest.approx(0.61), "0.1 rad on from what was heard, at joint angle 0.51"


def test_a_fault_is_said_once_and_flagged_while_it_lasts() -> None:
    with Sky(GROUND) as sky:
        sky.telemetry.heard(hop(fault="the motor is hot"))
        sky.clock.sleep(3.0)
        assert sky.ports[0].texts() == ["RoSS: fault: the motor is hot"]
        assert sky.ports[0].values(v.Status)[-1].fault
        sky.telemetry.heard(hop())
        sky.clock.sleep(0.5)
    assert not sky.ports[0].values(v.Status)[-1].fault


def test_ears_and_recorder_are_told_and_trouble_is_said() -> None:
    health = [AudioHealth(level_db=(-40.0, -41.0), rate=16000.5)]
    recorder = Recorder()
    with Sky(GROUND, health=lambda: health[-1], recorder=recorder) as sky:
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


class Recorder:
    """Records nothing."""

    now = RecordingStatus()

    def record(self, on: bool) -> str:
        return ""

    def status(self) -> RecordingStatus:
        return self.now


@pytest.mark.parametrize("epoch", [None, 1.7e9])
def test_time_is_flagged_as_unix_or_since_boot(epoch: float | None) -> None:
    clock = SimClock()
    with Sky(GROUND, timebase=Timebase(clock, lambda: epoch)) as sky:
        sky.live(0.5)
    status = sky.ports[0].values(v.Status)[-1]
    assert status.time_unix is (epoch is not None)
    assert (status.time_usec > 1e15) is (epoch is not None)


# ---------------------------------------------------------------------------------------------------- the log


def logged(path: Path) -> list:
    return [packet.value for packet in Decoder().feed(path.read_bytes())]


def test_the_log_holds_everything_once_however_many_links_there_are(tmp_path: Path) -> None:
    for name, links in (("none", ()), ("two", (GROUND, RADIO))):
        with Sky(*links, tlog=tmp_path / name) as sky:
            sky.telemetry.said(THREE, hop())
            sky.live(5.0)
    assert (tmp_path / "none").read_bytes() == (tmp_path / "two").read_bytes()
    sequence = [packet.sequence for packet in Decoder().feed((tmp_path / "two").read_bytes())]
    assert sequence == list(range(len(sequence)))


def test_without_an_attitude_angles_are_in_the_mount_frame(tmp_path: Path) -> None:
    with Sky(tlog=tmp_path / "a") as sky:
        sky.telemetry.heard(hop(known=False))
        sky.clock.sleep(0.3)
    status = [value for value in logged(tmp_path / "a") if isinstance(value, v.Status)][-1]
    assert (status.earth, status.mount_yaw) == (False, None)


def test_turning_through_the_back_is_no_jump_in_rate(tmp_path: Path) -> None:
    with Sky(tlog=tmp_path / "a") as sky:
        sky.telemetry.heard(hop(start=math.pi - 0.005, end=-math.pi + 0.005))
        sky.clock.sleep(0.3)
    status = [value for value in logged(tmp_path / "a") if isinstance(value, v.Status)][-1]
    assert status.joint_rate == pytest.approx(1.0)  # 0.01 rad in a hop of 10 ms


def test_a_log_that_cannot_be_made_stops_us_before_the_mission(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="cannot be written"):
        Sky(tlog=tmp_path / "missing" / "mission.tlog")


def test_information_is_the_configuration() -> None:
    told = information(Config(), None, 5)
    assert (told.spacing, told.speed_of_sound, told.rate, told.unit, told.time_usec) == (0.05, 343.0, 16000, 3.0, 5)
    assert (told.joint_lower, told.joint_upper) == pytest.approx((math.radians(-200), math.radians(200)))


def test_an_actuator_that_turns_without_end_has_no_travel() -> None:
    free = Capabilities(-math.inf, math.inf, 4.0, 2.0, 0.002, continuous=True, feedback=Feedback.MEASURED)
    told = information(Config(), free, 0)
    assert (told.joint_lower, told.joint_upper, told.joint_speed) == (None, None, 4.0)
