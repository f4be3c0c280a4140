"""Separate what was heard at rest, and ask of every group whether it is the target."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ross_payload.alignment.plan import isolation
from ross_payload.dsp.steering import tdoa
from ross_payload.events import Estimate, GroupScore
from ross_payload.interfaces import Groups, Real, Scene
from ross_payload.mission.context import Context, Listening

APART = 0.5  # an orientation tells of a source when it isolates it by this share of the best one


@dataclass(frozen=True, slots=True)
class Identification:
    """One listening period, separated and scored."""

    groups: Groups
    voices: Real  # (n_groups, n_samples), float32
    scores: tuple[GroupScore, ...]

    @property
    def best(self) -> int | None:
        """Index of the accepted group with the highest score; None when no group sounds like the target.

        Sources that pose as one are never the target: its voice among them would be a mixture.
        """
        accepted = [g for g, score in enumerate(self.scores) if score.accepted and len(score.members) <= 1]
        return max(accepted, key=lambda g: self.scores[g].value, default=None)

    def value_of(self, source: int) -> float:
        """Return the score of the group that holds a source, minus infinity when none does."""
        return max((score.value for score in self.scores if source in score.members), default=-np.inf)


def separate(context: Context, estimate: Estimate, listening: Listening) -> tuple[Groups, Real]:
    """Separate one listening period; return the groups and their voices (n_groups, n_samples)."""
    settings, stft = context.settings, context.tools.stft
    azimuths = np.array([source.azimuth for source in estimate.sources])
    elevations = np.array([source.elevation or 0.0 for source in estimate.sources])
    spectrogram = stft.analyse(listening.samples)
    scene = Scene(
        frequencies=stft.frequencies,
        spacing=settings.spacing,
        speed_of_sound=settings.speed_of_sound,
        n_sources=estimate.k,
        tau=tdoa(azimuths, listening.heading, settings.spacing, settings.speed_of_sound, elevations),
        noise_psd=context.psd(stft, spectrogram),
        seed=settings.seed,
        hop=stft.hop,
    )
    groups = context.tools.separator.batch(spectrogram, scene)
    return groups, stft.synthesise(groups.signals, listening.samples.shape[1]).astype(np.float32)


def recognise(context: Context, estimate: Estimate, listening: Listening, recalled: dict[int, float]) -> Identification:
    """Separate and score; for a source that stands alone the score is the mean of this one and the recalled one."""
    return scored(context, *separate(context, estimate, listening), recalled)


def scored(context: Context, groups: Groups, voices: Real, recalled: dict[int, float]) -> Identification:
    """Compare every group with the target's voice print; as `recognise`."""
    scores = []
    for group, (members, voice) in enumerate(zip(groups.members, voices, strict=True)):
        value = _likeness(context, voice)
        if len(members) == 1 and members[0] in recalled:
            value = (value + recalled[members[0]]) / 2
        scores.append(_scored(context, groups, group, value))
    return Identification(groups, voices, tuple(scores))


def _scored(context: Context, groups: Groups, group: int, value: float) -> GroupScore:
    accepted = value > context.settings.criterion
    if not groups.quality:
        return GroupScore(groups.members[group], value, accepted)
    quality = groups.quality[group]
    return GroupScore(groups.members[group], value, accepted, quality.si_sdr, quality.si_sdri)


def recall(context: Context, estimate: Estimate) -> dict[int, float]:
    """Score every source by what the exploration has heard of it: {source: score}.

    Each source's best orientation is separated once, and tells of every source that stands apart well there. Nothing
    is recalled where nothing was explored.
    """
    if not context.explored or context.tools.voiceprint is None:
        return {}
    headings = np.array([heard.heading for heard in context.explored])
    apart = isolation(
        [source.azimuth for source in estimate.sources],
        headings,
        context.settings.spacing,
        context.settings.speed_of_sound,
        [source.elevation or 0.0 for source in estimate.sources],
    )
    separated = {int(i): separate(context, estimate, context.explored[i]) for i in sorted(set(apart.argmax(axis=1)))}
    recalled = {}
    for source, curve in enumerate(apart):
        where = [i for i in separated if curve[i] >= APART * curve.max()]
        clips = [voice for i in where for voice in _alone(source, *separated[i])]
        if clips:
            recalled[source] = _likeness(context, np.concatenate(clips))
    return recalled


def _likeness(context: Context, voice: Real) -> float:
    """Score a voice; 0, undecided, when nobody is sought."""
    target = context.tools.voiceprint
    return 0.0 if target is None else target.score(voice, context.settings.rate).value


def _alone(source: int, groups: Groups, voices: Real) -> list[Real]:
    return [voice for members, voice in zip(groups.members, voices, strict=True) if members == (source,)]
