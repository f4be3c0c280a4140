"""What has been heard of every source alone since it was found: all of it together is compared with the target.

A few seconds tell little about a voice, and from one heading they err alike. Each further clip of the same source adds
to what is known, and nothing that was separated once is separated again.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from ross_payload.interfaces import Clip, Groups, VoicePrint

MOST = 40.0  # of every source that are compared, the latest [s]


@dataclass(slots=True)
class Evidence:
    """Clips of every source, and how much they sound like the target, by source."""

    rate: int  # [Hz]
    target: VoicePrint | None  # None: nobody is sought, every score is 0
    scores: dict[int, float] = field(default_factory=dict)  # of all clips of a source joined [nat]
    clips: dict[int, list[Clip]] = field(default_factory=dict)  # what is compared
    listened: dict[int, float] = field(default_factory=dict)  # how long for them, with what is not compared [s]
    recalled: dict[int, dict[int, Clip]] = field(default_factory=dict)  # voices by source, by orientation explored
    told: dict[int, set[int]] = field(default_factory=dict)  # orientations at which each was recalled
    method: str = ""  # the separator of what was recalled

    def seconds(self, source: int) -> float:
        """How much of what was heard of a source is compared [s]."""
        return sum(len(clip.samples) for clip in self.clips.get(source, [])) / self.rate

    def hear(self, source: int, *clips: Clip, seconds: float) -> float:
        """Add clips of a source that were heard in so many seconds; return the score of all of it."""
        self.listened[source] = self.listened.get(source, 0.0) + seconds
        clips = tuple(clip for clip in clips if clip.samples.size)
        if not clips:
            return self.scores.get(source, 0.0)
        self.clips[source] = kept = [*self.clips.get(source, []), *clips]
        if self.target is not None:
            self.scores[source] = self.target.score_clips(latest(kept, round(MOST * self.rate)), self.rate).value
        return self.scores.setdefault(source, 0.0)

    def alone(self, voice: Clip) -> float:
        """Score a voice by itself, whoever it is; 0, undecided, when nobody is sought."""
        if self.target is None or not voice.samples.size:
            return 0.0
        return self.target.score_clips([voice], self.rate).value

    def renamed(self, names: Mapping[int, int]) -> Evidence:
        """Return the same of the sources that have a name in another estimate, {here: there}."""
        scores = {names[source]: value for source, value in self.scores.items() if source in names}
        clips = {names[source]: list(heard) for source, heard in self.clips.items() if source in names}
        listened = {names[source]: seconds for source, seconds in self.listened.items() if source in names}
        return Evidence(self.rate, self.target, scores, clips, listened, method=self.method)


def latest(clips: Sequence[Clip], most: int) -> list[Clip]:
    """Return the last samples of clips, at most so many.

    >>> import numpy as np
    >>> clips = [Clip(np.arange(3)), Clip(np.arange(4), 0.5), Clip(np.arange(2))]
    >>> [(clip.samples.tolist(), clip.poorness) for clip in latest(clips, 4)]
    [([2, 3], 0.5), ([0, 1], 0.0)]
    """
    kept: list[Clip] = []
    for clip in reversed(clips):
        if most > 0:
            kept.insert(0, replace(clip, samples=clip.samples[-most:]))
            most -= len(clip.samples)
    return kept


def lone_voices(groups: Groups, voices: Sequence[Clip]) -> dict[int, Clip]:
    """Return the voices of groups of one source, by source.

    >>> import numpy as np
    >>> groups = Groups(np.zeros((2, 1, 0), complex), ((0, 2), (1,)), "made up")
    >>> list(lone_voices(groups, [Clip(np.zeros(5))] * 2))
    [1]
    """
    pairs = zip(groups.members, voices, strict=True)
    return {members[0]: voice for members, voice in pairs if len(members) == 1}
