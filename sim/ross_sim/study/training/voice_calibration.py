"""From how alike voices are to the built-in model to log-likelihood ratios: slopes and thresholds by duration.

Logistic regression over several corpora, all weighted alike, and targets as much as strangers. Readers who trained the
model are scored by another one that was learnt without their fold.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ross_payload.interfaces import Real
from ross_payload.voiceprint.built_in import BuiltInModel, Parameters
from ross_payload.voiceprint.embedding_print import unit
from ross_payload.voiceprint.features import Features
from ross_sim.study.calibrate_voice_model import BUILT_IN_MARGIN, logistic
from ross_sim.study.rows.voice_print_rows import CRITERION, equal_error_rate
from ross_sim.study.training.calibration_voices import SeparatedVoice
from ross_sim.study.voiceprint_study import DURATIONS


@dataclass(frozen=True, slots=True, eq=False)
class Corpus:
    """Separated voices, and what they are compared with."""

    heard: Sequence[SeparatedVoice]
    enrolled: Mapping[int | None, Mapping[str, Sequence[Features]]]  # by fold (None: there are none) and by talker


@dataclass(frozen=True, slots=True, eq=False)
class Trials:
    """How alike voices and prints are, (n,), of one duration, and where the voice was that of the print, (n,)."""

    similarity: Real
    own: NDArray[np.bool_]


def calibrated(learnt: Mapping[int | None, Parameters], corpora: Sequence[Corpus]) -> tuple[Parameters, list[str]]:
    """Fit slopes, thresholds and the criterion of separated prints; also lines that say how often the result errs.

    What was ``learnt`` without each fold scores the talkers of this fold; None is what was learnt from all.
    """
    models = {fold: BuiltInModel(parameters) for fold, parameters in learnt.items()}
    measured = [trials(models, corpus) for corpus in corpora]
    fits = [fitted([of[seconds] for of in measured]) for seconds in DURATIONS]
    slopes = np.array([round(slope, 1) for slope, _ in fits])
    thresholds = np.array([round(threshold + BUILT_IN_MARGIN / slope, 3) for slope, threshold in fits])
    found = replace(learnt[None], slopes=slopes, thresholds=thresholds)
    last = corpora[-1].heard  # who speaks for long enough to say something else in every mixture
    lines = []
    for of in measured:
        for place, seconds in enumerate(DURATIONS):
            ratios = slopes[place] * (of[seconds].similarity - thresholds[place])
            targets, strangers = ratios[of[seconds].own], ratios[~of[seconds].own]
            rates = np.mean(targets <= CRITERION), np.mean(strangers > CRITERION), equal_error_rate(targets, strangers)
            told = ", ".join(f"{100 * rate:.1f}" for rate in rates)
            lines.append(f"{seconds:g} s, {len(targets)} targets, {len(strangers)} strangers: FR, FA, EER {told} %")
    return replace(found, separated=np.array(criterion(BuiltInModel(found), last))), lines


def trials(models: Mapping[int | None, BuiltInModel], corpus: Corpus) -> dict[float, Trials]:
    """Compare every separated voice with every print of its fold, by duration [s]."""
    found: dict[float, tuple[list[float], list[bool]]] = {seconds: ([], []) for seconds in DURATIONS}
    for fold, people in corpus.enrolled.items():
        embed = models[fold].embedding_of
        prints = {name: unit(np.sum([embed(clip) for clip in clips], axis=0)) for name, clips in people.items()}
        for one in corpus.heard:
            if fold in (one.fold, None):
                embedding, (similarity, own) = embed(one.features), found[one.seconds]
                similarity += [models[fold].similarity(print_, embedding) for print_ in prints.values()]
                own += [one.talker == name for name in prints]
    return {seconds: Trials(np.array(similarity), np.array(own, bool)) for seconds, (similarity, own) in found.items()}


def fitted(parts: Sequence[Trials]) -> tuple[float, float]:
    """Fit slope [nat] and threshold to the trials of corpora; they, and targets and strangers, count alike."""
    similarity, own = np.concatenate([part.similarity for part in parts]), np.concatenate([part.own for part in parts])
    shares = [np.where(part.own, 1 / part.own.sum(), 1 / (~part.own).sum()) for part in parts]
    weights = np.concatenate(shares)
    return logistic(similarity, own, weights * len(own) / weights.sum())


def criterion(model: BuiltInModel, heard: Sequence[SeparatedVoice]) -> float:
    """Return the ratio [nat] that tells separated voices apart by prints of what was separated of other mixtures.

    It is the mean of those of all durations; the talkers must have spoken for long enough to say something else.
    """
    embeddings = [model.embedding_of(one.features) for one in heard]
    said = list(zip(heard, embeddings, strict=True))
    criteria = []
    for seconds in DURATIONS:
        ratios, own = [], []
        for print_, enrolled in said:
            if print_.seconds == max(DURATIONS):
                others = [(one, vector) for one, vector in said if one.seconds == seconds and one.scene != print_.scene]
                ratios += [model.calibration.ratio(model.similarity(enrolled, vector), seconds) for _, vector in others]
                own += [print_.talker == one.talker for one, _ in others]
        slope, threshold = logistic(np.array(ratios), np.array(own))
        criteria.append(threshold + BUILT_IN_MARGIN / slope)
    return round(float(np.mean(criteria)), 1)
