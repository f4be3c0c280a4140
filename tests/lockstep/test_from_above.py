"""Talkers below a hovering array: found, told their elevation, and separated end to end."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from recording_bench import only
from ross_payload.config import Config
from short_mission import brief

pytestmark = pytest.mark.lockstep


def flown(name: str, folder: Path, *options: str) -> dict[str, Any]:
    """The report of a mission in a built-in scenario, seed 1."""
    out = folder / "out"
    command = [sys.executable, "-m", "ross_payload.cli", "sitl", "--scenario", str(brief(name, folder)), "--seed", "1"]
    done = subprocess.run(
        [*command, "--out", str(out), "--json", *options], capture_output=True, text=True, check=False, timeout=250
    )
    assert done.returncode == 0, done.stderr
    report: dict[str, Any] = json.loads((out / "report.json").read_text())
    return report


def test_talkers_below_are_found_and_the_target_is_separated(tmp_path: Path) -> None:
    """The talkers are 22 to 58 deg below: at one's cosine a horizontal one would be up to 58 deg away."""
    report = flown("from-above", tmp_path)
    assert (report["outcome"], report["k"]) == ("target_found", 3)
    assert all(abs(source["azimuth_error_deg"]) < 5 for source in report["sources"])
    assert all(abs(source["elevation_deg"] - source["elevation_true_deg"]) < 10 for source in report["sources"])
    target = next(group for group in report["groups"] if group["target"])
    assert target["talkers"] == [report["target"]]
    assert target["si_sdri_db"] > 12


def test_twenty_metres_below_rotors_the_height_of_the_autopilot_finds_everybody(tmp_path: Path) -> None:
    """The talkers are 70 to 79 deg below: nobody looks for delays so short who does not know the height."""
    report = flown("from-above-20", tmp_path, "--record", str(tmp_path / "tapes"))
    assert (report["outcome"], report["k"]) == ("target_found", 3)
    assert all(abs(source["azimuth_error_deg"]) < 8 for source in report["sources"])
    assert all(abs(source["elevation_deg"] - source["elevation_true_deg"]) < 3 for source in report["sources"])
    assert next(group for group in report["groups"] if group["target"])["talkers"] == [report["target"]]
    heights = [hop.attitude.height for hop in only(tmp_path / "tapes").inputs(Config().audio)]
    assert heights[-1] == pytest.approx(20.0)
    assert sum(height is None for height in heights) < 400  # 4 s, until the autopilot has been asked and answers
