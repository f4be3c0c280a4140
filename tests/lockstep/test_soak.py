"""Full figures of whole missions; minutes long."""

import json

import numpy as np
import pytest

from ross_sim.study.runs.mission_design import MissionStudy, MissionTask
from ross_sim.study.runs.mission_draw import fly

DRAWS = 20
ROOMS = ("living-room", "office", "hall")


def flown(scenario, speech, **changes):
    study = MissionStudy(scenarios=(scenario,), draws=DRAWS, targets=("present",), **changes)
    tasks = [MissionTask(scenario, 3, draw) for draw in range(DRAWS)]
    return [fly(task, study, speech).missions[0] for task in tasks]


@pytest.mark.soak
def test_random_recorded_talkers_are_found_recognised_and_separated(speech):
    rows = flown("demo", speech, places="written")
    failed = [(row.seed, row.reason) for row in rows if row.reason]
    assert len(failed) <= 1, failed
    assert np.mean([row.si_sdri_db for row in rows if row.si_sdri_db is not None]) > 12


@pytest.mark.soak
def test_random_layouts_of_synthetic_talkers_are_found_recognised_and_separated():
    rows = flown("demo", None)
    failed = [(row.seed, row.reason) for row in rows if row.reason]
    assert len(failed) <= 2, failed


@pytest.mark.soak
@pytest.mark.parametrize("name", ROOMS)
def test_a_true_room_gives_the_same_mission_on_a_rerun(run, name, tmp_path):
    """The room is computed the first time and read from the disk the second."""
    told = []
    for _ in range(2):
        code, out, err = run("sitl", "--scenario", name, "--seed", "1", "--json")
        assert code in (0, 3), err
        report = json.loads(out)
        del report["timing"]
        told.append((code, report))
    assert told[0] == told[1]
