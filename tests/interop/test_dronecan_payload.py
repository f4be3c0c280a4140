"""`ross run` on a bus between processes, with a simulated servo and a node of the package `dronecan`."""

import math
import subprocess
from contextlib import closing, contextmanager

import numpy as np
import pytest
import soundfile

from device_bench import ROSS, device, ross
from ports import free_port
from ross_payload.events import State
from ross_payload.service.live import AGAIN

can = pytest.importorskip("can")
dronecan = pytest.importorskip("dronecan")

from dronecan_bus import BusDriver, spin_until  # noqa: E402
from dronecan_types import SOURCES, STATUS, broadcast, load_ours  # noqa: E402

RATE = 16000
OURS, SERVO = 121, 50
CONFIG = """
[audio]
source = "file:quiet.wav"
[actuator]
kind = "dronecan_servo"
[actuator.options]
port = "{bus}"
[dronecan]
port = "{bus}"
may_restart = true
[service]
state_dir = "state"
"""


@contextmanager
def peer_on(bus):
    """A node of the package on the hub; what it hears of heartbeats."""
    load_ours(dronecan)  # the package raises on what it does not know
    _, _, host, port, channel = bus.split(":")
    options = {"host": host, "port": int(port), "tcp_tune": True}
    driver = BusDriver(can.Bus(channel, "socketcand", ignore_config=True, **options))
    mode = dronecan.uavcan.protocol.NodeStatus().MODE_OPERATIONAL
    with closing(dronecan.node.Node(driver, 9, mode=mode, catch_handler_exceptions=False)) as node:
        heard = set()
        node.add_handler(dronecan.uavcan.protocol.NodeStatus, lambda event: heard.add(event.transfer.source_node_id))
        yield node, heard


def ask(node, request):
    """Ask our node until it answers: a request may meet a busy computer."""
    answers = []
    for _ in range(20):
        answers.clear()
        node.request(request, OURS, answers.append)
        spin_until(node, lambda: answers)
        if answers[0] is not None:
            return answers[0].response
    raise AssertionError(f"no answer to {request}")


def test_it_is_one_node_that_can_be_asked_set_and_restarted(tmp_path):
    soundfile.write(tmp_path / "quiet.wav", np.zeros((600 * RATE, 2), np.int16), RATE, subtype="PCM_16")
    with ross(tmp_path, "hub", "--listen", "tcp:127.0.0.1:0", "--json") as hub:
        bus = f"{hub.told['hub']}:bus1"
        (tmp_path / "ross.toml").write_text(CONFIG.format(bus=bus))
        command = [*ROSS, "run", "ross.toml"]
        with device(tmp_path, "servo", "--wire", bus), peer_on(bus) as (node, heard):
            with subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True) as payload:
                try:
                    spin_until(node, lambda: {OURS, SERVO} <= heard, within=60)
                    play_with(node)
                    restart = dronecan.uavcan.protocol.RestartNode.Request
                    spin_until(node, lambda: ask(node, restart(magic_number=restart().MAGIC_NUMBER)).ok, within=60)
                    _, said = payload.communicate(timeout=60)
                finally:
                    payload.kill()
            assert payload.returncode == AGAIN, said
            assert heard == {OURS, SERVO}
    assert "EXP_UNIT = { value = 2.5" in (tmp_path / "state" / "params.toml").read_text()
    assert (tmp_path / "state" / "dronecan.json").stat().st_mode & 0o077 == 0 or (
        tmp_path / "state"
    ).stat().st_mode & 0o077 == 0


def play_with(node):
    """Ask who it is, and set a parameter."""
    protocol = dronecan.uavcan.protocol
    assert ask(node, protocol.GetNodeInfo.Request()).name.decode() == "org.ross.payload"
    value = protocol.param.Value(real_value=2.5)
    assert ask(node, protocol.param.GetSet.Request(name="EXP_UNIT", value=value)).value.real_value == 2.5


SCENE = """
title = "a mission on a bus"
[payload.explore]
lead_in_s = 1.0
unit_s = 1.5
min_rotations = 2
max_rotations = 2
[payload.dronecan]
port = "{bus}"
[payload.service]
autostart = "explore"
[[talkers]]
azimuth_deg = 40
[[talkers]]
azimuth_deg = 155
"""


@pytest.mark.soak
@pytest.mark.process
def test_a_mission_is_followed_on_the_bus_until_it_has_found_everybody(tmp_path):
    with ross(tmp_path, "hub", "--listen", "tcp:127.0.0.1:0", "--json") as hub:
        bus = f"{hub.told['hub']}:bus1"
        (tmp_path / "scene.toml").write_text(SCENE.format(bus=bus))
        command = [*ROSS, "sitl", "--serve", "--scenario", "scene.toml", "--speed", "4", "--json"]
        with peer_on(bus) as (node, _):
            states, found = [], []

            def final():
                return found and found[-1].flags & found[-1].FLAG_FINAL

            node.add_handler(broadcast(dronecan, STATUS), lambda event: states.append(event.message.state))
            node.add_handler(broadcast(dronecan, SOURCES), lambda event: found.append(event.message))
            command += ["--telemetry", f"udpout:127.0.0.1:{free_port()}"]
            with subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.DEVNULL) as payload:
                try:
                    spin_until(node, lambda: payload.poll() is not None or final(), within=240)
                    assert payload.returncode is None
                finally:
                    payload.terminate()
    azimuths = sorted(-math.degrees(source.azimuth) for source in found[-1].sources)
    assert azimuths == pytest.approx([40, 155], abs=3)
    assert {State.LEAD_IN, State.EXPLORE_LISTEN} <= set(states)
