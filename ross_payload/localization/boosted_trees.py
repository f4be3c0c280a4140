"""Gradient-boosted decision trees for the probability of an event, as arrays: evaluated here, fitted elsewhere.

Hastie, Tibshirani and Friedman, The Elements of Statistical Learning (2009), algorithm 10.3: the log-odds are the sum
of what all trees say.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from ross_payload.array_files import decode_arrays, encode_arrays
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Real

LEAF = -1  # stands for a feature where a tree ends


@dataclass(frozen=True, slots=True, eq=False)
class BoostedTrees:
    """All trees, padded to as many nodes; node 0 is the root, and the children of a node come after it."""

    feature: Real  # that decides at every node, `LEAF` where there is no more to decide, (n_trees, n_nodes), integers
    threshold: Real  # at most this: on to the left child, (n_trees, n_nodes), float32
    left: Real  # child, (n_trees, n_nodes), integers
    right: Real  # child, (n_trees, n_nodes), integers
    log_odds: Real  # that a leaf adds, (n_trees, n_nodes), float32

    def probability(self, features: Real) -> Real:
        """Probability for every row of ``features`` (n, n_features), (n,)."""
        rows, trees = np.arange(len(features))[:, None], np.arange(len(self.feature))
        values, node = features.astype(np.float32), np.zeros((len(features), len(trees)), dtype=np.intp)
        while (deciding := self.feature[trees, node] != LEAF).any():
            to_left = values[rows, self.feature[trees, node]] <= self.threshold[trees, node]
            node = np.where(deciding, np.where(to_left, self.left[trees, node], self.right[trees, node]), node)
        total = self.log_odds[trees, node].sum(axis=1, dtype=float)
        return np.asarray(1 / (1 + np.exp(-np.clip(total, -30, 30))))


def read_trees(content: bytes, name: str) -> BoostedTrees:
    """Read what `encode_trees` wrote; ``name`` is for the error.

    Raises
    ------
    ConfigError
        When it is damaged or something else.
    """
    arrays, wanted = decode_arrays(content, name, "decision trees"), {field.name for field in fields(BoostedTrees)}
    if arrays.keys() != wanted or len({array.shape for array in arrays.values()}) > 1 or arrays["feature"].ndim != 2:
        raise ConfigError(f"{name}: expected decision trees, got something else")
    found = BoostedTrees(**arrays)
    if not _ends(found):
        raise ConfigError(f"{name}: expected decision trees, got nodes that lead back or nowhere")
    return found


def _ends(trees: BoostedTrees) -> bool:
    """Whether every path through every tree ends at a leaf."""
    deciding, node = trees.feature != LEAF, np.arange(trees.feature.shape[1])
    onward = (np.minimum(trees.left, trees.right) > node) & (np.maximum(trees.left, trees.right) < len(node))
    return bool((onward | ~deciding).all())


def encode_trees(trees: BoostedTrees) -> bytes:
    """Write trees as arrays by name; no pickle."""
    return encode_arrays({field.name: getattr(trees, field.name) for field in fields(BoostedTrees)})
