"""What the joint explorer must reach in true rooms; an hour when no response is on disk, minutes later."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from ross_payload.localization.joint import Joint, explorer
from ross_sim.study.runs.talker_placement import Source, voices_of
from ross_sim.study.scenes.exploration import NEAR_DEG, RATE, explore, matched
from ross_sim.study.scenes.mixtures import VOICES
from ross_sim.study.scenes.room_settings import SETTINGS, SPACING, SPEED_OF_SOUND

ROOMS = ("A0.3", "A0.45", "A0.7", "B0.3", "B0.45", "B0.7")
KS = (3, 4, 5)
SEED, LAYOUTS, ROTATIONS, WORKERS = 7, 5, 12, 2

pytestmark = [pytest.mark.soak, pytest.mark.timeout(7200)]


def explored(scene: tuple[str, int, int, Path]) -> tuple[int, int, list[float]]:
    """K, K as estimated, and the error [deg] of every talker when K is told."""
    room, k, layout, speech = scene
    joint: Joint = explorer.make(SPACING, SPEED_OF_SOUND)
    voices = [voice.speech for voice in voices_of(Source(speech, VOICES, RATE))]
    heard = explore(joint, SETTINGS[room], voices, k, key=[SEED, k, layout], rotations=ROTATIONS)
    errors, _ = matched(heard.azimuths, joint.place(heard.observations, k))
    return k, joint.estimate(heard.observations).k, errors.tolist()


@pytest.fixture(scope="module")
def found(speech: Path) -> list[tuple[int, int, list[float]]]:
    with ProcessPoolExecutor(WORKERS, initializer=threadpool_limits, initargs=(1,)) as pool:
        return list(pool.map(explored, product(ROOMS, KS, range(LAYOUTS), [speech])))


def test_the_number_of_talkers_is_right_in_true_rooms(found: list[tuple[int, int, list[float]]]) -> None:
    right = [np.mean([counted == k for k, counted, _ in found if k == wanted]) for wanted in KS]
    assert (np.array(right) >= [0.85, 0.60, 0.50]).all(), right


def test_talkers_whose_number_is_known_are_placed_in_true_rooms(found: list[tuple[int, int, list[float]]]) -> None:
    errors = [of_all for _, _, of_all in found]
    assert np.mean(np.concatenate(errors) <= NEAR_DEG) >= 0.95
    assert np.mean([max(of_all) <= NEAR_DEG for of_all in errors]) >= 0.80
