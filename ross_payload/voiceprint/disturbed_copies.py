"""Disturbed copies of an enrolment: as a room, a separator and noise would leave it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from ross_payload.dsp.stft import Stft
from ross_payload.interfaces import Real
from ross_payload.voiceprint.features import RATE

COPIES = 6  # every second one masked
REVERBERATION_S = (0.25, 0.6)  # times in which the tail falls by 60 dB [s]
DIRECT_DB = (-3.0, 6.0)  # direct sound over tail
SNR_DB = (10.0, 25.0)
TAIL_BEGINS_S = 0.002
STFT = Stft(RATE, 1024, 256)  # of the masks
FLOOR = 0.1  # least gain of a mask
RIVAL_DB = (-6.0, 3.0)  # level of whom a mask takes away


def disturbed(voice: Real, seed: int = 0) -> Iterator[Real]:
    """Return `COPIES` of a voice (n,) at `RATE`, the same for the same voice and seed."""
    rng = np.random.default_rng(seed)
    for copy in range(COPIES):
        heard = _in_a_room(voice, rng)
        if copy % 2:
            heard = _masked(heard, _in_a_room(_others_speech(voice, rng), rng), rng)
        noise = rng.standard_normal(len(heard))
        yield heard + noise * _rms(heard) * 10 ** (-rng.uniform(*SNR_DB) / 20)


def _in_a_room(voice: Real, rng: np.random.Generator) -> Real:
    """Add an exponentially decaying tail of noise (J. Polack's model of a diffuse response), (n,)."""
    decay_s = rng.uniform(*REVERBERATION_S)
    time = np.arange(round(decay_s * RATE)) / RATE
    tail = rng.standard_normal(len(time)) * 10 ** (-3 * time / decay_s) * (time > TAIL_BEGINS_S)
    tail *= 10 ** (-rng.uniform(*DIRECT_DB) / 20) / np.linalg.norm(tail)
    tail[0] = 1.0
    size = next_fast_len(len(voice) + len(tail), real=True)
    return np.asarray(irfft(rfft(voice, size) * rfft(tail, size), size)[: len(voice)])


def _others_speech(voice: Real, rng: np.random.Generator) -> Real:
    """Return what is as loud, as long and as full of pauses as speech, and is not this voice's: it runs backwards."""
    return np.roll(voice[::-1], rng.integers(len(voice)))


def _masked(voice: Real, rival: Real, rng: np.random.Generator) -> Real:
    """Apply the gain of a Wiener filter that takes a rival (n,) away, as separators do, and leave what it leaves."""
    rival = rival * _rms(voice) / max(_rms(rival), np.finfo(float).tiny) * 10 ** (rng.uniform(*RIVAL_DB) / 20)
    own, other = STFT.analyse(voice), STFT.analyse(rival)
    power, against = np.abs(own) ** 2, np.abs(other) ** 2
    gain = np.maximum(power / (power + against + np.finfo(float).tiny), FLOOR)
    return STFT.synthesise(gain * (own + other), len(voice))


def _rms(signal: Real) -> float:
    return float(np.sqrt(np.mean(np.square(signal))))
