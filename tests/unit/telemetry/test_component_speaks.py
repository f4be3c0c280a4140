"""The MAVLink component on its links: who listens is told, on every link what fits, whatever the mission computes."""

import math
from dataclasses import replace
from pathlib import Path

import pytest

from ross_payload.config import Config, Link
from ross_payload.errors import ConfigError
from ross_payload.events import Estimate, Finished, Outcome, SourceEstimate, SourcesEstimated, State, StateChanged
from ross_payload.interfaces import Capabilities, Feedback
from ross_payload.orders import Explore
from ross_payload.telemetry.snapshot import information
from ross_protocols.mavlink import values as v
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.dialect import common, ross
from ross_protocols.mavlink.tunnel import unwrap

GROUND = Link(url="udpout:127.0.0.1:14550")
RADIO = Link(url="udpout:127.0.0.1:14551", max_bytes_s=350)
AUTOPILOT = Link(url="udpout:127.0.0.1:14552", role="autopilot")
SOURCES = tuple(SourceEstimate(azimuth, 0.02, 0.9, resolved=True) for azimuth in (-1.4, 0.7, 2.7))
THREE = SourcesEstimated(0.0, Estimate(SOURCES, certain=True), 12, final=True)


# ---------------------------------------------------------------------------------------------------- what goes out


def test_the_pump_sends_no_more_when_the_end_of_the_streams_is_told(aloft, monkeypatch) -> None:
    """Two threads that took texts from one line at once ended the payload with an error."""
    done = []
    with aloft(GROUND) as sky:
        sky.live(0.5)
        cancel, flow = sky.telemetry._cancel, sky.telemetry._scheduler.flow
        monkeypatch.setattr(sky.telemetry, "_cancel", lambda: done.append("cancelled") or cancel())
        monkeypatch.setattr(sky.telemetry._scheduler, "flow", lambda now: done.append("sent") or flow(now))
        monkeypatch.setattr(sky.telemetry._streams, "look", lambda *told, **more: True)
    assert done[-2:] == ["cancelled", "sent"]


def test_who_only_listens_is_told_everything_at_its_rate(aloft) -> None:
    with aloft(GROUND) as sky:
        sky.live(20.0)
    (port,) = sky.ports
    assert len(port.values(v.Heartbeat)) == pytest.approx(20, abs=1)
    assert len(port.values(v.Status)) == pytest.approx(80, abs=1)
    assert len(port.values(v.Information)) == pytest.approx(4, abs=1)
    assert {value.name for value in port.values(v.Named)} == {"ross_state", "ross_head"}
    assert port.values(v.Array)[0].numbers == ()


def test_what_the_mission_says_goes_out_on_the_pump(aloft) -> None:
    with aloft(GROUND) as sky:
        sky.live(0.1)
        before = len(sky.ports[0].packets)
        sky.telemetry.on_event(THREE, sky.hop())
        sky.telemetry.on_input(sky.hop())
        assert len(sky.ports[0].packets) == before
        sky.clock.sleep(0.02)
        assert [source.source for source in sky.ports[0].values(v.Source)] == [0, 1, 2]


def test_what_is_said_while_a_link_is_down_is_told_when_it_is_up(aloft) -> None:
    with aloft(GROUND) as sky:
        (port,) = sky.ports
        port.counts = replace(port.counts, up=False)
        sky.telemetry.on_event(Finished(0.0, Outcome.NO_TARGET, "nobody is there"), sky.hop())
        sky.live(5.0)
        assert port.packets == []
        port.counts = replace(port.counts, up=True)
        sky.live(0.2)
    assert port.texts() == ["RoSS: mission over: nobody is there"]
    assert len(port.values(v.Heartbeat)) == 1


def test_until_the_vehicle_is_known_a_heartbeat_a_second_goes_out_and_texts_wait(aloft) -> None:
    with aloft(AUTOPILOT) as sky:
        (port,) = sky.ports
        sky.links.system_id = 0
        sky.telemetry.on_event(Finished(0.0, Outcome.NO_TARGET, "nobody is there"), sky.hop())
        sky.live(5.0)
        assert port.names() == {"HEARTBEAT"}
        assert len(port.packets) == pytest.approx(5, abs=1)
        sky.links.system_id = 7
        sky.live(0.2)
    assert port.texts() == ["RoSS: mission over: nobody is there"]


def test_what_is_said_last_is_told_before_the_end(aloft, tmp_path: Path) -> None:
    with aloft(GROUND, tlog=tmp_path / "a.tlog") as sky:
        sky.live(0.1)
        sky.telemetry.on_event(StateChanged(0.0, State.DONE), sky.hop())
    assert sky.ports[0].values(v.Heartbeat)[-1] == v.Heartbeat(v.Health.STANDBY, State.DONE)
    assert logged(tmp_path / "a.tlog")[-1].state == State.DONE


def test_a_link_with_a_small_budget_is_told_what_matters(aloft) -> None:
    with aloft(GROUND, RADIO) as sky:
        sky.telemetry.on_event(THREE, sky.hop())
        sky.live(30.0)
    rich, poor = sky.ports
    assert len(poor.values(v.Heartbeat)) == pytest.approx(30, abs=1)
    assert len(poor.values(v.Status)) > 30
    assert {source.source for source in poor.values(v.Source)} == {0, 1, 2}
    assert len(poor.packets) < len(rich.packets)
    assert sky.links.status()[1].sent_bytes < 30 * 350 + 300
    assert sky.links.status()[1].dropped == 0, "nothing is sent that has no room"


def test_who_comes_late_knows_everything_after_ten_seconds(aloft) -> None:
    with aloft(GROUND) as sky:
        sky.telemetry.on_event(StateChanged(0.0, State.RUN), sky.hop())
        sky.telemetry.on_event(THREE, sky.hop())
        sky.live(13.0)
        early, late = sky.ports[0], aloft.Port()
        sky.links.attach(RADIO, late)
        sky.live(10.0)
    assert late.names() == early.names() - {"STATUSTEXT"}
    assert len(late.values(v.Source)) >= 3


def test_every_link_counts_without_gaps(aloft) -> None:
    with aloft(GROUND, RADIO) as sky:
        sky.live(5.0)
    for port in sky.ports:
        assert [packet.sequence for packet in port.packets] == list(range(len(port.packets)))


# ---------------------------------------------------------------------------------------------------- autopilot


def test_an_autopilot_hands_everything_on_that_a_ground_station_needs(aloft) -> None:
    """It hands on what it knows: the common dialect without ours."""
    with aloft(AUTOPILOT) as sky:
        sky.telemetry.on_event(THREE, sky.hop())
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


def test_what_arrives_in_a_tunnel_is_no_order(aloft, tmp_path: Path) -> None:
    orders: list = []
    command = common.MAVLink_command_long_message(1, 191, ross.MAV_CMD_ROSS_EXPLORE, 0, 0, 0, 0, 0, 0, 0, 0)
    frame = Encoder(255, 190).encode(command)
    tunnel = common.MAVLink_tunnel_message(
        1, 191, ross.ROSS_TUNNEL_TYPE_FRAME, len(frame), list(frame.ljust(128, b"\0"))
    )
    with aloft(AUTOPILOT, GROUND, give=orders.append) as sky:
        for port in sky.ports:
            port.call(tunnel)
        sky.live(0.5)
        assert orders == []
        sky.ports[0].call(command)
        sky.live(0.5)
    assert [type(order) for order in orders] == [Explore], "outside of it, it is one"


# ---------------------------------------------------------------------------------------------------- the log


def logged(path: Path) -> list:
    return [packet.value for packet in Decoder().feed(path.read_bytes())]


def test_the_log_holds_everything_once_however_many_links_there_are(aloft, tmp_path: Path) -> None:
    for name, links in (("none", ()), ("two", (GROUND, RADIO))):
        with aloft(*links, tlog=tmp_path / name) as sky:
            sky.telemetry.on_event(THREE, sky.hop())
            sky.live(5.0)
    none, two = (
        [value for value in logged(tmp_path / name) if type(value) is not v.LinkReport] for name in ("none", "two")
    )
    assert none == two
    sequence = [packet.sequence for packet in Decoder().feed((tmp_path / "two").read_bytes())]
    assert sequence == list(range(len(sequence)))


def test_every_link_is_reported(aloft) -> None:
    with aloft(GROUND, AUTOPILOT) as sky:
        sky.live(7.0)
    ground, autopilot = sky.ports[0].values(v.LinkReport)[-2:]
    assert (ground.url, ground.link, ground.count, ground.up, ground.autopilot) == (GROUND.url, 0, 2, True, False)
    assert (autopilot.url, autopilot.link, autopilot.autopilot) == (AUTOPILOT.url, 1, True)
    assert 0 < ground.sent <= len(sky.ports[0].packets)


def test_without_an_attitude_angles_are_in_the_mount_frame(aloft, tmp_path: Path) -> None:
    with aloft(tlog=tmp_path / "a") as sky:
        sky.telemetry.on_input(sky.hop(known=False))
        sky.clock.sleep(0.3)
    status = [value for value in logged(tmp_path / "a") if isinstance(value, v.Status)][-1]
    assert (status.earth, status.mount_yaw) == (False, None)


def test_turning_through_the_back_is_no_jump_in_rate(aloft, tmp_path: Path) -> None:
    with aloft(tlog=tmp_path / "a") as sky:
        sky.telemetry.on_input(sky.hop(start=math.pi - 0.005, end=-math.pi + 0.005))
        sky.clock.sleep(0.3)
    status = [value for value in logged(tmp_path / "a") if isinstance(value, v.Status)][-1]
    assert status.joint_rate == pytest.approx(1.0)  # 0.01 rad in a hop of 10 ms


def test_a_log_that_cannot_be_made_stops_us_before_the_mission(aloft, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="cannot be written"):
        aloft(tlog=tmp_path / "missing" / "mission.tlog")


def test_information_is_the_configuration() -> None:
    told = information(Config(), None, 5)
    assert (told.spacing, told.speed_of_sound, told.rate, told.unit, told.time_usec) == (0.05, 343.0, 16000, 3.0, 5)
    assert (told.joint_lower, told.joint_upper) == pytest.approx((math.radians(-200), math.radians(200)))


def test_an_actuator_that_turns_without_end_has_no_travel() -> None:
    free = Capabilities(-math.inf, math.inf, 4.0, 2.0, 0.002, continuous=True, feedback=Feedback.MEASURED)
    told = information(Config(), free, 0)
    assert (told.joint_lower, told.joint_upper, told.joint_speed) == (None, None, 4.0)
