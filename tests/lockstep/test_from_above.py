"""Talkers below a hovering array: found, told their elevation, and separated end to end."""

from __future__ import annotations

from pathlib import Path

import pytest

from recording_bench import only
from ross_payload.config import Config
from short_mission import CHEAP, LATER, SOON, brief

pytestmark = [pytest.mark.lockstep, pytest.mark.soak]


def test_talkers_below_are_found_and_the_target_is_separated(fly, tmp_path: Path) -> None:
    """The talkers are 22 to 58 deg below: at one's cosine a horizontal one would be up to 58 deg away."""
    report = fly(
        "--scenario", brief("from-above", tmp_path, explore=LATER, check_s=1.0, run_s=1.0, **CHEAP), "--seed", 1
    )
    assert (report["outcome"], report["k"]) == ("target_found", 3)
    assert all(abs(source["azimuth_error_deg"]) < 5 for source in report["sources"])
    assert all(abs(source["elevation_deg"] - source["elevation_true_deg"]) < 10 for source in report["sources"])
    target = next(group for group in report["groups"] if group["target"])
    assert target["talkers"] == [report["target"]]
    assert target["si_sdri_db"] > 12


def test_twenty_metres_below_rotors_the_height_of_the_autopilot_finds_everybody(fly, tmp_path: Path) -> None:
    """The talkers are 70 to 79 deg below: nobody looks for delays so short who does not know the height."""
    asked = brief("from-above-20", tmp_path, explore=SOON | {"unit_s": 2.0}, check_s=1.0, run_s=1.0, **CHEAP)
    report = fly("--scenario", asked, "--seed", 1, "--record", tmp_path / "tapes")
    assert (report["outcome"], report["k"]) == ("target_found", 3)
    assert all(abs(source["azimuth_error_deg"]) < 8 for source in report["sources"])
    assert all(abs(source["elevation_deg"] - source["elevation_true_deg"]) < 3 for source in report["sources"])
    assert next(group for group in report["groups"] if group["target"])["talkers"] == [report["target"]]
    heights = [hop.attitude.height for hop in only(tmp_path / "tapes").inputs(Config().audio)]
    assert heights[-1] == pytest.approx(20.0)
    assert sum(height is None for height in heights) < 400  # 4 s, until the autopilot has been asked and answers
