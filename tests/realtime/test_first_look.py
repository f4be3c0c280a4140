"""The first look at a device in another process: `ross actuators probe`, and the contract of real devices."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from device_bench import ROSS, Process, device

ROOT = Path(__file__).parents[2]
PYTEST = "import sys; import pytest; import ross_payload; sys.exit(pytest.main(sys.argv[1:]))"  # is forked


@pytest.fixture
def servo(tmp_path):
    (tmp_path / "device").mkdir()
    with device(tmp_path / "device", "servo") as process:
        wire = process.told["wire"]
        options = f'options = {{ port = "{wire}" }}'
        (tmp_path / "bench.toml").write_text(f'[actuator]\nkind = "dronecan_servo"\n{options}\n')
        yield process


def probe(folder, *options):
    command = [*ROSS, "actuators", "probe", "bench.toml", *options]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120, check=False)


def angle_deg(process: Process) -> float:
    return process.ask("status")["angle_deg"]


def test_a_look_moves_nothing_and_five_degrees_come_back(servo, tmp_path):
    looked = probe(tmp_path)
    assert looked.returncode == 0, looked.stdout + looked.stderr
    assert angle_deg(servo) == 0.0
    moved = probe(tmp_path, "--move", "--yes", "--json")
    told = json.loads(moved.stdout)
    assert moved.returncode in {0, 1}, told  # a busy computer may see a slow one
    assert told["figures"]["move"]["error_deg"] < 0.5
    assert abs(angle_deg(servo)) < 0.5


def test_ctrl_c_in_the_middle_of_a_move_ends_it_in_good_order(servo, tmp_path):
    bench = tmp_path / "bench.toml"
    bench.write_text(bench.read_text() + "[guard]\nmax_speed_deg_s = 1.0\n")  # a busy computer sees the middle, too
    command = [*ROSS, "actuators", "probe", "bench.toml", "--move", "--yes"]
    with subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True) as run:
        end = time.monotonic() + 60
        while abs(angle_deg(servo)) < 1.0:
            assert time.monotonic() < end
            time.sleep(0.01)
        run.send_signal(signal.SIGINT)
        said = run.communicate(timeout=60)[1]
    assert (run.returncode, said.strip()) == (130, "ross: interrupted")
    here = angle_deg(servo)
    assert abs(here) < 4.5
    time.sleep(0.5)
    assert angle_deg(servo) == pytest.approx(here, abs=0.1)


@pytest.mark.soak
def test_a_device_in_another_process_is_held_to_the_contract_of_real_ones(servo, tmp_path):
    file = str(tmp_path / "bench.toml")
    which = "another_thread or stale_feedback"
    command = ["-q", "-m", "hardware", "--actuator", file, "-k", which, "tests/contract/test_actuator.py"]
    done = subprocess.run(
        [sys.executable, "-c", PYTEST, "-p", "no:cacheprovider", *command],
        cwd=ROOT, capture_output=True, text=True, timeout=250, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout
    assert "2 passed" in done.stdout
