"""The library lgpio itself, on a chip that is preloaded into the process: what it makes of our waves."""

from __future__ import annotations

import importlib.util
import json
import os
import shutil
import subprocess
import sys
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

HERE = Path(__file__).parent
WAKING = 0.020  # the idle thread looks for waves that often [s]
RECORD = np.dtype([("time", np.float64), ("bits", np.uint64)])


@pytest.fixture(scope="module")
def played(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What was planned, what was reported, and what the lines did."""
    if shutil.which("gcc") is None or not Path("/usr/include/linux/gpio.h").exists():
        pytest.skip("needs apt install gcc linux-libc-dev")
    if importlib.util.find_spec("lgpio") is None:
        pytest.skip("needs pip install lgpio")
    folder = tmp_path_factory.mktemp("pins")
    chip = folder / "chip.so"
    subprocess.run(["gcc", "-shared", "-fPIC", "-o", chip, HERE / "fake_gpiochip.c", "-ldl"], check=True)
    environment = {"LD_PRELOAD": str(chip), "ROSS_EDGES": str(folder / "edges")}
    process = subprocess.run(
        [sys.executable, HERE / "pins_process.py"],
        env=os.environ | environment,
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert process.returncode == 0, process.stderr
    told: dict[str, Any] = json.loads(process.stdout)
    told["lines"] = np.fromfile(folder / "edges", dtype=RECORD)
    told["folder"] = folder
    return told


def changes(lines: np.ndarray) -> list[tuple[float, int, bool]]:
    """Time [s], line and level of every change, without the levels at the beginning."""
    found = []
    for before, after in pairwise(lines):
        found += [
            (float(after["time"]), bit, bool(int(after["bits"]) >> bit & 1))
            for bit in range(3)
            if (int(before["bits"]) ^ int(after["bits"])) >> bit & 1
        ]
    return found


def test_every_edge_comes_out_once_and_in_order(played: dict[str, Any]) -> None:
    planned = [tuple(edge[1:]) for edge in played["planned"]]
    assert played["lines"]["bits"][0] == 0b100  # claimed as the first segment wants them
    assert [edge[1:] for edge in changes(played["lines"])] == planned[1:]
    assert sum(1 for line, level in planned if line == 0 and level) == 800


def test_the_stream_begins_at_the_next_waking_and_does_not_drift(played: dict[str, Any]) -> None:
    """Lateness of a busy computer is not judged; a sleep that adds up would be 0.1 s behind at the end."""
    times = np.array([edge[0] for edge in changes(played["lines"])])
    behind = times - np.array([edge[0] for edge in played["planned"][1:]])
    least = [np.min(third) for third in np.array_split(behind, 3)]
    assert min(least) >= -0.001
    assert min(least) <= played["handed"] + WAKING + 0.1 + played["stalled"]
    assert np.ptp(least) < 0.02


def test_a_wave_is_reported_after_its_last_edge(played: dict[str, Any]) -> None:
    reports, cuts = np.array(played["reports"]), np.array(played["cuts"])
    assert reports[:, 0].tolist() == cuts[1:].tolist()
    assert np.all(reports[:, 1] >= cuts[1:])
    last = changes(played["lines"])[-1][0]
    assert reports[-1, 1] >= last - 1e-4


def test_no_litter_is_left_where_the_process_runs(played: dict[str, Any]) -> None:
    assert sorted(path.name for path in played["folder"].iterdir()) == ["chip.so", "edges"]
