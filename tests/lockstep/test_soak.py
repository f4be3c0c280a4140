"""Full figures of whole missions; minutes long."""

import numpy as np
import pytest

from ross_sim.scenario import load
from ross_sim.study.mission_study import draw
from ross_sim.talkers.speech import load_folder
from ross_sim.talkers.synthetic_voices import synthetic_voices

DRAWS = range(1000, 1020)


@pytest.mark.soak
def test_random_recorded_talkers_are_found_recognised_and_separated(speech):
    scenario = load("demo")
    voices = load_folder(speech, scenario.payload.audio.rate_hz)
    rows = [draw(scenario, voices, seed, same_layout=True) for seed in DRAWS]
    failed = [(row.seed, row.reason) for row in rows if row.reason]
    assert len(failed) <= 1, failed
    assert np.mean([row.si_sdri_db for row in rows if row.si_sdri_db is not None]) > 12


@pytest.mark.soak
def test_random_layouts_of_synthetic_talkers_are_found_recognised_and_separated():
    scenario = load("demo")
    voices = synthetic_voices(scenario.payload.audio.rate_hz)
    rows = [draw(scenario, voices, seed, same_layout=False) for seed in DRAWS]
    failed = [(row.seed, row.reason) for row in rows if row.reason]
    assert len(failed) <= 2, failed
