"""`ross run` under a service manager that is a real socket: ready, alive, stopping, and what its log says."""

import json
import os
import signal
import socket
import subprocess

import numpy as np
import pytest
import soundfile

from processes import ROSS

START = 60.0  # [s] that a busy computer may need

CONFIGURATION = """
[audio]
source = "file:{audio}"
[[links]]
url = "udpout:127.0.0.1:9"
[service]
state_dir = "{state}"
log_format = "json"
"""


@pytest.fixture
def manager(tmp_path):
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as wire:
        wire.bind(str(tmp_path / "notify"))
        wire.settimeout(START)
        yield wire


@pytest.fixture
def payload(tmp_path, manager):
    """The command in a process of its own; it hears a minute of noise."""
    audio = 0.01 * np.random.default_rng(0).standard_normal((60 * 16000, 2))
    soundfile.write(tmp_path / "heard.wav", audio, 16000, subtype="PCM_24")
    path = tmp_path / "ross.toml"
    path.write_text(CONFIGURATION.format(audio=tmp_path / "heard.wav", state=tmp_path / "state"))
    environment = {**os.environ, "NOTIFY_SOCKET": manager.getsockname(), "WATCHDOG_USEC": "2000000"}
    command = [*ROSS, "run", path]
    with subprocess.Popen(command, env=environment, stderr=subprocess.PIPE, text=True) as process:
        yield process
        process.kill()


def until(manager, word):
    """What the manager hears up to a word."""
    heard = []
    while not any(word in each for each in heard):
        heard.append(manager.recv(4096).decode())
    return heard


def test_systemd_hears_that_it_is_ready_alive_and_stopping_and_the_log_is_json(manager, payload):
    until(manager, "READY=1")
    for _ in range(4):  # two seconds, which is the watchdog's whole period
        until(manager, "WATCHDOG=1")
    payload.send_signal(signal.SIGTERM)
    assert "STATUS=SIGTERM" in until(manager, "STOPPING=1")[-1]
    _, log = payload.communicate(timeout=START)
    assert payload.returncode in (0, 130)
    lines = [json.loads(line) for line in log.splitlines() if line.startswith("{")]
    assert {"level", "logger", "message", "fields", "time"} <= set(lines[0])
    assert any(line["logger"] == "ross_payload.mission" for line in lines)


def test_a_process_that_is_held_up_pings_no_more(manager, payload):
    until(manager, "WATCHDOG=1")
    payload.send_signal(signal.SIGSTOP)
    manager.settimeout(2.0)  # the watchdog's period
    with pytest.raises(TimeoutError):
        for _ in range(1000):  # what was sent before
            manager.recv(4096)
    payload.send_signal(signal.SIGCONT)
    manager.settimeout(START)
    until(manager, "WATCHDOG=1")
