"""All that a user needs arrives behind an autopilot that passes messages on as an ArduPilot does."""

import math
from contextlib import ExitStack

import pytest
from pymavlink.dialects.v20 import ardupilotmega, common

from ross_payload.config.parameter_table import TABLE
from ross_protocols.mavlink.tunnel import unwrap
from waiting import wait_for

SYSTEM, YAW = 7, 90.0  # [deg], clockwise
TALKERS = (40.0, -80.0)  # [deg], counter-clockwise from the mount
SCENARIO = """
title = "a payload under a vehicle that points east"
[payload.telemetry]
system_id = 0
[payload.mount]
source = "autopilot"
[[payload.links]]
url = "udpout:127.0.0.1:{port}"
role = "autopilot"
[payload.explore]
lead_in_s = 1.0
unit_s = 1.0
min_rotations = 2
max_rotations = 2
[noise]
snr_db = 25
"""
EXPLORE, STOP, REARM = 54000, 54004, 54009
ACCEPTED, IN_PROGRESS = 0, 5
LATE = "exploring after all"  # the attitude was late, so that the exploration began again


@pytest.fixture(scope="module")
def ground(living, ground_stations, free_port, tmp_path_factory):
    """A ground station on the far side of the autopilot."""
    folder, ground, port = tmp_path_factory.mktemp("vehicle"), ground_stations(), free_port()
    talkers = "".join(f"[[talkers]]\nazimuth_deg = {azimuth}\n" for azimuth in TALKERS)
    (folder / "east.toml").write_text(SCENARIO.format(port=port) + talkers)
    links = ["--link", f"udpin:127.0.0.1:{port}", "--link", f"udpout:127.0.0.1:{ground.port}"]
    autopilot = ["autopilot", *links, "--system-id", str(SYSTEM), "--yaw", str(YAW)]
    with ExitStack() as stack:
        stack.enter_context(living(autopilot, folder / "autopilot", code=130))
        stack.enter_context(
            living(["sitl", "--serve", "--json", "--scenario", folder / "east.toml"], folder / "payload")
        )
        ground.wait("HEARTBEAT", lambda beat: beat.get_srcSystem() == SYSTEM)
        yield ground


@pytest.fixture(scope="module")
def explored(ground):
    """The ground station after an exploration that was not disturbed."""
    from_north(ground)  # an exploration ends when the attitude becomes known in the middle of it
    before, said = len(ground.of("COMMAND_ACK")), len(ground.texts())
    ground.command(EXPLORE, system=SYSTEM)
    assert ground.wait("COMMAND_ACK", over, 60, before).result == ACCEPTED, ground.texts()
    assert not [text for text in ground.texts()[said:] if LATE in text]
    return ground


def over(ack):
    """Whether an answer is the last one to an exploration."""
    return ack.command == EXPLORE and ack.result != IN_PROGRESS


def inside(ground, name):
    """What TUNNELs have brought of one of our messages."""
    packets = [unwrap(message) for message in ground.of("TUNNEL")]
    return [packet.message for packet in packets if packet and packet.name == name]


def from_north(ground):
    """Wait until the payload knows the attitude of the vehicle; its latest ROSS_STATUS."""
    return wait_for(lambda: [one for one in inside(ground, "ROSS_STATUS")[-1:] if one.frame == 1])[0]


def compass(azimuth):
    """Degrees, clockwise from north, of an azimuth [deg] that counts counter-clockwise from the mount."""
    return (YAW - azimuth) % 360


def near(told, true):
    """Whether every true azimuth [deg] is told within 3 degrees; two short looks may also find who is not there."""
    return max(min(abs((one - other + 180) % 360 - 180) for other in told) for one in true) < 3


def sources(explored):
    """The estimate of the exploration as tunnels have brought it, by source."""

    def arrived():
        latest = {one.source: one for one in inside(explored, "ROSS_SOURCE") if one.flags & 4}
        return latest if latest and len(latest) == next(iter(latest.values())).count else None

    return list(wait_for(arrived).values())


def test_it_has_the_system_id_of_the_vehicle(ground):
    beat = ground.wait("HEARTBEAT", lambda beat: beat.get_srcSystem() == SYSTEM)
    assert (beat.type, beat.autopilot) == (common.MAV_TYPE_ONBOARD_CONTROLLER, common.MAV_AUTOPILOT_INVALID)
    assert ground.of("ATTITUDE", 1), "the autopilot is there beside it"


def test_headings_count_from_north(ground):
    status = from_north(ground)
    assert math.degrees(status.mount_yaw) == pytest.approx(YAW, abs=0.1)
    assert math.degrees(status.heading - status.joint) % 360 == pytest.approx(YAW, abs=0.5)


def test_before_it_has_that_id_it_says_only_that_it_is_there(explored):
    early = [one for one in explored.heard if one.get_srcComponent() == 191 and one.get_srcSystem() != SYSTEM]
    assert {one.get_type() for one in early} <= {"HEARTBEAT"}
    assert len(early) <= 2


def test_the_sources_arrive_in_tunnels(explored):
    found = sources(explored)
    assert {source.frame for source in found} == {1}
    assert len(found) >= len(TALKERS)
    assert near([math.degrees(source.azimuth) for source in found], [compass(one) for one in TALKERS])


def test_the_mirrors_arrive_as_they_are(explored):
    count = len(sources(explored))

    def numbers():
        found = {one.name: one.value for one in explored.of("NAMED_VALUE_FLOAT")}
        return found if found.get("ross_k") == count else None

    assert wait_for(numbers)["ross_head"] < 360
    array = wait_for(lambda: [one for one in explored.of("DEBUG_FLOAT_ARRAY") if one.data[0] == count])[-1]
    assert near(array.data[1 : 1 + count], [compass(one) for one in TALKERS])


def test_the_texts_arrive(explored):
    wait_for(lambda: "RoSS: mission started" in explored.texts())
    said = f"RoSS: {len(sources(explored))} sources found after 2 turns"
    wait_for(lambda: [text for text in explored.texts() if text.startswith(said)], what=explored.texts)


def test_what_the_autopilot_does_not_know_it_drops(explored):
    assert not [one for one in explored.heard if one.get_type().startswith(("UNKNOWN", "ROSS"))]


def test_parameters_are_read_and_written(ground):
    ground.link.mav.send(ardupilotmega.MAVLink_param_request_list_message(SYSTEM, 191))
    wait_for(lambda: {one.param_id for one in ground.of("PARAM_VALUE")} == set(TABLE))
    kind = ardupilotmega.MAV_PARAM_TYPE_REAL32
    ground.link.mav.send(ardupilotmega.MAVLink_param_set_message(SYSTEM, 191, b"XPL_RUNS", 3.0, kind))
    ground.wait("PARAM_VALUE", lambda one: (one.param_id, one.param_value) == ("XPL_RUNS", 3.0))


def test_commands_are_obeyed_and_refused_with_the_reason(ground):
    assert ground.order(STOP, system=SYSTEM, last=True) == ACCEPTED
    assert ground.order(EXPLORE, system=SYSTEM) == common.MAV_RESULT_TEMPORARILY_REJECTED
    wait_for(lambda: "RoSS: explore refused: stopped: re-arm first" in ground.texts())
    assert ground.order(REARM, system=SYSTEM, last=True) == ACCEPTED
    assert {(ack.target_system, ack.target_component) for ack in ground.of("COMMAND_ACK")} == {(255, 190)}


def test_an_order_inside_a_tunnel_is_not_obeyed(ground):
    stop = ardupilotmega.MAVLink_command_long_message(SYSTEM, 191, STOP, 0, *[0.0] * 7)
    frame = bytes(stop.pack(ardupilotmega.MAVLink(None, srcSystem=255, srcComponent=190)))
    tunnel = ardupilotmega.MAVLink_tunnel_message(SYSTEM, 191, 54000, len(frame), list(frame.ljust(128, b"\0")))
    before = len(ground.of("COMMAND_ACK"))
    ground.link.mav.send(tunnel)
    assert ground.order(REARM, system=SYSTEM, last=True) == ACCEPTED
    assert {ack.command for ack in ground.of("COMMAND_ACK")[before:]} == {REARM}
    assert inside(ground, "ROSS_STATUS")[-1].state != 8
