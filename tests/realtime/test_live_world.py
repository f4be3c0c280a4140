"""The array of a `ross world` is turned by a driver in another process."""

import json
import os

import pytest

from device_bench import SERIAL_OVER_TCP, driver, ross
from examples import in_soak
from ports import free_port
from ross_payload.clock import may_hurry
from ross_sim.live_world.world_session import URGENCY
from waiting import wait_for


def test_a_world_that_sounds_goes_before_everything_ordinary_as_a_sound_card_does(tmp_path):
    expected = (os.SCHED_RR | os.SCHED_RESET_ON_FORK, URGENCY) if may_hurry() else (os.SCHED_OTHER, 0)

    def priority():
        pid = world.running.pid
        return os.sched_getscheduler(pid), os.sched_getparam(pid).sched_priority

    with ross(tmp_path, "world", "one-talker", "--json", "--start", "now") as world:
        wait_for(lambda: priority() == expected)


WIRES = {
    "mavlink_gimbal": lambda: ("--wire", f"udpout:127.0.0.1:{free_port()}"),
    "grbl": lambda: ("--wire", SERIAL_OVER_TCP),
    "dronecan_servo": tuple,
}


@pytest.mark.parametrize("kind", ["dronecan_servo", *in_soak("mavlink_gimbal", "grbl")])
def test_a_driver_in_another_process_turns_the_array_of_a_world(kind, tmp_path):
    """The world reports late while it computes its room."""
    out = tmp_path / "out"
    command = ["world", "one-talker", "--json", "--actuator", kind, "--start", "now", "--out", str(out), *WIRES[kind]()]
    with ross(tmp_path, *command) as world, driver({"kind": kind, "wire": world.told["wire"]}, watchdog_s=5.0) as one:
        one.ready()
        one.turn(one.actuator.state().angle + 0.3)
    truth = json.loads((out / "truth.json").read_text())
    assert truth["complaints"] == []
    assert truth["began_s"] is not None
