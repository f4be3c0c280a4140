"""Scores beside those of other talkers: what a voice shares with everybody tells nothing."""

import numpy as np
import pytest

from ross_payload.voiceprint.built_in import built_in_model
from ross_payload.voiceprint.embedding_print import unit
from ross_payload.voiceprint.score_normalisation import NEAREST, Cohort

SIZE = 40


@pytest.fixture(scope="module")
def people():
    """A hundred talkers, (n, size)."""
    return np.array([unit(each) for each in np.random.default_rng(0).standard_normal((100, SIZE))])


def test_what_a_voice_shares_with_everybody_does_not_count(people):
    """By their cosines no threshold accepts a voice in noise and rejects a stranger who sounds like everybody."""
    rng, common = np.random.default_rng(1), unit(np.ones(SIZE))
    talkers = np.array([unit(each + 0.5 * common) for each in people])
    own, stranger, cohort = talkers[0], talkers[1], Cohort(talkers[2:])
    in_noise, like_all = unit(own + 2 * unit(rng.standard_normal(SIZE))), unit(own + 3 * common)
    assert stranger @ like_all > own @ in_noise
    assert cohort.normalised(own, in_noise) > cohort.normalised(stranger, like_all)


def test_the_nearest_talkers_count_and_no_others(people):
    voice = unit(np.random.default_rng(1).standard_normal(SIZE))
    order = np.argsort(people @ voice)[::-1]
    nearest = people[order[:NEAREST]] @ voice
    wanted = (people[0] @ voice - nearest.mean()) / nearest.std()
    assert Cohort(people).normalised(people[0], voice) == pytest.approx(wanted)
    assert Cohort(people[order[:NEAREST]]).normalised(people[0], voice) == pytest.approx(wanted)


def test_a_cohort_of_one_talker_gives_a_finite_score(people):
    assert np.isfinite(Cohort(people[:1]).normalised(people[1], people[2]))


def test_the_built_in_model_brings_its_cohort():
    model = built_in_model()
    cohort = model.parameters.cohort
    assert cohort.shape == (239, model.size)  # 211 readers and 28 synthetic voices
    assert np.linalg.norm(cohort, axis=1) == pytest.approx(1.0, abs=2e-3)  # float16
    voice, other = cohort[0], cohort[1]
    assert model.similarity(voice, voice) == pytest.approx(Cohort(cohort).normalised(voice, voice))
    assert model.similarity(voice, voice) > 3.0 > model.similarity(other, voice)
