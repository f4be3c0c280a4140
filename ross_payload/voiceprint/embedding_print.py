"""A voice print that is one vector, compared with that of a recording as its model says.

A print is the mean of the vectors of the enrolment and of disturbed copies of it ("multi-condition"), since what it is
compared with was separated from others in a room.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np

from ross_payload.interfaces import Clip, Real, Score
from ross_payload.voiceprint.disturbed_copies import disturbed
from ross_payload.voiceprint.features import RATE, at_rate, checked

MOST_KNOWN = 128  # embeddings of clips that a print keeps in memory, the latest
SHORTEST = 1.5  # of which there is an embedding of its own [s]
LEAST_SECONDS = 0.3  # with less a recording tells nothing [s]
SHORT_S, LONG_S = 3.0, 10.0  # durations at which a model is calibrated [s]


@dataclass(frozen=True, slots=True)
class Calibration:
    """From how alike two embeddings are to a log-likelihood ratio, by the duration of what is scored.

    The ratio [nat] is slope * (similarity - threshold); both are those of `SHORT_S` and `LONG_S`, between them they
    follow the logarithm of the duration, beyond them they stay. What remains of the others in a poor voice makes it
    less like every print: one whose `Clip.poorness` is 1 has a slope and a threshold of its own, in between they lie
    between (a quality measure, Ferrer, Graciarena, Zymnis and Shriberg, "System combination using auxiliary
    information for speaker verification", Proc. ICASSP 2008).
    """

    slopes: tuple[float, float]  # [nat]
    thresholds: tuple[float, float]
    source: str = ""  # how it was measured, in words; empty: it was not, these are another model's
    poor: tuple[float, float] | None = None  # slope [nat] and threshold of a poor voice; None: as of any other

    def ratio(self, similarity: float, seconds: float, poorness: float = 0.0) -> float:
        """Return the log-likelihood ratio [nat] of a similarity that was measured on so many seconds of a voice."""
        where = np.log(np.clip(seconds, SHORT_S, LONG_S) / SHORT_S) / np.log(LONG_S / SHORT_S)
        slope, threshold = (first + where * (last - first) for first, last in (self.slopes, self.thresholds))
        if self.poor is not None:
            slope += poorness * (self.poor[0] - slope)
            threshold += poorness * (self.poor[1] - threshold)
        return float(slope * (similarity - threshold))


class Embedder(Protocol):
    """A model that turns a recording into a vector."""

    @property
    def fingerprint(self) -> str:
        """Sixteen hexadecimal digits that tell this model from another."""

    @property
    def calibration(self) -> Calibration:
        """How a similarity is read."""

    @property
    def several(self) -> float:
        """By how much the ratio of several clips is lowered [nat]: with them a mission decides."""

    @property
    def size(self) -> int:
        """Numbers of an embedding."""

    def similarity(self, enrolled: Real, test: Real) -> float:
        """Return how alike the embeddings of a print and of a recording are, (size,) each."""

    def embed(self, samples: Real) -> Real:
        """Return the embedding of a recording (n,) at `RATE`, of length 1 or, without speech, 0, (size,)."""


@dataclass(frozen=True, slots=True)
class EmbeddingPrint:
    """One enrolled voice, an ``interfaces.VoicePrint``."""

    embedding: Real = field(repr=False)  # of length 1, (size,)
    seconds: float  # voiced speech that it was enrolled from [s]
    model: Embedder = field(repr=False)
    criterion: float = 0.0  # log-likelihood ratio [nat] at which this print is undecided
    consent: str = ""  # how the talker agreed, in words; empty: the file does not say
    known: dict[bytes, Real] = field(default_factory=dict, repr=False, compare=False)  # embeddings, by what was heard

    @property
    def fingerprint(self) -> str:
        """Of the model that made it."""
        return self.model.fingerprint

    def score(self, voice: Real, rate: int) -> Score:
        """Compare a recording (n_samples,) at ``rate`` [Hz] with the enrolled voice.

        A recording of less than 0.3 s, or with hardly any speech, has the score 0, undecided, and is not accepted.

        Raises
        ------
        AudioError
            When the recording is empty, not one channel, not finite, or sampled below 16 or above 192 kHz.
        """
        return self.score_clips([Clip(voice)], rate)

    def score_clips(self, clips: Sequence[Clip], rate: int) -> Score:
        """Compare clips of one voice, for which the same holds, with the enrolled voice.

        What is compared is the mean of their embeddings, by duration. Among several talkers every heading leaves other
        remains of the others: an embedding of all of it at once is further from the voice.
        """
        samples = joined([at_rate(checked(clip.samples, rate), rate) for clip in clips], round(SHORTEST * RATE))
        said = [clip for clip in samples if clip.any() and len(clip) >= LEAST_SECONDS * RATE]
        embedding = unit(np.sum([len(clip) * self._embedded(clip) for clip in said], axis=0)) if said else np.zeros(0)
        found = self.compared(embedding, sum(map(len, samples)) / RATE, poorness_of(clips))
        value = found.value - self.model.several if len(said) > 1 and embedding.any() else found.value
        return Score(value, accepted=value > 0.0)

    def _embedded(self, clip: Real) -> Real:
        """Return the embedding of a clip (n,): it is compared again whenever another one of its voice was heard."""
        key = hashlib.blake2b(np.ascontiguousarray(clip).tobytes()).digest()
        if key not in self.known:
            if len(self.known) >= MOST_KNOWN:
                del self.known[next(iter(self.known))]
            self.known[key] = self.model.embed(clip)
        return self.known[key]

    def compared(self, embedding: Real, seconds: float, poorness: float = 0.0) -> Score:
        """Compare the embedding (size,) of so many seconds with the enrolled voice; 0 is undecided."""
        if not embedding.any():
            return Score(0.0, accepted=False)
        similarity = self.model.similarity(self.embedding, embedding)
        value = self.model.calibration.ratio(similarity, seconds, poorness) - self.criterion
        return Score(value, accepted=value > 0.0)

    def agreed(self, consent: str) -> EmbeddingPrint:
        """Return the same with how the talker agreed."""
        return replace(self, consent=consent)

    def values(self) -> dict[str, Any]:
        """Return what a file keeps, ready for JSON."""
        return {"embedding": np.round(self.embedding, 6).tolist(), "criterion": self.criterion}


def joined(clips: Sequence[Real], least: int) -> list[Real]:
    """Join clips (n,) with those that follow until every one has so many samples, but for the only one.

    >>> joined([np.zeros(3), np.zeros(1), np.zeros(1), np.zeros(4), np.zeros(1)], 2)
    [array([0., 0., 0.]), array([0., 0.]), array([0., 0., 0., 0., 0.])]
    """
    found: list[Real] = []
    waiting: list[Real] = []
    for clip in clips:
        waiting.append(clip)
        if sum(map(len, waiting)) >= least:
            found.append(np.concatenate(waiting))
            waiting = []
    rest = [*found[-1:], *waiting]
    return [*found[:-1], np.concatenate(rest)] if waiting else found


def poorness_of(clips: Sequence[Clip]) -> float:
    """Return the mean `Clip.poorness` of clips, by duration; 0 of nothing.

    >>> poorness_of([Clip(np.zeros(3), 1.0), Clip(np.zeros(1), 0.0)]), poorness_of([])
    (0.75, 0.0)
    """
    whole = sum(len(clip.samples) for clip in clips)
    return sum(len(clip.samples) * clip.poorness for clip in clips) / whole if whole else 0.0


def enrolled_print(
    model: Embedder, samples: Real, seconds: float, *, separated: bool, criterion: float = 0.0
) -> EmbeddingPrint:
    """Return the print of a voice (n,) at `RATE`: of its recording and, unless it was ``separated``, of copies."""
    clips = [samples] if separated else [samples, *disturbed(samples)]
    return EmbeddingPrint(unit(np.sum([model.embed(clip) for clip in clips], axis=0)), seconds, model, criterion)


def restored_print(model: Embedder, values: dict[str, Any], seconds: float, consent: str) -> EmbeddingPrint:
    """Make a print again from its `EmbeddingPrint.values`.

    Raises
    ------
    ValueError
        When they are not those of a print of this model.
    """
    embedding, criterion = np.array(values["embedding"], np.float64), float(values.get("criterion", 0.0))
    if embedding.shape != (model.size,):
        raise ValueError(f"expected {model.size} numbers, got {embedding.size}")
    if not np.isfinite(embedding).all() or not np.isfinite(criterion) or not embedding.any():
        raise ValueError("expected finite numbers, not all of them 0")
    return EmbeddingPrint(unit(embedding), seconds, model, criterion, consent)


def unit(vector: Real) -> Real:
    """Return a vector (n,), scaled to length 1; 0 stays 0."""
    return np.asarray(vector / max(np.linalg.norm(vector), np.finfo(float).tiny))
