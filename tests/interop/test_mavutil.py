"""pymavlink's mavutil, a client that we did not write, reads our streams and our logs."""

import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest
from pymavlink import mavutil

from flight_logs import MAVLOGDUMP
from ports import free_port
from ross_payload.clock import SystemClock
from ross_payload.config import Link
from ross_payload.mavlink import Received, Router
from ross_payload.transport.tlog import TlogRecorder
from ross_protocols.mavlink.codec import Encoder
from ross_protocols.mavlink.dialect import common, ross
from ross_protocols.mavlink.values import Health, Heartbeat, Severity, Source, Status, Text, Value

SOURCES = [
    Source(1_000_000, 1, index, 2, azimuth, 0.05, 0.9, 0.5, earth=True, resolved=True)
    for index, azimuth in enumerate((0.5, -2.0))
]
STORY: list[Value] = [
    Heartbeat(Health.ACTIVE, 3),
    Status(1_000_000, 1.0, 3, earth=True, heading=0.25, k=2, actuator_present=True),
    *SOURCES,
    Text(Severity.NOTICE, "RoSS: 2 sources found after 12 turns"),
]


@pytest.fixture(params=[ross, common], ids=["our dialect", "only the common dialect"])
def dialect(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.setattr(mavutil, "mavlink", request.param)
    monkeypatch.setenv("MAVLINK20", "1")
    return request.param


def names(known: ModuleType) -> list[str]:
    if known is common:
        return ["HEARTBEAT", "UNKNOWN_54001", "UNKNOWN_54002", "UNKNOWN_54002", "STATUSTEXT"]
    return ["HEARTBEAT", "ROSS_STATUS", "ROSS_SOURCE", "ROSS_SOURCE", "STATUSTEXT"]


def tlog(path: Path) -> Path:
    encoder = Encoder(1, 191)
    with TlogRecorder(path) as log:
        for second, value in enumerate(STORY):
            log.write(second * 1_000_000, encoder.encode(value))
    return path


def test_a_udp_client_reads_the_stream(dialect: ModuleType) -> None:
    port = free_port()
    client = mavutil.mavlink_connection(f"udpin:127.0.0.1:{port}")
    with Router.open([Link(url=f"udpout:127.0.0.1:{port}")], SystemClock()) as links:
        for value in STORY:
            links.component(191).send(value)
    got = [client.recv_match(blocking=True, timeout=5.0) for _ in STORY]
    client.close()
    assert [message.get_type() for message in got] == names(dialect)
    assert [message.get_seq() for message in got if not message.get_type().startswith("UNKNOWN")][-1] == 4
    assert got[4].text == "RoSS: 2 sources found after 12 turns"
    assert client.mav.total_receive_errors == 0


def test_a_udp_client_that_speaks_first_is_answered(dialect: ModuleType) -> None:
    port = free_port()
    heard: list[Received] = []
    with Router.open([Link(url=f"udpin:127.0.0.1:{port}")], SystemClock()) as links:
        links.component(191).subscribe(heard.append)
        client = mavutil.mavlink_connection(f"udpout:127.0.0.1:{port}", source_system=255, source_component=190)
        client.mav.send(common.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3))
        while not heard:
            links.poll()
        links.component(191).send(STORY[0])
        answer = client.recv_match(type="HEARTBEAT", blocking=True, timeout=5.0)
        client.close()
    assert (heard[0].packet.name, heard[0].packet.system_id) == ("HEARTBEAT", 255)
    assert (answer.get_srcSystem(), answer.get_srcComponent(), answer.custom_mode) == (1, 191, 3)


def test_a_log_opens_in_simulated_time(dialect: ModuleType, tmp_path: Path) -> None:
    log = mavutil.mavlink_connection(str(tlog(tmp_path / "mission.tlog")))
    got = []
    while (message := log.recv_match()) is not None:
        got.append(message)
    log.close()
    assert [message.get_type() for message in got] == names(dialect)
    assert [message._timestamp for message in got] == [0, 1, 2, 3, 4]


def test_a_client_tells_our_sources_apart(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mavutil, "mavlink", ross)
    log = mavutil.mavlink_connection(str(tlog(tmp_path / "mission.tlog")))
    while log.recv_match() is not None:
        pass
    log.close()
    azimuths = [log.sysid_state[1].messages[f"ROSS_SOURCE[{index}]"].azimuth for index in range(2)]
    assert azimuths == pytest.approx([-0.5, 2.0])  # clockwise


def test_mavlogdump_prints_a_log_with_names_and_units(tmp_path: Path) -> None:
    path = tlog(tmp_path / "mission.tlog")
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", MAVLOGDUMP, "--dialect", "ross", "--verbose", str(path)],
        env=os.environ | {"MAVLINK20": "1"}, capture_output=True, text=True, timeout=60, check=True,
    )  # fmt: skip
    assert done.stdout.count("ROSS_SOURCE (id=54002)") == 2
    assert "state: 3 (ROSS_STATE_EXPLORE_LISTEN)" in done.stdout
    assert "! ROSS_ACTUATOR_FLAGS_FAULT" in done.stdout
    assert "heading: -0.25rad" in done.stdout


def test_a_client_of_mavutil_sends_orders_and_common_messages_in_our_dialect(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mavutil, "mavlink", ross)
    monkeypatch.setenv("MAVLINK20", "1")
    port, clock, heard = free_port(), SystemClock(), []
    with Router.open([Link(url=f"udpin:127.0.0.1:{port}")], clock) as links:
        links.component(191).subscribe(lambda each: heard.append(each.packet.message))
        ground = mavutil.mavlink_connection(f"udpout:127.0.0.1:{port}", source_system=255)
        ground.mav.heartbeat_send(ross.MAV_TYPE_GCS, ross.MAV_AUTOPILOT_INVALID, 0, 0, 0)
        ground.mav.command_long_send(1, 191, ross.MAV_CMD_ROSS_STOP, 0, 0, 0, 0, 0, 0, 0, 0)
        ground.param_fetch_all()
        end = clock.now() + 10
        while len(heard) < 3 and clock.now() < end:
            links.poll()
            clock.sleep(0.01)
        ground.close()
    assert [each.get_type() for each in heard] == ["HEARTBEAT", "COMMAND_LONG", "PARAM_REQUEST_LIST"]
    assert heard[1].command == ross.MAV_CMD_ROSS_STOP
