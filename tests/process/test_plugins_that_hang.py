"""Plug-ins whose calls never return, or that leave threads behind: they are named, and every command ends."""

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
import soundfile

import waiting
from processes import program

SOON = """
import sys, threading
from ross_payload import cli, plugin_calls, program_end
from ross_payload.service import live
from ross_payload.sessions import session_writer
live.END_S = 8.0
plugin_calls.LOOK_S = 0.05
program_end.TELL_S, program_end.LEAVE_S, program_end.LAST_LINE_S = 0.3, 0.6, 1.0
sys.argv[0] = "ross"
"""
END = "cli.main()\n"
PLUGIN = """
import threading, time

def forever(*arguments):
    while True:
        time.sleep(0.01)

class Separator:
    name = "theirs"

    def batch(self, spectrogram, scene):
        {batch}

def source(address, services):
    return Source()

class Source:
    rate = 16000

    def read(self, n):
        forever()

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        pass
"""
POINTS = "[ross_payload.separators]\ntheirs = theirs:Separator\n[ross_payload.audio_sources]\ntheirs = theirs:source\n"
THREAD = "threading.Thread(target=forever, name='their worker').start(); raise ValueError('trouble')"
POOL = (
    "from concurrent.futures import ThreadPoolExecutor as Pool; Pool(1, 'theirs').submit(forever); "
    "raise ValueError('trouble')"
)
CONFIG = """
[audio]
source = "theirs:here"
[actuator]
kind = "tb6600"
[service]
state_dir = "state"
"""


@pytest.fixture
def their(tmp_path, monkeypatch):
    """Install the plug-in into a folder; return it, with the command line, which is impatient."""

    def install(batch="forever()", more=""):
        (tmp_path / "theirs.py").write_text(PLUGIN.replace("{batch}", batch))
        info = tmp_path / "theirs-1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text("Metadata-Version: 2.1\nName: theirs\nVersion: 1.0\n")
        (info / "entry_points.txt").write_text(POINTS.replace("theirs:Separator", "theirs:Separator.made"))
        with (tmp_path / "theirs.py").open("a") as file:
            file.write("Separator.made = Separator()\n")
        return [sys.executable, "-c", SOON + more + END]

    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    return install


def test_a_separator_that_never_returns_is_named(their, tmp_path):
    with program([*their(), "sitl", "--json", "--informed", "-p", "theirs"], tmp_path, code=130, lives=False) as (
        process,
        log,
    ):
        waiting.wait_for(lambda: "separator 'theirs': batch has not returned for" in log.read_text())
        for _ in range(2):  # the first one is an order to the mission, which hears nothing
            process.send_signal(signal.SIGINT)
            time.sleep(0.5)
        process.wait(10)


def test_a_source_that_never_returns_is_named_and_a_second_signal_ends_the_payload(their, tmp_path):
    (tmp_path / "ross.toml").write_text(CONFIG)
    with program([*their(), "run", "ross.toml"], tmp_path, code=130, lives=False) as (process, log):
        waiting.wait_for(lambda: "audio source 'theirs': read has not returned for" in log.read_text())
        time.sleep(2.5)
        for _ in range(2):  # a script passes on what it got itself
            process.terminate()
            time.sleep(0.3)
        time.sleep(2.5)
        assert process.poll() is None
        process.terminate()
        process.wait(20)


@pytest.mark.parametrize(("begun", "name"), [(THREAD, "their worker"), (POOL, "theirs_0")])
def test_a_thread_that_never_ends_is_named_and_not_waited_for_for_ever(their, tmp_path, begun, name):
    command = [*their(begun), "sitl", "--json", "--informed", "-p", "theirs"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 1
    assert "batch raised ValueError: trouble" in done.stdout
    waits = f"ross: still waiting for a thread that has not ended: '{name}'; the program ends soon without it\n"
    assert done.stderr.endswith(waits)


def test_an_error_that_nobody_reads_holds_no_command_up(their, tmp_path):
    read, write = os.pipe()
    os.set_blocking(write, False)
    while True:
        try:
            os.write(write, bytes(4096))
        except BlockingIOError:
            break
    os.set_blocking(write, True)
    try:
        done = subprocess.run([*their(), "run", "nowhere.toml"], cwd=tmp_path, stderr=write, check=False, timeout=60)
    finally:
        os.close(read)
        os.close(write)
    assert done.returncode == 2


def test_a_disk_that_hangs_does_not_hold_the_end_of_the_payload_up_for_ever(their, tmp_path):
    """Without systemd, which kills it."""
    command = their(more="session_writer.SessionWriter.flush = lambda self: threading.Event().wait()\n")
    soundfile.write(tmp_path / "noise.wav", np.random.default_rng(0).normal(0, 0.01, (320_000, 2)), 16000)
    config = CONFIG.replace("theirs:here", "file:noise.wav") + "[recording]\nalways = true\nmin_free_gb = 0\n"
    (tmp_path / "ross.toml").write_text(config)
    with program([*command, "run", "ross.toml"], tmp_path, code=1, lives=False) as (process, log):
        waiting.wait_for(lambda: "recording is on" in log.read_text())
        process.terminate()
        process.wait(30)
    assert log.read_text().endswith("ross: not ended after 8 s, waiting for 'recorder'; it ends so\n")


@pytest.mark.parametrize(
    ("hangs", "name"),
    [
        ("from ross_payload.service.runner import Runner as This\nThis._rest", "the mission"),
        ("from ross_payload.actuators.driver_shell import DriverShell as This\nThis.stop", "actuator 'tb6600': stop"),
    ],
    ids=["mission", "driver"],
)
def test_what_the_end_waits_for_is_named_and_no_thread_that_idles(their, tmp_path, hangs, name):
    command = their(more=f"{hangs} = lambda self: threading.Event().wait()\nlive.END_S = 2.0\n")
    soundfile.write(tmp_path / "noise.wav", np.random.default_rng(0).normal(0, 0.01, (320_000, 2)), 16000)
    (tmp_path / "ross.toml").write_text(CONFIG.replace("theirs:here", "file:noise.wav"))
    with program([*command, "run", "ross.toml"], tmp_path, code=1, lives=False) as (process, log):
        waiting.wait_for(lambda: "idle" in log.read_text())
        process.terminate()
        process.wait(30)
    assert log.read_text().endswith(f"ross: not ended after 2 s, waiting for {name}; it ends so\n")


def test_what_is_passed_on_of_a_signal_interrupts_nothing_that_is_closed(their, tmp_path):
    slow = (
        "import time\nfrom ross_payload.actuators.guard import Guard\nclose = Guard.__exit__\n"
        "def closed(*those):\n    print('closing', file=sys.stderr, flush=True)\n    time.sleep(1.5)\n"
        "    print('closed', file=sys.stderr, flush=True)\n    close(*those)\nGuard.__exit__ = closed\n"
    )
    soundfile.write(tmp_path / "noise.wav", np.random.default_rng(0).normal(0, 0.01, (320_000, 2)), 16000)
    (tmp_path / "ross.toml").write_text(CONFIG.replace("theirs:here", "file:noise.wav"))
    with program([*their(more=slow), "run", "ross.toml"], tmp_path, code=0, lives=False) as (process, log):
        waiting.wait_for(lambda: "idle" in log.read_text())
        process.terminate()
        waiting.wait_for(lambda: "closing" in log.read_text())
        process.terminate()
        process.wait(30)
    assert "closed" in log.read_text()
