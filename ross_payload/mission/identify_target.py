"""Separate what was heard at rest, and ask of every group whether it is the target."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ross_payload.alignment.plan import HEADINGS, isolation
from ross_payload.dsp.steering import tdoa
from ross_payload.events import Estimate, GroupScore
from ross_payload.interfaces import Clip, Groups, Real, Scene
from ross_payload.mission.context import Context, Listening
from ross_payload.mission.voice_evidence import Evidence, lone_voices
from ross_payload.voiceprint.dominance import dominant

APART = 0.5  # a heading tells of a source when it isolates it by this share of the best one
WELL = 0.6  # and need not be joined by another one at first when it does by this share
CERTAIN = 4.0  # over the criterion: who sounds so much like the target is not checked, nobody else recalled [nat]
LEAST_SHARE = 0.5  # of T_unit that must be left of a voice for that


@dataclass(frozen=True, slots=True)
class Identification:
    """One listening period, separated and scored."""

    groups: Groups
    voices: Real  # (n_groups, n_samples), float32
    compared: tuple[Clip, ...]  # what of every voice is compared with the print
    scores: tuple[GroupScore, ...] = ()
    damaged: bool = False  # as of `Listening`

    @property
    def best(self) -> int | None:
        """Index of the accepted group with the highest score; None when no group sounds like the target.

        Sources that pose as one are never the target: its voice among them would be a mixture.
        """
        accepted = [g for g, score in enumerate(self.scores) if score.accepted and len(score.members) <= 1]
        return max(accepted, key=lambda g: self.scores[g].value, default=None)

    @property
    def accepted(self) -> int | None:
        """The source that is the best accepted group; None when no group sounds like the target."""
        return next(iter(self.scores[self.best].members), None) if self.best is not None else None

    def value_of(self, source: int) -> float:
        """Return the score of the group that holds a source, minus infinity when none does."""
        return max((score.value for score in self.scores if source in score.members), default=-np.inf)


def separate(context: Context, estimate: Estimate, listening: Listening) -> tuple[Groups, Real]:
    """Separate one listening period; return the groups and their voices (n_groups, n_samples)."""
    settings, stft = context.settings, context.tools.stft
    spacing, speed = settings.spacing, settings.speed_of_sound
    spectrogram = stft.analyse(listening.samples)
    scene = Scene(
        frequencies=stft.frequencies,
        spacing=spacing,
        speed_of_sound=speed,
        n_sources=estimate.k,
        tau=tdoa(estimate.azimuths, listening.heading, spacing, speed, estimate.elevations),
        noise_psd=context.psd(stft, spectrogram),
        seed=settings.seed,
        hop=stft.hop,
        noise_field=context.noise_field(stft, spectrogram, listening),
    )
    groups = context.tools.separator.batch(spectrogram, scene)
    return groups, stft.synthesise(groups.signals, listening.samples.shape[1]).astype(np.float32)


def separate_piece(context: Context, estimate: Estimate, listening: Listening) -> tuple[Groups, Real]:
    """Separate a piece of a turn as `separate` does, by what was heard around it, too: it is short."""
    if listening.around is None:
        return separate(context, estimate, listening)
    before, after = listening.around
    first, n = before.shape[1], listening.samples.shape[1]
    samples = np.concatenate([before, listening.samples, after], axis=1)
    speeds = listening.speeds(-first, n + after.shape[1])
    groups, voices = separate(context, estimate, replace(listening, samples=samples, rotor_speeds=speeds))
    return groups, voices[:, first : first + n]


def recognise(
    context: Context, estimate: Estimate, listening: Listening, evidence: Evidence | None = None
) -> Identification:
    """Separate and score: a source that stands well apart here by all that was heard of it, now and before.

    One that does not keeps the score that it had.
    """
    separated = separate(context, estimate, listening)
    return judged(context, estimate, listening.heading, separated, evidence, damaged=listening.damaged)


def judged(
    context: Context,
    estimate: Estimate,
    heading: float,
    separated: tuple[Groups, Real],
    evidence: Evidence | None = None,
    *,
    damaged: bool = False,
) -> Identification:
    """Score what was separated at a heading [rad] as `recognise` says; the ``evidence`` hears it, too.

    Of a period that is ``damaged`` it is not told how clean the voices are.
    """
    groups, voices = separated
    compared = tuple(dominant(voices, groups.quality, context.settings.rate))
    found = Identification(groups, voices, compared, damaged=damaged)
    if evidence is not None:
        clear = set(np.flatnonzero(_clear(context, estimate, heading)).tolist())
        heard, seconds = lone_voices(groups, found.compared), voices.shape[1] / context.settings.rate
        for source in clear & set(heard):
            evidence.hear(source, heard[source], seconds=seconds)
    return scored(context, found, evidence)


def scored(context: Context, found: Identification, evidence: Evidence | None = None) -> Identification:
    """Compare every group with the target's voice print; a group of one source may have its score in ``evidence``."""
    scores = []
    for group, (members, voice) in enumerate(zip(found.groups.members, found.compared, strict=True)):
        value = evidence.scores.get(members[0]) if evidence is not None and len(members) == 1 else None
        value = _no_evidence(context).alone(voice) if value is None else value
        scores.append(_scored(context, found, group, value))
    return replace(found, scores=tuple(scores))


def _scored(context: Context, found: Identification, group: int, value: float) -> GroupScore:
    groups = found.groups
    accepted = value > context.settings.criterion and context.tools.voiceprint is not None
    if not groups.quality or found.damaged:
        return GroupScore(groups.members[group], value, accepted)
    quality = groups.quality[group]
    return GroupScore(groups.members[group], value, accepted, quality.si_sdr, quality.si_sdri)


def recall(context: Context, estimate: Estimate, known: Evidence | None = None) -> Evidence:
    """Return what the exploration has heard of every source at the few orientations that tell well of somebody.

    Each is separated once, and tells of every source that stands apart there; not of who is ``known`` already. When
    somebody sounds like the target beyond doubt, the orientations that are left are not recalled. Nothing is recalled
    where nothing was explored.
    """
    evidence = _no_evidence(context) if known is None else known
    if not context.explored or context.tools.voiceprint is None:
        return evidence
    apart = _apart(context, estimate, [heard.heading for heard in context.explored])
    unheard = [source for source in range(len(apart)) if source not in evidence.clips]
    for orientation in _enough(context, apart[unheard]):
        for source in unheard:
            if _tells(apart[source])[orientation]:
                _hear_recalled(context, estimate, evidence, source, [orientation])
        if any(beyond_doubt(context, evidence, source) for source in evidence.scores):
            break
    return evidence


def beyond_doubt(context: Context, evidence: Evidence, source: int) -> bool:
    """Whether a source heard for T_unit, half of which counts at least, sounds like the target as few others do."""
    unit = context.settings.unit
    long_enough = evidence.listened.get(source, 0.0) >= 0.99 * unit and evidence.seconds(source) >= LEAST_SHARE * unit
    sure = evidence.scores.get(source, -np.inf) >= context.settings.criterion + CERTAIN
    return evidence.target is not None and sure and long_enough


def recall_more(context: Context, estimate: Estimate, evidence: Evidence, source: int) -> None:
    """Let every other orientation tell of a source, too, at which it stands apart."""
    if evidence.recalled:
        apart = _apart(context, estimate, [heard.heading for heard in context.explored])
        _hear_recalled(context, estimate, evidence, source, np.flatnonzero(_tells(apart[source])).tolist())


def _tells(curve: Real) -> NDArray[np.bool_]:
    """Whether headings tell of a source, by its isolation there, (n_headings,)."""
    return np.asarray(curve >= APART * curve.max())


def _hear_recalled(
    context: Context, estimate: Estimate, evidence: Evidence, source: int, orientations: Sequence[int]
) -> None:
    """Hear a source alone at orientations of the exploration, at none a second time; each is separated once."""
    told = evidence.told.setdefault(source, set())
    new = [i for i in orientations if i not in told]
    told.update(new)
    for i in new:
        if i not in evidence.recalled:
            groups, voices = separate_piece(context, estimate, context.explored[i])
            evidence.recalled[i] = lone_voices(groups, dominant(voices, groups.quality, context.settings.rate))
            evidence.method = groups.method
    alone = [i for i in new if source in evidence.recalled[i]]
    seconds = sum(context.explored[i].samples.shape[1] for i in alone) / context.settings.rate
    evidence.hear(source, *(evidence.recalled[i][source] for i in alone), seconds=seconds)


def _enough(context: Context, apart: Real) -> list[int]:
    """A few orientations that isolate every source well for T_unit, each adding the most to those before it.

    ``apart`` is the isolation of every source at every orientation, (k, n). Of a turn they are pieces.
    """
    lasts = np.array([heard.samples.shape[1] for heard in context.explored])
    best = apart.max(axis=1, keepdims=True, initial=0.0)
    well, share = apart >= WELL * best, apart / np.maximum(best, np.finfo(float).tiny)
    missing = np.full(len(apart), round(context.settings.unit * context.settings.rate))
    chosen: list[int] = []
    while missing.any():
        added = (np.minimum(missing[:, None], lasts) * well).sum(axis=0)
        added[chosen] = 0
        most = np.flatnonzero(added == added.max())
        if added[most[0]] == 0:
            break
        chosen.append(int(most[share[missing > 0][:, most].sum(axis=0).argmax()]))
        missing = np.maximum(missing - lasts[chosen[-1]] * well[:, chosen[-1]], 0)
    return chosen


def _no_evidence(context: Context) -> Evidence:
    return Evidence(context.settings.rate, context.tools.voiceprint)


def _apart(context: Context, estimate: Estimate, headings: Sequence[float]) -> Real:
    """Isolation of every source at headings [rad], [s], (k, n_headings)."""
    spacing, speed = context.settings.spacing, context.settings.speed_of_sound
    return isolation(estimate.azimuths, headings, spacing, speed, estimate.elevations)


def _clear(context: Context, estimate: Estimate, heading: float) -> NDArray[np.bool_]:
    """Whether a heading isolates each source by `APART` of the best one at least, (k,)."""
    apart = _apart(context, estimate, [heading, *HEADINGS])
    return np.asarray(apart[:, 0] >= APART * apart.max(axis=1))
