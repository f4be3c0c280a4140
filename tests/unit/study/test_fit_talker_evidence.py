"""Fitting the probabilities of the joint explorer: scenes, regressions, and the file that the package reads."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ross_payload.errors import ConfigError
from ross_payload.interfaces import Real
from ross_payload.localization.talker_evidence import FEATURES, Classifier, Logistic
from ross_sim.study.fit_talker_evidence import (
    LEARNING_RATE,
    MAX_LEAVES,
    Descent,
    Row,
    chosen,
    count_by_regression,
    count_by_trees,
    encoded,
    fit_source,
    fit_trees,
    owned,
    picked_by,
    readers,
    report,
)
from ross_sim.study.training import evidence_scenes

pytestmark = pytest.mark.lockstep
RATE = evidence_scenes.RATE


def voices(n: int) -> list[Real]:
    rng = np.random.default_rng(0)
    return [rng.standard_normal(2 * RATE).astype(np.float32) for _ in range(n)]


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(evidence_scenes, "IN_PLANES", {2: 1})
    monkeypatch.setattr(evidence_scenes, "SILENT", 1)
    monkeypatch.setattr(evidence_scenes, "HEADINGS", np.deg2rad([0.0, 30.0]))
    monkeypatch.setattr(evidence_scenes, "UNIT", 0.25)


def test_scenes_that_are_kept_are_those_that_were_made(few: None, tmp_path: Path) -> None:
    made, kept, free = (
        list(evidence_scenes.scenes(["S1"], voices(3), 5, folder)) for folder in (tmp_path, tmp_path, None)
    )
    assert [scene.name for scene in made] == ["silent-0-0-5", "S1-2-0-5"]
    for one, other, third in zip(made, kept, free, strict=True):
        np.testing.assert_array_equal(one.heard, other.heard)
        np.testing.assert_array_equal(one.heard, third.heard)
        np.testing.assert_array_equal(one.azimuths, other.azimuths)
    assert made[1].heard.shape == (2, 2, RATE // 4)


def test_a_scene_that_was_cut_short_or_is_of_other_voices_is_made_again(few: None, tmp_path: Path) -> None:
    made = list(evidence_scenes.scenes(["S1"], voices(3), 5, tmp_path))
    (path,) = tmp_path.rglob("S1-2-0-5.npz")
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    again = list(evidence_scenes.scenes(["S1"], voices(3), 5, tmp_path))
    np.testing.assert_array_equal(made[1].heard, again[1].heard)
    assert path.read_bytes() == whole
    others = list(evidence_scenes.scenes(["S1"], voices(3)[::-1], 5, tmp_path))
    assert not np.array_equal(made[1].heard, others[1].heard)


def test_talkers_of_a_scene_are_apart(few: None) -> None:
    azimuths, responses = evidence_scenes.simulated("S1", 5)
    for seed in range(5):
        rng = np.random.default_rng(seed)
        _, places = evidence_scenes.mixed(azimuths, responses, voices(5), 4, odd=True, rng=rng)
        apart = np.abs(np.angle(np.exp(1j * (places[:, None] - places)))) + 9 * np.eye(4)
        assert apart.min() >= evidence_scenes.APART


def test_a_talker_owns_one_source() -> None:
    talkers = np.deg2rad([0.0, 100.0])
    assert owned(np.deg2rad([4.0, 1.0, 105.0]), talkers).tolist() == [False, True, True]
    assert owned(np.deg2rad([50.0]), talkers).tolist() == [False]
    assert owned(np.deg2rad([50.0]), np.zeros(0)).tolist() == [False]


def made_up(n: int) -> list[Descent]:
    """Mixtures of three sources, then two, of two talkers; what is worth more than about 0 is somebody."""
    rng, found = np.random.default_rng(1), []
    for index in range(n):
        rows = []
        for k in (3, 2):
            somebody = np.arange(k) < 2
            features = np.zeros((k, len(FEATURES)))
            features[:, 0] = rng.normal(np.where(somebody, 1.5, -1.5), 0.8)
            rows.append(Row(features, int(features[:, 0].argmin()), somebody))
        found.append(Descent(f"S1-2-{index}-0", 2, 12, tuple(rows)))
    return found


@pytest.mark.parametrize("count_of", [count_by_trees, count_by_regression])
def test_what_is_fitted_learns_who_is_somebody(count_of: Callable[[Sequence[Descent]], Classifier]) -> None:
    found = made_up(60)
    picked = picked_by(found, count_of)
    right = [row is not None and len(row.somebody) == 2 for _, row in picked]
    assert np.mean(right) > 0.8
    probable = np.zeros((2, len(FEATURES)))
    probable[:, 0] = [-2.0, 2.0]
    for model in (count_of(found), fit_source(picked)):
        low, high = model.probability(probable)
        assert low < 0.3
        assert high > 0.7
    assert "12 rotations: S1 K2 " in report(picked)


def test_trees_say_what_those_of_scikit_learn_say() -> None:
    """Also where features are next to each other in single precision, as which trees compare them."""
    from sklearn.ensemble import GradientBoostingClassifier

    rng = np.random.default_rng(2)
    features, next_to_each_other = rng.integers(0, 12, (600, 5)) / 7.0, rng.integers(0, 8, 600)
    features[:, 3] = 4 + 4 * np.finfo(np.float32).eps * next_to_each_other
    seen_as = features[:, 0] + features[:, 1] * features[:, 2] + 0.3 * next_to_each_other
    true = seen_as + 0.3 * rng.standard_normal(600) > 2.5
    weights, seen = rng.uniform(0.3, 1.0, 600), []
    fit = GradientBoostingClassifier.fit

    def kept(model: GradientBoostingClassifier, *args: Any, **named: Any) -> GradientBoostingClassifier:
        seen.append(fit(model, *args, **named))
        return seen[-1]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(GradientBoostingClassifier, "fit", kept)
        trees = fit_trees(features, true, weights)
    asked = np.concatenate([features, rng.integers(0, 24, (600, 5)) / 14.0])
    np.testing.assert_allclose(trees.probability(asked), seen[0].predict_proba(asked)[:, 1], atol=1e-6)
    assert trees.feature.shape[1] <= 2 * MAX_LEAVES - 1
    assert seen[0].learning_rate == LEARNING_RATE


def test_nothing_is_chosen_when_nothing_is_likely() -> None:
    never = Logistic(-30.0, np.zeros(len(FEATURES)))
    assert chosen(made_up(1)[0], never) is None


def test_the_file_is_what_the_package_reads(tmp_path: Path) -> None:
    weights = np.linspace(-1, 1, len(FEATURES))
    kept = json.loads(encoded({"count": Logistic(0.25, weights)}, "about"))
    assert kept["about"] == "about"
    np.testing.assert_allclose([kept["count"]["weights"][name] for name in FEATURES], weights, atol=1e-5)


def test_too_few_talkers_are_refused_in_words(tmp_path: Path) -> None:
    (tmp_path / "MANIFEST.tsv").write_text("set\tid\tfile\tseconds\ntest\ta\tspeech.flac\t12\n")
    with pytest.raises(ConfigError, match="expected 5 talkers"):
        readers(tmp_path)
