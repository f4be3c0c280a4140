"""'Add your own explorer', followed to the letter: built, installed and flown."""

import json

import pytest

from manual import command
from own_plugin import install, made, run_line

PAGE = "docs/how-to/add-your-own-explorer.md"
SHORT = """
lead_in_s = 1.0
unit_s = 2.0
min_rotations = 6
max_rotations = 6
[payload.exploit]
separator = "gaussian"
track = false
check_s = 1.0
run_s = 1.0
max_restarts = 0
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The files of the page, and the package installed beside them."""
    folder = tmp_path_factory.mktemp("own")
    assert made(PAGE, folder) == {"pyproject.toml", "my_explorer.py", "explored.toml"}
    install(folder)
    (folder / "my_explorer.py").unlink()  # only what is installed counts
    return folder


def test_a_mission_is_flown_with_it_and_finds_both_talkers(folder):
    scenario = folder / "explored.toml"
    scenario.write_text(scenario.read_text() + SHORT)
    flown = run_line(folder, command(PAGE, "ross sitl") + " --json")
    assert flown.returncode in {0, 3}, flown.stderr
    told = json.loads(flown.stdout)
    assert told["k"] == 2
    assert sorted(source["azimuth_deg"] for source in told["sources"]) == pytest.approx([30, 100], abs=5)
