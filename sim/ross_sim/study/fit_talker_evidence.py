"""Fit what the explorer `joint` tells: ``python -m ross_sim.study.fit_talker_evidence FOLDER OUT.json OUT.npz``.

The talkers of FOLDER (those of the set `train` when it has a MANIFEST.tsv) talk in many scenes (`evidence_scenes`).
Every one is explored, and after 2, 4, 8 and 12 rotations mixtures of falling order are fitted. Boosted trees (OUT.npz)
learn from the source that is worth least whether there are as many talkers as sources; the regression `source`
(OUT.json) learns from every source of the mixture that trees fitted to other scenes choose whether somebody is within
10 degrees.
"""

from __future__ import annotations

import argparse
import csv
import json
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import cast

import numpy as np
from threadpoolctl import threadpool_limits

from ross_payload.angles import difference
from ross_payload.dsp.stft import Stft
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Explorer, Observation, Real, Samples
from ross_payload.localization import model_order, talker_evidence
from ross_payload.localization.boosted_trees import LEAF, BoostedTrees, encode_trees
from ross_payload.localization.joint import Joint
from ross_payload.localization.talker_evidence import DESCRIBED, FEATURES, LIKELY, Classifier, Logistic
from ross_sim.study.option_types import NATURAL, argument
from ross_sim.study.scenes.exploration import FRAME, NEAR_DEG, observed
from ross_sim.study.scenes.mixtures import RATE
from ross_sim.study.scenes.room_settings import SPACING, SPEED_OF_SOUND
from ross_sim.study.script_errors import expect_writable, told_by, write_result
from ross_sim.study.training.evidence_scenes import HEADINGS, ROOMS, EvidenceScene, scenes
from ross_sim.talkers.speech import load_folder, read

ROTATIONS = (2, 4, 8, 12)
SEEDS = (9000, 9001)
FEWEST = 9.0  # of speech [s]
MOST = 5  # talkers of one scene
FOLDS = 6
PENALTY = 5.0  # inverse of the strength of the penalty on standardised weights
N_TREES, LEARNING_RATE, SUBSAMPLE = 200, 0.06, 0.5  # the last: share of the rows that a tree is fitted to
MAX_LEAVES, MIN_LEAF_ROWS, MAX_FEATURES = 24, 20, 0.3  # the last: share of the features tried at a node
FURTHER, SPURIOUS = 0.4, 0.3  # weights of mixtures of another order, and of those with a spurious source
DIGITS = 5


@dataclass(frozen=True, slots=True, eq=False)
class Row:
    """One mixture on the way down."""

    features: Real  # of every source, (k, n_features)
    least: int  # the source that is worth least
    somebody: Real  # whether a talker is near each source, (k,) of bool


@dataclass(frozen=True, slots=True, eq=False)
class Descent:
    """All mixtures of one scene after some rotations, the largest first."""

    scene: str
    talkers: int
    rotations: int
    rows: tuple[Row, ...]


def descents(scene: EvidenceScene, joint: Joint) -> Iterator[Descent]:
    """Explore a scene."""
    seen = list(observed(cast(Explorer, joint), Stft(RATE, FRAME, FRAME // 4), scene.heard, HEADINGS))
    yield from descents_of(scene.name, scene.azimuths, seen, joint, ROTATIONS)


def descents_of(
    name: str, azimuths: Real, seen: Sequence[Observation], joint: Joint, after: Sequence[int]
) -> Iterator[Descent]:
    """Mixtures of falling order ``after`` so many rotations, of a scene with talkers at these azimuths [rad]."""
    for rotations in after:
        evidence, rows, rival = joint.evidence(seen[: rotations + 1]), [], 0.0
        for step in model_order.steps(evidence.rich, joint.penalty):
            if step.possible:
                found = talker_evidence.features(evidence, step, rival, range(len(step.worth)))
                rows.append(Row(found, step.least, owned(step.model.azimuths, azimuths)))
                rival = float(step.worth[step.least])
        yield Descent(name, len(azimuths), rotations, tuple(rows))


def owned(sources: Real, talkers: Real) -> Real:
    """Whether every source (k,) has a talker near, each talker for one source: the pairs with the least error."""
    from scipy.optimize import linear_sum_assignment  # noqa: PLC0415

    apart = np.rad2deg(np.abs(difference(sources[:, None], talkers))).reshape(len(sources), len(talkers))
    found = np.zeros(len(sources), dtype=bool)
    mine, theirs = linear_sum_assignment(np.minimum(apart, 60.0))
    found[mine] = apart[mine, theirs] <= NEAR_DEG
    return found


def fit(features: Real, true: Real, weights: Real, penalty: float = PENALTY) -> Logistic:
    """Logistic regression on standardised features, as one on the features themselves."""
    from sklearn.linear_model import LogisticRegression  # noqa: PLC0415  takes a second

    mean, scale = features.mean(axis=0), np.maximum(features.std(axis=0), 1e-6)
    model = LogisticRegression(C=penalty, max_iter=5000).fit((features - mean) / scale, true, sample_weight=weights)
    slopes = model.coef_[0] / scale
    return Logistic(float(model.intercept_[0] - slopes @ mean), slopes)


def fit_trees(features: Real, true: Real, weights: Real) -> BoostedTrees:
    """Stochastic gradient boosting (Friedman 2002)."""
    from sklearn.ensemble import GradientBoostingClassifier  # noqa: PLC0415  takes a second

    model = GradientBoostingClassifier(
        n_estimators=N_TREES, learning_rate=LEARNING_RATE, max_leaf_nodes=MAX_LEAVES, max_depth=None,
        min_samples_leaf=MIN_LEAF_ROWS, subsample=SUBSAMPLE, max_features=MAX_FEATURES, init="zero", random_state=0,
    ).fit(features, true, sample_weight=weights)  # fmt: skip
    trees = [tree.tree_ for tree in model.estimators_[:, 0]]
    n_nodes = max(tree.node_count for tree in trees)

    def padded(arrays: Sequence[Real], fill: int, kind: type[np.generic]) -> Real:
        return np.stack([np.pad(a, (0, n_nodes - len(a)), constant_values=fill) for a in arrays]).astype(kind)

    return BoostedTrees(
        feature=padded([np.where(tree.children_left < 0, LEAF, tree.feature) for tree in trees], LEAF, np.int8),
        threshold=padded([_at_most(tree.threshold) for tree in trees], 0, np.float32),
        left=padded([tree.children_left for tree in trees], LEAF, np.int8),
        right=padded([tree.children_right for tree in trees], LEAF, np.int8),
        log_odds=padded([LEARNING_RATE * tree.value[:, 0, 0] for tree in trees], 0, np.float32),
    )


def _at_most(thresholds: Real) -> Real:
    """The largest numbers of single precision that are not above some of double precision."""
    single = thresholds.astype(np.float32)
    return np.where(single > thresholds, np.nextafter(single, np.float32(-np.inf)), single)


def count_by_trees(found: Sequence[Descent]) -> BoostedTrees:
    """Whether there are as many talkers as sources."""
    features, true, weights = training_rows(found)
    return fit_trees(features[:, : len(DESCRIBED)], true, weights)  # trees need no products


def count_by_regression(found: Sequence[Descent], penalty: float = PENALTY) -> Logistic:
    """Whether there are as many talkers as sources, as `count_by_trees`."""
    return fit(*training_rows(found), penalty)


def training_rows(found: Sequence[Descent]) -> tuple[Real, Real, Real]:
    """What counting is learnt from: the source worth least of every mixture of about the right order.

    Features (n, n_features), whether there are as many talkers as sources (n,), and weights (n,): that order counts
    most. Mixtures that are not too large and yet hold a spurious source count little: they are right about K by chance.
    """
    rows = [(row, descent.talkers - len(row.somebody)) for descent in found for row in descent.rows]
    near = [(row, fewer) for row, fewer in rows if -2 <= fewer <= 1]
    order = np.array([1.0 if fewer in (0, -1) else FURTHER for _, fewer in near])
    spurious = np.array([fewer >= 0 and not row.somebody.all() for row, fewer in near])
    features = np.stack([row.features[row.least] for row, _ in near])
    return features, np.array([fewer >= 0 for _, fewer in near]), order * np.where(spurious, SPURIOUS, 1.0)


def chosen(descent: Descent, count: Classifier) -> Row | None:
    """The mixture that the explorer would choose."""
    for row in descent.rows:
        if count.probability(row.features[[row.least]])[0] >= LIKELY:
            return row
    return None


def picked_by(
    found: Sequence[Descent], count_of: Callable[[Sequence[Descent]], Classifier]
) -> list[tuple[Descent, Row | None]]:
    """What is chosen in every scene by what was fitted to other scenes."""
    names = sorted({descent.scene for descent in found})
    fold = {name: index % FOLDS for index, name in enumerate(np.random.default_rng(0).permutation(names))}
    picked: list[tuple[Descent, Row | None]] = []
    for index in range(FOLDS):
        count = count_of([descent for descent in found if fold[descent.scene] != index])
        picked += [(descent, chosen(descent, count)) for descent in found if fold[descent.scene] == index]
    return picked


def fit_source(picked: Sequence[tuple[Descent, Row | None]], penalty: float = PENALTY) -> Logistic:
    """Whether somebody is near a source of the mixtures that were chosen."""
    rows = [row for _, row in picked if row is not None]
    features, true = np.concatenate([row.features for row in rows]), np.concatenate([row.somebody for row in rows])
    return fit(features, true, np.ones(len(true)), penalty)


def report(picked: Sequence[tuple[Descent, Row | None]], every: Sequence[int] = ROTATIONS) -> str:
    """How often K is right after every number of rotations, in scenes that the weights were not fitted to."""
    lines = []
    for rotations in every:
        by_room: dict[str, list[bool]] = {}
        for descent, row in ((descent, row) for descent, row in picked if descent.rotations == rotations):
            room, k = descent.scene.split("-")[:2]
            right = (0 if row is None else len(row.somebody)) == descent.talkers
            by_room.setdefault(f"{room} K{k}", []).append(right)
        lines.append(
            f"{rotations} rotations: " + ", ".join(f"{n} {np.mean(v):.2f}" for n, v in sorted(by_room.items()))
        )
    return "\n".join(lines)


def readers(folder: Path) -> list[Samples]:
    """The voices of a folder that are long enough, (n,) each at `RATE`; with a MANIFEST.tsv those of the set `train`.

    Raises
    ------
    ConfigError
        When there are fewer than five, or a recording cannot be read.
    """
    manifest = folder / "MANIFEST.tsv"
    if manifest.is_file():
        with manifest.open(newline="", encoding="utf-8") as file:
            rows = [row for row in csv.DictReader(file, delimiter="\t") if row["set"] == "train"]
        long = [folder / row["id"] / row["file"] for row in rows if float(row["seconds"]) > FEWEST]
        found = [read(path, RATE) for path in long]
    else:
        found = [voice.speech for voice in load_folder(folder, RATE) if len(voice.speech) > FEWEST * RATE]
    if len(found) < MOST:
        raise ConfigError(f"{folder}: expected {MOST} talkers with {FEWEST:g} s of speech, got {len(found)}")
    return found


def encoded(models: dict[str, Logistic], about: str, names: Sequence[str] = FEATURES) -> bytes:
    """As the package keeps them."""
    plain = {
        name: {
            "intercept": round(model.intercept, DIGITS),
            "weights": {feature: round(float(w), DIGITS) for feature, w in zip(names, model.weights, strict=True)},
        }
        for name, model in models.items()
    }
    return (json.dumps({"about": about} | plain, indent=1) + "\n").encode()


def main(arguments: Sequence[str] | None = None) -> int:
    """Fit, and write the weights."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, metavar="FOLDER", help="recordings of talkers")
    parser.add_argument("out", type=Path, metavar="OUT.json", help="regression")
    parser.add_argument("out_trees", type=Path, metavar="OUT.npz", help="trees")
    parser.add_argument("--rooms", nargs="+", choices=ROOMS, default=list(ROOMS))
    parser.add_argument("--seeds", type=argument(NATURAL), nargs="+", default=SEEDS)
    parser.add_argument("--keep", type=Path, help="folder in which scenes are kept")
    asked = parser.parse_args(arguments)
    with told_by(parser):
        expect_writable(asked.out, asked.out_trees)
        voices = readers(asked.folder)
    if asked.keep is not None:
        asked.keep.mkdir(parents=True, exist_ok=True)
    joint = Joint(SPACING, SPEED_OF_SOUND)
    with threadpool_limits(1):
        heard = chain.from_iterable(scenes(asked.rooms, voices, seed, asked.keep) for seed in asked.seeds)
        every = [descent for scene in heard for descent in descents(scene, joint)]
        picked = picked_by(every, count_by_trees)
        source, trees = fit_source(picked), count_by_trees(every)
    about = (
        f"{len(every) // len(ROTATIONS)} scenes in {', '.join(asked.rooms)}, {len(voices)} talkers, "
        f"seeds {', '.join(map(str, asked.seeds))}"
    )
    with told_by(parser):
        write_result(asked.out, encoded({"source": source}, about))
        write_result(asked.out_trees, encode_trees(trees))
    sys.stdout.write(f"{about}\n{report(picked)}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
