"""What the how-to guides show works as printed."""

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from mission_fixtures import without_picture
from ports import free_port
from processes import ROSS
from ross_sim.scenario import load
from short_mission import CHEAP, SOON, brief

ROOT = Path(__file__).parents[2]
HOW_TO = ROOT / "docs" / "how-to"


def block(page, language, number=0):
    return re.findall(rf"```{language}\n(.*?)```", (HOW_TO / page).read_text(encoding="utf-8"), re.DOTALL)[number]


def test_the_scenario_of_the_guide_is_valid(tmp_path):
    path = tmp_path / "table.toml"
    path.write_text(block("write-a-scenario.md", "toml"))
    assert len(load(path).talkers) == 3


@pytest.mark.soak
def test_the_guide_reads_the_log_of_a_mission(tmp_path, run):
    asked = brief("one-talker", tmp_path, check_s=1.0, run_s=2.0, **CHEAP)
    with without_picture():
        code, _, error = run("sitl", "--scenario", asked, "--informed", "--out", tmp_path / "out" / "demo")
    assert code == 0, error
    program = block("read-telemetry.md", "python")
    environment = os.environ | {"MAVLINK20": "1"}
    read = [sys.executable, "-c", program]
    done = subprocess.run(read, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 0, done.stderr
    index, azimuth, confidence = done.stdout.splitlines()[-1].split()
    assert int(index) == 0
    assert float(confidence) > 0.5
    assert abs(float(azimuth)) < 360


def commanded(tmp_path, script, *options):
    """Run a script beside a served payload; the lines that it prints."""
    port = free_port()
    served = [*ROSS, "sitl", "--serve", *options]
    ground = [sys.executable, "-c", script, f"udpin:127.0.0.1:{port}"]
    with subprocess.Popen([*served, "--telemetry", f"udpout:127.0.0.1:{port}"], cwd=tmp_path) as payload:
        try:
            environment = os.environ | {"MAVLINK20": "1"}
            done = subprocess.run(ground, env=environment, capture_output=True, text=True, check=False, timeout=200)
        finally:
            payload.send_signal(signal.SIGINT)
            payload.wait(60)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def test_the_guide_commands_a_simulated_payload(tmp_path):
    script = block("command-the-payload.md", "python")
    assert commanded(tmp_path, script, "--scenario", "one-talker")[-1] == "turned"


@pytest.mark.soak
def test_the_guide_follows_an_exploration(tmp_path):
    asked = brief("one-talker", tmp_path, explore=SOON)
    lines = commanded(tmp_path, block("script-the-ground.md", "python", 1), "--speed", "4", "--scenario", asked)
    assert "state explore_listen" in lines
    assert any(line.startswith("source 0 at ") for line in lines)
    assert lines[-1] == "1 sources"
