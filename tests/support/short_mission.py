"""The shortest scenario that is a mission, of three talkers, two or one, a live payload that hears a file of noise,
and built-in scenarios that end sooner.
"""

import tomllib
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import tomlkit

import ross_sim

Table = Mapping[str, Any]

SCENARIOS = Path(ross_sim.__file__).parents[1] / "scenarios"
NOTHING: Table = MappingProxyType({})
SOON: Table = MappingProxyType(  # explores in a fifth of the time, where nothing makes it hard
    {"lead_in_s": 1.0, "unit_s": 1.5, "min_rotations": 2, "max_rotations": 2}
)
LATER: Table = MappingProxyType(SOON | {"min_rotations": 4, "max_rotations": 4})
CHEAP: Table = MappingProxyType(  # a third of the work: where it does not matter who separates, and everybody rests
    {"separator": "gaussian", "track": False}
)

THREE = """
[[talkers]]
azimuth_deg = 40
[[talkers]]
azimuth_deg = 155
[[talkers]]
azimuth_deg = -80
"""

TWO = THREE.rsplit("[[talkers]]", 1)[0]

SHORT = """
title = "a short mission"
[payload.explore]
lead_in_s = 2.0
unit_s = 0.5
min_rotations = 1
max_rotations = 2
[payload.exploit]
separator = "gaussian"
track = false
check_s = 1.0
run_s = 1.0
max_restarts = 0
"""
PAIR = SHORT + TWO
ALONE = SHORT + "[[talkers]]\nazimuth_deg = 40\n"
SHORT += THREE

NOISE = """
[audio]
source = "file:noise.wav"
[actuator]
kind = "tb6600"
options = {{ ahead_ms = 500 }}
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


def as_long(folder: Path) -> Path:
    """Write the default scenario with as long an exploration for every actuator; its path.

    Whoever explores longer hears other words then, and separates them better or worse.
    """
    path = folder / "as-long.toml"
    rotations = "\n[payload.explore]\nmin_rotations = 6\nmax_rotations = 6\n"
    path.write_text((SCENARIOS / "demo.toml").read_text(encoding="utf-8") + rotations, encoding="utf-8")
    return path


def brief(name: str, folder: Path, *, explore: Table = NOTHING, **exploit: Any) -> Path:
    """Write a built-in scenario that checks and hears the target for less time, or as it is told; its path."""
    values = tomllib.loads((SCENARIOS / f"{name}.toml").read_text(encoding="utf-8"))
    payload = values.setdefault("payload", {})
    payload["explore"] = payload.get("explore", {}) | explore
    payload["exploit"] = payload.get("exploit", {}) | {"check_s": 2.0, "run_s": 4.0} | exploit
    path = folder / f"{name}.toml"
    path.write_text(tomlkit.dumps(values), encoding="utf-8")
    return path
