"""Decision trees whose answers are known, and files of trees."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ross_payload.array_files import encode_arrays
from ross_payload.errors import ConfigError
from ross_payload.localization import talker_evidence
from ross_payload.localization.boosted_trees import LEAF, BoostedTrees, encode_trees, read_trees
from ross_payload.localization.talker_evidence import DESCRIBED

BY_TWO = BoostedTrees(  # x0 <= 1: -1; else x1 <= 0.5: 0, more: 2. And a tree that is one leaf: 1
    feature=np.array([[0, LEAF, 1, LEAF, LEAF], [LEAF] * 5]),
    threshold=np.array([[1.0, 0, 0.5, 0, 0], [0] * 5], np.float32),
    left=np.array([[1, LEAF, 3, LEAF, LEAF], [LEAF] * 5]),
    right=np.array([[2, LEAF, 4, LEAF, LEAF], [LEAF] * 5]),
    log_odds=np.array([[0.0, -1.0, 0.0, 0.0, 2.0], [1.0, 0, 0, 0, 0]], np.float32),
)


def logistic(x: float) -> float:
    return float(1 / (1 + np.exp(-x)))


def test_a_row_falls_to_its_leaf_in_every_tree() -> None:
    rows = np.array([[1.0, 9.0], [1.1, 0.5], [7.0, 0.6]])
    np.testing.assert_allclose(BY_TWO.probability(rows), [0.5, logistic(1.0), logistic(3.0)])
    assert BY_TWO.probability(np.zeros((0, 2))).shape == (0,)


def test_extreme_log_odds_are_probabilities() -> None:
    loud = dataclasses.replace(BY_TWO, log_odds=1e6 * BY_TWO.log_odds)
    assert (
        0 < float(loud.probability(np.zeros((1, 2)))[0]) <= 0.5 < float(loud.probability(np.full((1, 2), 9.0))[0]) < 1
    )


def test_a_file_of_trees_is_read_as_it_was_written() -> None:
    read = read_trees(encode_trees(BY_TWO), "trees.npz")
    for field in dataclasses.fields(BoostedTrees):
        np.testing.assert_array_equal(getattr(read, field.name), getattr(BY_TWO, field.name))


@pytest.mark.parametrize("cut", [0, 10, 200])
def test_damaged_files_are_refused_in_words(cut: int) -> None:
    with pytest.raises(ConfigError, match=r"trees\.npz: expected decision trees, got something else"):
        read_trees(encode_trees(BY_TWO)[:cut], "trees.npz")


def test_arrays_that_are_no_trees_are_refused() -> None:
    shorter = dataclasses.replace(BY_TWO, threshold=BY_TWO.threshold[:, 1:])
    for content in (encode_trees(shorter), encode_arrays({"feature": BY_TWO.feature})):
        with pytest.raises(ConfigError, match="expected decision trees, got something else"):
            read_trees(content, "trees.npz")


@pytest.mark.parametrize("child", [0, 2, 5, LEAF])
def test_trees_that_never_end_are_refused(child: int) -> None:
    right = BY_TWO.right.copy()
    right[0, 2] = child
    with pytest.raises(ConfigError, match="lead back or nowhere"):
        read_trees(encode_trees(dataclasses.replace(BY_TWO, right=right)), "trees.npz")


def test_the_trees_of_the_package_ask_for_features_that_there_are() -> None:
    trees = talker_evidence.trees()
    assert trees.feature.max() < len(DESCRIBED)
    assert np.isfinite(trees.log_odds).all()
