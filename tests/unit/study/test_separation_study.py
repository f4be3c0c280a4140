from pathlib import Path

import numpy as np
import pytest

from ross_payload.angles import difference
from ross_payload.dsp.steering import tdoa
from ross_sim.study.runs.study_case import perform
from ross_sim.study.runs.study_design import chosen, tasks
from ross_sim.study.runs.talker_placement import Source
from ross_sim.study.scenes.mixtures import VOICES, aligned_heading, layouts
from ross_sim.study.scenes.room_settings import PLANES

FLOORS = {"S1": (15.0, 13.5, 12.0), "S2": (12.2, 11.0, 9.5), "S3": (9.0, 9.5, 8.5)}  # [dB] for K = 3, 4, 5


def test_two_interferers_pose_as_one_at_the_aligned_heading() -> None:
    azimuths = np.array([0.2, 2.5, -1.0])
    tau = tdoa(azimuths, aligned_heading(azimuths, 1), 0.05, 343.0)
    np.testing.assert_allclose(tau[0], tau[2])


def test_random_layouts_keep_talkers_apart() -> None:
    for azimuths in layouts(5, 5, np.random.default_rng(0)):
        gaps = np.abs(difference(azimuths[:, None], azimuths))[~np.eye(5, dtype=bool)]
        assert gaps.min() >= np.deg2rad(25) - 1e-9


@pytest.mark.soak
@pytest.mark.parametrize("setting", PLANES)
def test_the_local_gaussian_model_reaches_the_floors(setting: str, speech: Path) -> None:
    axes = {"settings": (setting,), "layouts": 5, "separators": ("gaussian",), "noise": ("known",), "seed": 0}
    study = chosen("separation", axes, quick=False)
    source = Source(speech, VOICES, study.rate_hz)
    rows = [row for task in tasks(study) if task.target is not None for row in perform(task, study, source).separations]
    for k, floor in zip(study.k, FLOORS[setting], strict=True):
        assert np.mean([row.si_sdri_db for row in rows if row.k == k]) >= floor
