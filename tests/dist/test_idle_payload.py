"""What a payload takes that is installed into an empty environment and waits for a command."""

import os
import signal
import socket
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest
import soundfile

from bare_debian import ROOT, run

pytestmark = pytest.mark.soak

EXTRAS = "capture,serial"
MOST_MB, MOST_CPU_S = 150, 3.0
IDLE_S = 10.0
RATE = 16000
CONFIG = """
[audio]
source = "file:{folder}/noise.wav"
[actuator]
kind = "tb6600"
[[links]]
url = "udpout:127.0.0.1:{port}"
[service]
state_dir = "{folder}/state"
"""


@pytest.fixture(scope="module")
def ross(tmp_path_factory, wheels):
    """The command in an environment of Debian's Python that holds the wheel, its extras and nothing else."""
    folder = tmp_path_factory.mktemp("empty")
    run(["/usr/bin/python3", "-m", "venv", folder / "venv"])
    pip = [folder / "venv/bin/python", "-m", "pip", "--quiet"]
    offline = ["--no-index", "--find-links", wheels]
    run([*pip, "wheel", "--no-deps", *offline, "--wheel-dir", folder, ROOT])
    run([*pip, "install", *offline, f"{next(folder.glob('*.whl'))}[{EXTRAS}]"])
    return folder / "venv/bin/ross"


def processor_s(pid):
    """What a process has used [s]."""
    words = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


def memory_mb(pid):
    """The memory in which a process lies, shared libraries included."""
    status = dict(line.split(":", 1) for line in Path(f"/proc/{pid}/status").read_text().splitlines())
    return int(status["VmRSS"].split()[0]) * 1024 / 1e6


def is_heartbeat(packet):
    """Whether it is one of MAVLink 2: its number, in three bytes behind six others and the marker, is 0."""
    return packet[0] == 0xFD and packet[7:10] == bytes(3)


def started(ross, folder):
    """Start a payload; return its processor time to the first heartbeat and while idle [s], and its memory [MB]."""
    soundfile.write(folder / "noise.wav", np.random.default_rng(0).normal(0, 0.01, (RATE * 120, 2)), RATE)
    environment = {"PATH": "/usr/bin:/bin", "HOME": str(folder), "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as ground:
        ground.bind(("127.0.0.1", 0))
        ground.settimeout(120)
        (folder / "ross.toml").write_text(CONFIG.format(folder=folder, port=ground.getsockname()[1]))
        process = subprocess.Popen([ross, "run", folder / "ross.toml"], env=environment, cwd=folder)
        try:
            while not is_heartbeat(ground.recv(2048)):
                continue
            start = processor_s(process.pid)
            time.sleep(IDLE_S)
            return start, processor_s(process.pid) - start, memory_mb(process.pid)
        finally:
            process.send_signal(signal.SIGTERM)
            assert process.wait(60) == 0


def test_an_idle_payload_takes_less_than_150_mb_and_three_seconds_to_start(ross, tmp_path):
    start, idle, memory = started(ross, tmp_path)
    print(f"start {start:.2f} s, idle {idle / IDLE_S:.1%} of a core, {memory:.0f} MB")  # noqa: T201  figures of the manual
    assert start < MOST_CPU_S
    assert memory < MOST_MB
