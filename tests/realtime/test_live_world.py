"""`ross world` as its user starts it: addresses, truth, mistakes."""

import json
import os
import signal
import subprocess
import sys

import pytest

from device_bench import driver, ross
from ports import free_port
from ross_payload.clock import may_hurry
from ross_sim.live_world.world_session import URGENCY
from waiting import wait_for


def test_a_world_that_nobody_listens_to_ends_cleanly_with_a_truth_of_nothing(tmp_path):
    out, voice = tmp_path / "out", tmp_path / "voice.wav"
    command = [sys.executable, "-m", "ross_payload.cli", "world", "one-talker", "--json"]
    command += ["--out", out, "--enrolment", voice]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as world:
        told = json.loads(world.stdout.readline())
        world.send_signal(signal.SIGINT)
        _, err = world.communicate(timeout=60)
    assert (world.returncode, err) == (0, "")
    assert told["wire"].startswith("pulses:tcp:127.0.0.1:")
    truth = json.loads((out / "truth.json").read_text())
    assert (truth["samples"], truth["began_s"], len(truth["talkers"])) == (0, None, 1)
    assert voice.stat().st_size > 100_000


def test_a_world_that_sounds_goes_before_everything_ordinary_as_a_sound_card_does(tmp_path):
    expected = (os.SCHED_RR | os.SCHED_RESET_ON_FORK, URGENCY) if may_hurry() else (os.SCHED_OTHER, 0)

    def priority():
        pid = world.running.pid
        return os.sched_getscheduler(pid), os.sched_getparam(pid).sched_priority

    with ross(tmp_path, "world", "one-talker", "--json", "--start", "now") as world:
        wait_for(lambda: priority() == expected)


WIRES = {
    "mavlink_gimbal": lambda: ("--wire", f"udpout:127.0.0.1:{free_port()}"),
    "grbl": tuple,
    "dronecan_servo": tuple,
}


@pytest.mark.parametrize("kind", WIRES)
def test_a_driver_in_another_process_turns_the_array_of_a_world(kind, tmp_path):
    out = tmp_path / "out"
    command = ["world", "one-talker", "--json", "--actuator", kind, "--start", "now", "--out", str(out), *WIRES[kind]()]
    with ross(tmp_path, *command) as world, driver({"kind": kind, "wire": world.told["wire"]}) as one:
        one.ready()
        one.turn(one.actuator.state().angle + 0.3)
    truth = json.loads((out / "truth.json").read_text())
    assert truth["complaints"] == []
    assert truth["began_s"] is not None


BAD = {
    "expected tcp:HOST:PORT": ["--pcm", "udp:127.0.0.1:1"],
    "--wire: expected pulses": ["--wire", "ideal:tcp:127.0.0.1:0"],
    "not a named pipe": ["--pipe", __file__],
    "unknown": ["party"],
    "expected a scenario without one": ["drone-yaw"],
    "cannot listen": ["--pcm", "tcp:192.0.2.1:0"],
}


@pytest.mark.parametrize("words", BAD)
def test_what_a_world_cannot_do_is_one_line_and_exit_code_2(run, words):
    code, out, err = run("world", *BAD[words])
    assert (code, out) == (2, "")
    assert words in err
    assert err.count("\n") == 1
