"""The log that a payload in another process records opens in pymavlink's own tools."""

import os
import re
import subprocess
import sys
from collections import Counter
from datetime import datetime

import pytest
from pymavlink import mavutil

from waiting import wait_for

MAVLOGDUMP = """
import runpy, sys
from pymavlink.dialects import v20
from ross_protocols.mavlink.dialect import ross
v20.ross = sys.modules["pymavlink.dialects.v20.ross"] = ross
runpy.run_module("pymavlink.tools.mavlogdump", run_name="__main__")
"""
EXPLORE, CANCEL, RECORD = 54000, 54005, 54008
ACCEPTED, IN_PROGRESS, CANCELLED = 0, 5, 6


@pytest.fixture(scope="module")
def recorded(ross_run, ground_stations, tmp_path_factory):
    """The log of a few seconds, and what a ground station heard meanwhile."""
    folder, ground = tmp_path_factory.mktemp("recorded"), ground_stations()
    with ross_run(folder, f'url = "udpout:127.0.0.1:{ground.port}"'):
        ground.wait("HEARTBEAT")
        assert ground.order(RECORD, 1) == ACCEPTED
        (log,) = wait_for(lambda: list((folder / "state" / "recordings").glob("*/telemetry.tlog*")))
        ground.command(EXPLORE)
        ground.wait("COMMAND_ACK", lambda ack: ack.command == EXPLORE)
        wait_for(lambda: "mission started" in " ".join(ground.texts()))
        begun = len(ground.of("HEARTBEAT"))
        wait_for(lambda: len(ground.of("HEARTBEAT")) > begun + 4)
        assert ground.order(CANCEL, last=True) == ACCEPTED
        ground.wait("COMMAND_ACK", lambda ack: (ack.command, ack.result) == (EXPLORE, CANCELLED))
        wait_for(lambda: "mission over" in " ".join(ground.texts()))
        assert ground.order(RECORD, 0) == ACCEPTED
    return next(log.parent.glob("telemetry.tlog*")), ground


@pytest.mark.soak
def test_mavlogdump_prints_it_with_our_names(recorded):
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", MAVLOGDUMP, "--dialect", "ross", recorded[0]],
        env=os.environ | {"MAVLINK20": "1"}, capture_output=True, text=True, timeout=60, check=True,
    )  # fmt: skip
    lines = [re.match(r"(\S+ \S+): (\S+) \{", line) for line in done.stdout.splitlines() if line]
    names = Counter(found[2] for found in lines)
    assert {"HEARTBEAT", "ROSS_STATUS", "ROSS_AUDIO", "STATUSTEXT", "COMMAND_ACK", "NAMED_VALUE_FLOAT"} <= set(names)
    assert not [name for name in names if name.startswith(("UNKNOWN", "BAD"))]
    times = [datetime.fromisoformat(found[1]) for found in lines]
    assert times == sorted(times)
    seconds = (times[-1] - times[0]).total_seconds()
    assert names["ROSS_STATUS"] == pytest.approx(4 * seconds, rel=0.4)


@pytest.mark.soak
def test_it_holds_what_the_ground_heard(recorded):
    path, ground = recorded
    log = mavutil.mavlink_connection(str(path))
    logged = []
    while (message := log.recv_match(type=["COMMAND_ACK", "STATUSTEXT"])) is not None:
        logged.append(message.text if message.get_type() == "STATUSTEXT" else (message.command, message.result))
    log.close()
    assert logged.index((EXPLORE, IN_PROGRESS)) < logged.index((EXPLORE, CANCELLED))
    heard = [text for text in ground.texts() if "mission" in text]
    assert len(heard) == 2
    assert [text for text in logged if text in heard] == heard
