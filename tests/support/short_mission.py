"""The shortest scenario that is a whole mission, its three talkers, a live payload that hears a file of noise, and
built-in scenarios that end sooner.
"""

from pathlib import Path

import ross_sim

SCENARIOS = Path(ross_sim.__file__).parents[1] / "scenarios"

THREE = """
[[talkers]]
azimuth_deg = 40
[[talkers]]
azimuth_deg = 155
[[talkers]]
azimuth_deg = -80
"""

SHORT = """
title = "a short mission"
[payload.explore]
lead_in_s = 2.0
unit_s = 0.5
min_rotations = 1
max_rotations = 2
[payload.exploit]
check_s = 1.0
run_s = 1.0
max_restarts = 0
"""
SHORT += THREE

NOISE = """
[audio]
source = "file:noise.wav"
[actuator]
kind = "tb6600"
options = {{ ahead_ms = 100 }}
[explore]
unit_s = 1.0
min_rotations = 2
max_rotations = 2
[service]
state_dir = "state"
[[links]]
url = "udpin:127.0.0.1:{port}"
"""  # of `ross run`; explores, and finds nobody


def changed(name: str, folder: Path, changes: dict[str, str]) -> Path:
    """Write a built-in scenario with other words in place of some of its own; its path."""
    text = (SCENARIOS / f"{name}.toml").read_text(encoding="utf-8")
    for words, instead in changes.items():
        assert words in text, words
        text = text.replace(words, instead)
    path = folder / f"{name}.toml"
    path.write_text(text, encoding="utf-8")
    return path


def brief(name: str, folder: Path, *, run_s: float = 4.0) -> Path:
    """Write a built-in scenario that checks and hears the target for less time; its path."""
    path = changed(name, folder, {})
    with path.open("a", encoding="utf-8") as file:
        file.write(f"\n[payload.exploit]\ncheck_s = 2.0\nrun_s = {run_s}\n")
    return path
