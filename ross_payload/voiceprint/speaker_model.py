"""Enrol a voice and score others against it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ross_payload.errors import AudioError
from ross_payload.interfaces import Real, Score
from ross_payload.voiceprint.background import Adapted, Background, shipped_background
from ross_payload.voiceprint.features import analyse, checked

ENROL_SECONDS = 1.5  # least voiced speech to enrol from [s]
SCORE_SECONDS = 0.3  # with less voiced speech a recording tells nothing [s]
SEPARATED_CRITERION = 4.0  # [nat]: what a separator leaves of one voice is like what it leaves of another
CLIPPED_SHARE = 5e-4  # of the samples, from which a recording counts as clipped


@dataclass(frozen=True, slots=True)
class VoicePrintModel:
    """One enrolled voice, an ``interfaces.VoicePrint``."""

    voice: Adapted
    seconds: float  # voiced speech that it was enrolled from [s]
    background: Background = field(repr=False)
    criterion: float = 0.0  # evidence [nat] at which this print is undecided
    consent: str = ""  # how the talker agreed, in words; empty: the file does not say

    def score(self, voice: Real, rate: int) -> Score:
        """Compare a recording (n_samples,) at ``rate`` [Hz] with the enrolled voice.

        A recording with hardly any voiced speech has the score 0, undecided, and is not accepted.

        Raises
        ------
        AudioError
            When the recording is empty, not one channel, not finite, or sampled below 16 kHz.
        """
        features = analyse(voice, rate)
        if features.seconds < SCORE_SECONDS:
            return Score(0.0, accepted=False)
        value = self.background.compare(self.voice, features) - self.criterion
        return Score(value, accepted=value > 0.0)


def enrol(voice: Real, rate: int, background: Background | None = None, *, separated: bool = False) -> VoicePrintModel:
    """Enrol a talker from a recording (n_samples,) at ``rate`` [Hz]; 4 s of clean speech are enough.

    A voice that was ``separated`` from others makes a print that is compared with separated voices alone.

    Raises
    ------
    AudioError
        When the recording is empty, silent, clipped, not finite, or holds less than 1.5 s of voiced speech.
    """
    samples = checked(voice, rate)
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
    model = background or shipped_background()
    criterion = SEPARATED_CRITERION if separated else 0.0
    return VoicePrintModel(model.adapt(features), features.seconds, model, criterion)


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
