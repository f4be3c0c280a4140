"""What the how-to guides show works as printed."""

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

from ports import free_port
from ross_sim.scenario import load

ROOT = Path(__file__).parents[2]
HOW_TO = ROOT / "docs" / "how-to"


def block(page, language):
    return re.search(rf"```{language}\n(.*?)```", (HOW_TO / page).read_text(encoding="utf-8"), re.DOTALL).group(1)


def test_the_scenario_of_the_guide_is_valid(tmp_path):
    path = tmp_path / "table.toml"
    path.write_text(block("write-a-scenario.md", "toml"))
    assert len(load(path).talkers) == 3


def test_the_guide_reads_the_log_of_a_mission(tmp_path):
    command = [sys.executable, "-m", "ross_payload.cli", "sitl", "--scenario", "one-talker", "--out", "out/demo"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, timeout=250)
    program = block("read-telemetry.md", "python")
    environment = os.environ | {"MAVLINK20": "1"}
    read = [sys.executable, "-c", program]
    done = subprocess.run(read, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 0, done.stderr
    index, azimuth, confidence = done.stdout.splitlines()[-1].split()
    assert int(index) == 0
    assert float(confidence) > 0.5
    assert abs(float(azimuth)) < 360


def test_the_guide_commands_a_simulated_payload(tmp_path):
    port = free_port()
    served = [sys.executable, "-m", "ross_payload.cli", "sitl", "--serve", "--scenario", "one-talker"]
    ground = [sys.executable, "-c", block("command-the-payload.md", "python"), f"udpin:127.0.0.1:{port}"]
    with subprocess.Popen([*served, "--telemetry", f"udpout:127.0.0.1:{port}"], cwd=tmp_path) as payload:
        try:
            environment = os.environ | {"MAVLINK20": "1"}
            done = subprocess.run(ground, env=environment, capture_output=True, text=True, check=False, timeout=200)
        finally:
            payload.send_signal(signal.SIGINT)
            payload.wait(60)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == "turned"
