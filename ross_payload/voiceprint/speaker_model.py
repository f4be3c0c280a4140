"""Enrol a voice and score others against it."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from ross_payload.dsp.recording_limits import HIGHEST_PEAK
from ross_payload.errors import AudioError
from ross_payload.interfaces import Real
from ross_payload.voiceprint.built_in import built_in_model
from ross_payload.voiceprint.embedding_print import Embedder, EmbeddingPrint
from ross_payload.voiceprint.features import Features, analyse, at_rate, checked

ENROL_SECONDS = 1.5  # least voiced speech to enrol from [s]
LONGEST = 120.0  # what `ross enroll` uses of a recording [s]: 4 s are enough, and memory grows with it
CLIPPED_SHARE = 5e-4  # of the samples, from which a recording counts as clipped


class VoiceModel(Embedder, Protocol):
    """Makes prints of voices."""

    def enrolled(self, samples: Real, features: Features, *, separated: bool) -> EmbeddingPrint:
        """Return the print of a voice: samples (n,) at `features.RATE`, and what is measured of them."""


def enrol(voice: Real, rate: int, model: VoiceModel | None = None, *, separated: bool = False) -> EmbeddingPrint:
    """Enrol a talker from a recording (n_samples,) at ``rate`` [Hz]; 4 s of clean speech are enough.

    The ``model`` is the built-in one unless another is given.

    A voice that was ``separated`` from others makes a print that is compared with separated voices alone.

    Raises
    ------
    AudioError
        When the recording is empty, silent, clipped, not finite, louder than any sound, sampled below 16 or above
        192 kHz, or holds less than 1.5 s of voiced speech.
    """
    samples = checked(voice, rate)
    peak = np.abs(samples).max()
    if peak > HIGHEST_PEAK:
        raise AudioError(f"enrolment: expected samples of at most {HIGHEST_PEAK:g} re full scale, got {peak:.3g}")
    if not samples.any():
        raise AudioError(f"enrolment: expected speech, got {len(samples) / rate:.1f} s of silence")
    if clipped_share(samples) > CLIPPED_SHARE:
        raise AudioError(
            f"enrolment: the recording is clipped ({100 * clipped_share(samples):.1f} % of the samples): "
            "record again at a lower level"
        )
    features = analyse(samples, rate)
    if features.seconds < ENROL_SECONDS:
        raise AudioError(
            f"enrolment: expected at least {ENROL_SECONDS} s of voiced speech, "
            f"got {features.seconds:.1f} s in {len(samples) / rate:.1f} s"
        )
    return (model or built_in_model()).enrolled(at_rate(samples, rate), features, separated=separated)


def clipped_share(samples: Real) -> float:
    """Return the share of samples in flat tops: three or more in a row at the highest level.

    Examples
    --------
    >>> clipped_share(np.array([0.0, 1, 1, 1, 0, -1, 0.5, 1]))
    0.375
    """
    top = np.abs(samples) >= (1 - 1e-4) * np.abs(samples).max()
    middle = np.zeros_like(top)
    middle[1:-1] = top[:-2] & top[1:-1] & top[2:]
    flat = middle.copy()
    flat[:-1] |= middle[1:]
    flat[1:] |= middle[:-1]
    return float(np.mean(flat))
