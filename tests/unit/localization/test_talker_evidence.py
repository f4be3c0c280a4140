"""What tells a talker from a ghost, on histograms whose truth is put in, and the probability that follows."""

from __future__ import annotations

import numpy as np
import pytest

from ross_payload.angles import difference
from ross_payload.interfaces import Real
from ross_payload.localization import itd_mixture, model_order, talker_evidence
from ross_payload.localization.itd_mixture import Data, Mixture
from ross_payload.localization.model_order import Step
from ross_payload.localization.talker_evidence import BELOW, FEATURES, WHITE, Evidence, Logistic

HEADINGS, GRID = np.deg2rad(15.0) * np.arange(9), np.linspace(-1.5, 1.5, 61)
TALKERS = np.deg2rad([0.0, 100.0, -130.0])
N_BLOCKS = 60


def evidence(loud: Real, azimuths: Real = TALKERS) -> Evidence:
    """What is heard at all headings of sources that are ``loud`` (k, n_blocks) [counts]."""
    centres = np.cos(azimuths - HEADINGS[:, None])  # (n_headings, k)
    kernels = np.exp(-0.5 * ((GRID - centres[..., None]) / 0.08) ** 2)
    kernels /= kernels.sum(axis=-1, keepdims=True)
    blocks = [loud.T @ kernel + 1e-3 for kernel in kernels]
    rich = np.stack([block.sum(axis=0) for block in blocks])
    return Evidence(Data(GRID, HEADINGS, rich), Data(GRID, HEADINGS, rich), blocks)


def turns(shares: Real, rng: np.random.Generator) -> Real:
    """Talkers of which one at a time speaks, for ``shares`` of the time, (k, n_blocks)."""
    return 2.0 * (np.arange(len(shares))[:, None] == rng.choice(len(shares), N_BLOCKS, p=shares))


def step_of(heard: Evidence, k: int) -> Step:
    found = model_order.search(heard.rich, model_order.Penalty(), k)
    assert found is not None
    return found


def told(heard: Evidence, step: Step) -> list[dict[str, float]]:
    rows = talker_evidence.features(heard, step, 0.0, range(len(step.worth)))
    return [dict(zip(FEATURES, row.tolist(), strict=True)) for row in rows]


def nearest(step: Step, azimuth: float) -> int:
    return int(np.abs(difference(step.model.azimuths, azimuth)).argmin())


def test_who_speaks_alone_dominates_and_who_echoes_does_not() -> None:
    """The third source sounds whenever the first does, at a third of its loudness, as a reflection would."""
    loud = turns(np.array([0.6, 0.4]), np.random.default_rng(0))
    echoed = evidence(np.stack([*loud, loud[0] / 3]))
    step = step_of(echoed, 3)
    rows = told(echoed, step)
    echo, talker = (rows[nearest(step, TALKERS[k])] for k in (2, 1))
    assert echo["dominance"] < 0.5 < talker["dominance"]
    assert echo["alike"] > 0.6 > talker["alike"]
    assert echo["margin"] < 0.3 < talker["margin"]


def test_an_echo_is_less_probable_than_a_talker_of_the_same_strength() -> None:
    rng = np.random.default_rng(1)
    first, second, third = turns(np.array([0.5, 0.35, 0.15]), rng)
    amid = evidence(np.stack([first, second, third]))
    echo = evidence(np.stack([first, second, first * third.sum() / first.sum()]))
    odds = []
    for heard in (amid, echo):
        step = step_of(heard, 3)
        asked = talker_evidence.features(heard, step, 0.0, [nearest(step, TALKERS[2])])
        odds.append(
            [model.probability(asked)[0] for model in (talker_evidence.trees(), talker_evidence.fitted("count", BELOW))]
        )
    assert np.all(np.greater(*odds))


def test_features_are_finite_when_little_is_heard() -> None:
    for heard in (evidence(np.full((3, N_BLOCKS), 1e-6)), evidence(np.full((3, 1), 1.0))):
        for step in model_order.steps(heard.rich, model_order.Penalty()):
            assert np.isfinite(talker_evidence.features(heard, step, 0.0, range(len(step.worth)))).all()


def test_nothing_heard_has_features_all_the_same() -> None:
    """A model may be asked about headings at which nobody spoke."""
    empty = Data(GRID, HEADINGS, np.zeros((len(HEADINGS), 61)))
    heard = Evidence(empty, empty, [np.zeros((0, 61))] * len(HEADINGS))
    model = Mixture(np.zeros(1), np.ones(1), np.full(1, 0.1), np.full((len(HEADINGS), 3), 1 / 3))
    step = Step(model, np.zeros(1), [itd_mixture.empty(heard.rich)], possible=True)
    assert np.isfinite(talker_evidence.features(heard, step, 0.0, [0])).all()


def test_a_source_alone_has_no_neighbours() -> None:
    heard = evidence(turns(np.ones(1), np.random.default_rng(2)), TALKERS[:1])
    (row,) = told(heard, step_of(heard, 1))
    assert row["nearest"] == row["furthest"] == pytest.approx(np.pi)
    assert row["dominance"] == pytest.approx(1.0, abs=1e-6)
    assert row["single"] == 1


def test_a_probability_is_the_logistic_of_a_weighted_sum() -> None:
    model = Logistic(-1.0, np.eye(len(FEATURES))[0])
    rows = np.zeros((3, len(FEATURES)))
    rows[:, 0] = [1.0, 1.0 + np.log(3.0), -1e9]
    np.testing.assert_allclose(model.probability(rows), [0.5, 0.75, 0.0], atol=1e-9)


@pytest.mark.parametrize(("name", "file"), [("source", WHITE), ("source", BELOW), ("count", BELOW)])
def test_the_weights_of_the_package_fit_the_features(name: str, file: str) -> None:
    model = talker_evidence.fitted(name, file)
    assert model.weights.shape == (len(FEATURES),)
    assert np.isfinite([model.intercept, *model.weights]).all()
