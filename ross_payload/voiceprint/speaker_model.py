"""Enrol a voice and score others against it."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from ross_payload.dsp.recording_limits import HIGHEST_PEAK
from ross_payload.errors import AudioError
from ross_payload.interfaces import Real
from ross_payload.voiceprint.built_in import built_in_model
from ross_payload.voiceprint.embedding_print import Embedder, EmbeddingPrint
from ross_payload.voiceprint.features import HUM_EDGES, RATE, Features, analyse, at_rate, checked, without_hum

ENROL_SECONDS = 1.5  # least voiced speech to enrol from [s]
LONGEST = 120.0  # what `ross enroll` uses of a recording [s]: 4 s are enough, and memory grows with it
CLIPPED_SHARE = 5e-4  # of the samples, from which a recording counts as clipped
STEADY = 1e-3  # standard deviation over mean, up to which a recording is a constant voltage
TONE_SHARE = 0.9  # of the power, from which a recording is a tone
TONE_HZ = 5.0  # of the power is within so much of its frequency [Hz]
HUM_ALONE = 1e-3  # of the power is above the hum, up to which a recording is hum alone
INFRASOUND_HZ = 20.0  # nothing below it is heard


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
        When the recording is empty, silent, constant, drifting, a tone, clipped, not finite, louder than any sound,
        sampled below 16 or above 192 kHz, or holds less than 1.5 s of voiced speech.
    """
    samples = checked(voice, rate)
    peak = np.abs(samples).max()
    if peak > HIGHEST_PEAK:
        raise AudioError(f"enrolment: expected samples of at most {HIGHEST_PEAK:g} re full scale, got {peak:.3g}")
    if not samples.any():
        raise AudioError(f"enrolment: expected speech, got {len(samples) / rate:.1f} s of silence")
    if samples.std() <= STEADY * abs(samples.mean()):
        level = f"{samples.mean():.3g} re full scale"
        raise AudioError(f"enrolment: expected speech, got {len(samples) / rate:.1f} s of a constant level, {level}")
    sound = at_rate(samples, rate)
    frequency, share = strongest_tone(sound, RATE)  # before what is clipped: the tops of a slow tone are flat
    if share > TONE_SHARE:
        tone = f"a tone of {frequency:.0f} Hz" if frequency > INFRASOUND_HZ else "a level that drifts"
        raise AudioError(f"enrolment: expected speech, got {tone}")
    if clipped_share(samples) > CLIPPED_SHARE:
        raise AudioError(
            f"enrolment: the recording is clipped ({100 * clipped_share(samples):.1f} % of the samples): "
            "record again at a lower level"
        )
    if not separated:  # a voice that was separated is compared with others that have the same hum
        sound = without_hum(sound)
    features = analyse(sound, RATE)
    if features.seconds < ENROL_SECONDS:
        raise AudioError(
            f"enrolment: expected at least {ENROL_SECONDS} s of voiced speech, "
            f"got {features.seconds:.1f} s in {len(sound) / RATE:.1f} s"
        )
    return (model or built_in_model()).enrolled(sound, features, separated=separated)


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


def strongest_tone(samples: Real, rate: int) -> tuple[float, float]:
    """Return the frequency [Hz] at which samples (n,) are strongest, and the share of their power within 5 Hz of it.

    Hum of the mains, wind and drift, as of `without_hum`, do not count unless there is nothing else.

    Examples
    --------
    A tone of 440 Hz, and another one with half of its power, which is a third of the sum:

    >>> time = np.arange(32000) / 16000
    >>> tones = np.sin(2 * np.pi * 440 * time) + np.sqrt(0.5) * np.sin(2 * np.pi * 1000 * time)
    >>> tuple(round(float(value), 2) for value in strongest_tone(tones, 16000))
    (440.0, 0.67)
    """
    spectrum = np.abs(np.fft.rfft((samples - samples.mean()) * np.hanning(samples.size))) ** 2
    lowest = math.ceil(HUM_EDGES[1] * samples.size / rate)
    if spectrum[lowest:].sum() > HUM_ALONE * spectrum.sum():
        spectrum[:lowest] = 0
    peak, width = int(spectrum.argmax()), max(math.ceil(TONE_HZ * samples.size / rate), 2)  # the window's lobe has 2
    near = spectrum[max(peak - width, 0) : peak + width + 1]
    return peak * rate / samples.size, float(near.sum() / max(float(spectrum.sum()), np.finfo(float).tiny))
