"""An acknowledged stop is on the disk: `ross run`, killed at the moment of the acknowledgement, stays stopped."""

import os
import signal
import socket
import subprocess
import sys
import time
from contextlib import contextmanager

import numpy as np
import pytest
import soundfile

from ports import free_port
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.values import Health, Heartbeat

RATE = 16000
STOP, EXPLORE = 54004, 54000
ACCEPTED = 0
START_S = 60.0  # that a busy computer may need
CONFIGURATION = """
[audio]
source = "file:{noise}"
[actuator]
kind = "tb6600"
options = {{ ahead_ms = 500 }}
[service]
state_dir = "state"
autostart = "explore"
[[links]]
url = "udpin:127.0.0.1:{port}"
"""
# One process that has imported everything, and `ross run` in a child of it for every line that it is told: a folder.
NURSERY = """
import os, signal, sys
import ross_payload.service.live
from ross_payload import cli
signal.signal(signal.SIGCHLD, signal.SIG_IGN)
for line in sys.stdin:
    if not (child := os.fork()):
        os.chdir(line.strip())
        with open("log", "a") as log:
            os.dup2(log.fileno(), 2)
        sys.argv = ["ross", "run", "ross.toml"]
        cli.main()
    print(child, flush=True)
"""


@pytest.fixture
def payloads(tmp_path):
    """Start ``ross run`` in a folder; gives its process id."""
    noise = np.random.default_rng(0).integers(-300, 300, (60 * RATE, 2), np.int16)
    soundfile.write(tmp_path / "noise.wav", noise, RATE)
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    with subprocess.Popen([sys.executable, "-c", NURSERY], **pipes) as nursery:

        @contextmanager
        def start(folder, port):
            folder.mkdir(exist_ok=True)
            (folder / "ross.toml").write_text(CONFIGURATION.format(noise=tmp_path / "noise.wav", port=port))
            print(folder, file=nursery.stdin, flush=True)
            number = int(nursery.stdout.readline())
            try:
                yield number
            finally:
                killed(number)

        yield start
        nursery.stdin.close()
        nursery.wait(START_S)


def killed(number):
    """End a process at once."""
    try:
        os.kill(number, signal.SIGKILL)
    except ProcessLookupError:
        return


def until_answered(port, number):
    """Stop a payload that has begun to explore; return its last answer, and end it as that arrives."""
    encoder, decoder, end = Encoder(255, 190), Decoder(), time.monotonic() + START_S
    stop = common.MAVLink_command_long_message(1, 191, STOP, 0, *[0.0] * 7)
    exploring = stopped = False
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as ground:
        ground.connect(("127.0.0.1", port))
        ground.settimeout(0.2)
        while time.monotonic() < end:
            try:
                if not exploring or stopped:
                    ground.send(encoder.encode(Heartbeat(Health.ACTIVE, 6)))
                packets = decoder.feed(ground.recv(2048))
            except OSError:  # it is starting
                continue
            for packet in packets:
                if (
                    packet.name == "COMMAND_ACK"
                    and packet.message.command == STOP
                    and packet.message.result == ACCEPTED
                ):
                    killed(number)
                    return ACCEPTED
                exploring = exploring or (packet.name == "HEARTBEAT" and packet.component_id == 191)
            if exploring and not stopped:
                ground.send(encoder.encode(stop))
                stopped = True
    return None


def remembered(payloads, folder, count):
    """How many of so many stops, each of a payload that was killed at the answer, are remembered."""
    found = 0
    for attempt in range(count):
        port, place = free_port(), folder / str(attempt)
        with payloads(place, port) as number:
            assert until_answered(port, number) == ACCEPTED, (place / "log").read_text()
        found += (place / "state" / "stopped").exists()
    return found


def test_a_payload_killed_as_it_acknowledges_a_stop_does_not_explore_again(payloads, tmp_path):
    assert remembered(payloads, tmp_path, 5) == 5
    (tmp_path / "0" / "log").write_text("")
    with payloads(tmp_path / "0", free_port()):
        end = time.monotonic() + START_S
        while "stopped" not in (said := (tmp_path / "0" / "log").read_text()):
            assert time.monotonic() < end, said
            time.sleep(0.05)
    assert "lead in" not in said, "it explores"


@pytest.mark.soak
def test_of_a_hundred_stops_none_is_lost_with_the_process(payloads, tmp_path):
    assert remembered(payloads, tmp_path, 100) == 100
