"""Talkers below a hovering array: found, told their elevation, and separated end to end."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from short_mission import brief

pytestmark = pytest.mark.lockstep


def test_talkers_below_are_found_and_the_target_is_separated(tmp_path: Path) -> None:
    """The talkers are 22 to 58 deg below: at one's cosine a horizontal one would be up to 58 deg away."""
    out = tmp_path / "out"
    command = [
        sys.executable,
        "-m",
        "ross_payload.cli",
        "sitl",
        "--scenario",
        str(brief("from-above", tmp_path)),
        "--seed",
        "1",
    ]
    done = subprocess.run(
        [*command, "--out", str(out), "--json"], capture_output=True, text=True, check=False, timeout=250
    )
    assert done.returncode == 0, done.stderr
    report = json.loads((out / "report.json").read_text())
    assert (report["outcome"], report["k"]) == ("target_found", 3)
    assert all(abs(source["azimuth_error_deg"]) < 5 for source in report["sources"])
    assert all(abs(source["elevation_deg"] - source["elevation_true_deg"]) < 10 for source in report["sources"])
    target = next(group for group in report["groups"] if group["target"])
    assert target["talkers"] == [report["target"]]
    assert target["si_sdri_db"] > 12
