"""The probability that a source of the mixture is a talker, and what tells talkers from spurious sources.

A spurious source results from the misfit of the model. It is worth little, at few headings, less in the strict
histograms than in the rich ones, and it never sounds alone: as the reflection of a loud talker it sounds whenever that
talker does. A talker has blocks of 50 ms to himself. Boosted trees decide by the source that is worth least whether
there are as many talkers as sources. A logistic regression, `source`, gives the probability of every source that is
left. In the noise of a vehicle, and below one, regressions with weights of their own do both, `count` and `source`.
They were fitted to simulated rooms by `ross_sim.study.fit_talker_evidence` and `fit_evidence_in_noise`.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Protocol

import numpy as np

from ross_payload.angles import difference
from ross_payload.interfaces import Real
from ross_payload.localization import itd_mixture
from ross_payload.localization.boosted_trees import BoostedTrees, read_trees
from ross_payload.localization.itd_mixture import OTHERS, TINY, Data
from ross_payload.localization.model_order import Step, wetness

BLOCK = 0.05  # in which one talker speaks or another [s]
LEAST = 0.03  # worth over penalty; what is worth less is nothing
NOBODY = 1e-3  # a gain that stands for none [percent of the evidence]
NEAR = np.deg2rad(35.0)  # a source between two that are nearer than this may be what both share [rad]
ALONE = 0.7  # a bin of the histograms is a source's own when this share of it is
FIRST = -3.0  # log of worth over penalty before the first step
STEADIEST = 20.0  # bound of the steadiness of a gain over the headings
WHITE, TREES = "talker_evidence.json", "talker_evidence.npz"  # for noise that is white
BELOW, AMONG = "talker_evidence_below.json", "talker_evidence_in_noise.json"  # a vehicle; its noise
PACKAGE = "ross_payload.localization"
LIKELY = 0.5  # probability above which there are as many talkers as sources

DESCRIBED = (
    "worth", "second", "rival", "evidence", "evidence_squared", "headings", "sources", "single",
    "directness", "width", "wetness", "diffuse", "nobody",
    "strict", "steady", "positive", "median", "widespread", "relative", "share",
    "narrow", "amplitude", "nearest", "furthest", "between",
    "margin", "dominance", "bursts", "alike", "dominated", "alone",
)  # fmt: skip
PRODUCTS = (
    ("worth", "wetness"), ("rival", "wetness"), ("second", "wetness"), ("dominance", "wetness"), ("alike", "wetness"),
    ("worth", "headings"), ("rival", "headings"), ("worth", "directness"), ("worth", "sources"), ("rival", "sources"),
)  # fmt: skip
FEATURES = (*DESCRIBED, *(f"{one} {other}" for one, other in PRODUCTS))
BESIDE = 0.25  # distance from a rotor at which a source may well be that rotor, as phasors
IN_NOISE = (
    "kept", "rotor", "rotor worth", "rotor kept", "rotor strict", "rotor dominance", "rotor steady",
    "kept worth", "kept strict", "kept rival",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Among:
    """The noise of a vehicle among which something was heard."""

    rotors: tuple[complex, ...]  # cos(elevation) exp(j azimuth) of every rotor whose place is known
    kept: float  # share of the votes that are not the noise's


@dataclass(frozen=True, slots=True)
class Evidence:
    """What was heard at all headings: rich and strict histograms, and the rich one of every block of time."""

    rich: Data
    strict: Data
    blocks: Sequence[Real]  # effective counts, (n_blocks, n_bins) of every heading
    among: Among | None = None  # None: the noise is white

    @property
    def in_noise(self) -> bool:
        """Whether the weights for the noise of a vehicle serve; far below one nobody has fitted them."""
        return self.among is not None and not self.rich.aloft

    @property
    def file(self) -> str:
        """Whose weights serve."""
        return BELOW if self.rich.aloft else AMONG if self.in_noise else WHITE


class Classifier(Protocol):
    """What gives a probability."""

    def probability(self, features: Real) -> Real:
        """Probability for every row of ``features`` (n, n_features), (n,)."""


@dataclass(frozen=True, slots=True)
class Logistic:
    """A logistic regression on `FEATURES`."""

    intercept: float
    weights: Real  # (n_features,)

    def probability(self, features: Real) -> Real:
        """Probability for every row of ``features`` (n, n_features), (n,)."""
        return np.asarray(1 / (1 + np.exp(-np.clip(features @ self.weights + self.intercept, -30, 30))))


@cache
def fitted(name: str, file: str = WHITE) -> Logistic:
    """The regression ``source`` of a file of this package; `BELOW` and `AMONG` have the regression ``count``, too."""
    features = FEATURES + IN_NOISE if file == AMONG else FEATURES
    found = json.loads(files(PACKAGE).joinpath(file).read_text(encoding="utf-8"))[name]
    return Logistic(float(found["intercept"]), np.array([found["weights"][feature] for feature in features]))


@cache
def trees() -> BoostedTrees:
    """The trees of this package, on the first of the `FEATURES`, `DESCRIBED`."""
    return read_trees(files(PACKAGE).joinpath(TREES).read_bytes(), TREES)


def together(every: Sequence[Among | None]) -> Among | None:
    """What the noise was at all headings: where the rotors were last, and the mean share that was kept."""
    known = [among for among in every if among is not None]
    if 2 * len(known) <= len(every):
        return None
    return Among(known[-1].rotors, sum(among.kept for among in known) / len(known))


def likely(evidence: Evidence, step: Step, rival: float) -> float:
    """Probability that there are as many talkers as sources of a mixture, or more.

    Below a vehicle every source must be somebody, too: what rotors leave over is steady there, and worth much.
    """
    described = features(evidence, step, rival, [step.least])
    if evidence.file == WHITE:
        return float(trees().probability(described)[0])
    least = fitted("count", evidence.file).probability(described)
    if not evidence.rich.aloft:
        return float(least[0])
    every = fitted("source", evidence.file).probability(features(evidence, step, rival, range(len(step.worth))))
    return float(min(least[0], every.min()))


def features(evidence: Evidence, step: Step, rival: float, sources: Sequence[int]) -> Real:
    """What tells sources from spurious ones, (n, n_features) in the order of `FEATURES`, then `IN_NOISE`.

    ``rival`` is the worth over penalty of the source that went before this mixture, 0 when none did.
    """
    model, total = step.model, float(evidence.rich.counts.sum()) + TINY
    k = len(model.azimuths)
    counts = evidence.rich.evidence
    shares = np.average(model.weights, axis=0, weights=counts + TINY)
    worth = np.log(np.maximum(step.worth, LEAST))
    second = float(np.sort(worth)[1]) if k > 1 else float(worth[0]) + 1.0
    directness = float(model.directness)
    common = [
        second, np.log(rival) if rival > 0 else FIRST, np.log(total), np.log(total) ** 2, np.log(len(counts)),
        k, k == 1, directness, model.width, wetness(evidence.rich, model), shares[-OTHERS], shares[-1],
    ]  # fmt: skip
    whole, strict = (_by_period(data, model) for data in (evidence.rich, evidence.strict))
    voices = _voices(evidence, model, sources)
    found = []
    for source, voice in zip(sources, voices, strict=True):
        gain = whole - _by_period(evidence.rich, step.reduced[source])
        lost = float((strict - _by_period(evidence.strict, step.reduced[source])).sum())
        ordered = np.sort(gain)[::-1]
        middle = max(float(np.median(gain)), TINY) / total * 100 * len(gain)
        left, right = _neighbours(model.azimuths, source)
        found.append([
            worth[source], *common,
            np.log(max(lost / (float(evidence.strict.counts.sum()) + 1e-9) * 100, NOBODY)),
            np.clip(gain.mean() / (gain.std() / np.sqrt(len(gain)) + 1e-6), -STEADIEST, STEADIEST),
            np.mean(gain > 0), np.log(max(middle, NOBODY)),
            np.clip(1 - ordered[:2].sum() / max(float(gain.sum()), TINY), -2.0, 1.0),
            worth[source] - np.median(worth), np.log(shares[source] + TINY),
            np.log(model.widths[source] / model.width), model.amplitudes[source], min(left, right), max(left, right),
            left < NEAR and right < NEAR, *voice,
        ])  # fmt: skip
    described = np.array(found, dtype=float).reshape(len(sources), len(DESCRIBED))
    whole = with_products(described)
    return np.column_stack([whole, _among_noise(described, evidence, step, sources)]) if evidence.in_noise else whole


def with_products(described: Real) -> Real:
    """Append what the regressions need of `PRODUCTS` to (n, n_described): what a worth means depends on the room."""
    at = {name: index for index, name in enumerate(DESCRIBED)}
    products = [described[:, at[one]] * described[:, at[other]] for one, other in PRODUCTS]
    return np.column_stack([described, *products])


def _among_noise(described: Real, evidence: Evidence, step: Step, sources: Sequence[int]) -> Real:
    """What tells sources from what the noise of a vehicle leaves over, (n, n) in the order of `IN_NOISE`.

    The share of votes that is not the noise's, as a logarithm; how near a source is to a rotor, 1 where they are one;
    and products with what is said of the source anyway.
    """
    if evidence.among is None:
        return np.zeros((len(sources), 0))
    rotors, model = np.array(evidence.among.rotors, dtype=complex), step.model
    phasors = (model.amplitudes * np.exp(1j * model.azimuths))[list(sources)]
    apart = np.abs(phasors[:, None] - rotors).min(axis=1, initial=np.inf)
    rotor = np.exp(-((apart / BESIDE) ** 2))
    kept = np.full(len(sources), np.log(evidence.among.kept + 0.01))
    of = {name: described[:, DESCRIBED.index(name)] for name in ("worth", "strict", "dominance", "steady", "rival")}
    return np.column_stack([
        kept, rotor, rotor * of["worth"], rotor * kept, rotor * of["strict"], rotor * of["dominance"],
        rotor * of["steady"], kept * of["worth"], kept * of["strict"], kept * of["rival"],
    ])  # fmt: skip


def _by_period(data: Data, model: itd_mixture.Mixture) -> Real:
    """Log-likelihood [nat] of the counts of every period, (n_periods,)."""
    likelihood = (data.counts * np.log(itd_mixture.densities(data, model) + TINY)).sum(axis=-1)
    return np.asarray(data.by_period(likelihood))


def _neighbours(azimuths: Real, source: int) -> tuple[float, float]:
    """Angles [rad] to the nearest source on either side; pi when there is none."""
    off = difference(np.delete(azimuths, source), azimuths[source])
    behind, ahead = -off[off < 0], off[off > 0]
    return float(behind.min(initial=np.pi)), float(ahead.min(initial=np.pi))


def _voices(evidence: Evidence, model: itd_mixture.Mixture, sources: Sequence[int]) -> Real:
    """How far some sources have a voice of their own, (n, 6).

    Margin over the loudest other, and share, in the blocks where the source sounds; how bursty it is; the largest
    correlation with another source over the blocks; the evidence in the blocks that it dominates; and the share of its
    evidence in bins of the histograms that are its own.
    """
    claims = itd_mixture.claims(evidence.rich, model)  # (n_headings, k + 2, n_bins)
    k = len(model.azimuths)
    loud = np.concatenate([block @ claim[:k].T for block, claim in zip(evidence.blocks, claims, strict=True)])
    loud = loud[loud.sum(axis=1) > 0].T  # (k, n_blocks)
    if not loud.shape[1]:
        return np.zeros((len(sources), 6))
    share = loud / loud.sum(axis=0)
    root = np.sqrt(loud)
    root = root - root.mean(axis=1, keepdims=True)
    root = root / (np.sqrt((root**2).sum(axis=1, keepdims=True)) + TINY)
    alike = root @ root.T - 4 * np.eye(k)
    counts = evidence.rich.counts
    found = []
    for source in sources:
        mine = loud[source]
        total = float(mine.sum()) + 1e-9
        others = np.delete(loud, source, axis=0).max(axis=0, initial=0.0)
        claimed = counts * claims[:, source]
        dominated = float((mine * share[source]).sum())
        found.append([
            np.maximum(mine - others, 0).sum() / total, dominated / total,
            np.log(max((mine**2).sum() / total**2 * mine.size, TINY)), alike[source].max() if k > 1 else -0.2,
            np.log(dominated + 0.1), claimed[claims[:, source] > ALONE].sum() / (claimed.sum() + 1e-9),
        ])  # fmt: skip
    return np.array(found)
