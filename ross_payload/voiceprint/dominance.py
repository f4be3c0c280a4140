"""What of a separated voice is compared with a print: of a soft one that holds much of the others, where it dominates.

Remains of the others hardly matter in a voice that was separated well, or is as loud as they are. Of one that is 10 dB
softer they make up the greater part while the others talk. Its share of the power of all voices tells when they do:
what is compared is mostly from their pauses.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import uniform_filter1d

from ross_payload.interfaces import Clip, Quality, Real

BLOCK = 0.01  # in which power is measured [s]
AROUND = 15  # blocks that a share is of
LEAST = 0.05  # share below which nothing is kept of a voice that is weighted fully
POOR, GOOD = 1.0, 5.0  # SI-SDR that is expected of a voice which is weighted fully, and not at all [dB]
SOFT = 6.0  # below the mean of the others: weighted fully; not at all when as loud [dB]
SILENCE = 1e-20  # power or energy of a voice that is as good as nothing


def dominant(voices: Real, quality: Sequence[Quality], rate: int) -> list[Clip]:
    """Voices of one separation (n_groups, n_samples) as they are compared.

    A voice that is `SOFT`, and of which the separator expects an SI-SDR of `POOR` or less, is multiplied by its share
    of the power of all of them during 150 ms around, and cut out where that is less than `LEAST`. One that is as loud
    as the mean of the others, or `GOOD`, is compared as it is; in between there are powers of the share. The exponent
    is what is told as `Clip.poorness`.

    Parameters
    ----------
    voices
        (n_groups, n_samples).
    quality
        How clean every group is believed to be; () where the separator does not say: all are compared as they are.
    rate
        [Hz].

    Examples
    --------
    >>> loud, soft = np.ones(32000), np.full(32000, 0.1)
    >>> loud[16000:] = 0
    >>> kept = dominant(np.stack([loud, soft]), (Quality(15.0, 5.0), Quality(-1.0, 7.0)), 16000)
    >>> [(round(len(clip.samples) / 16000, 2), clip.poorness) for clip in kept]
    [(2.0, 0.0), (0.95, 1.0)]
    """
    size, n = max(round(BLOCK * rate), 1), voices.shape[1]
    n_blocks, exponents = -(-n // size), _exponents(voices, quality)
    if not any(exponents) or n_blocks == 0:
        return [Clip(voice) for voice in voices]
    padded = np.pad(voices.astype(np.float64), ((0, 0), (0, n_blocks * size - n)))
    blocks = np.mean(padded.reshape(len(voices), n_blocks, size) ** 2, axis=2)
    power = uniform_filter1d(blocks, AROUND, axis=1) + SILENCE
    places = np.arange(n) / size - 0.5  # of samples among the middles of blocks
    kept = []
    for voice, share, exponent in zip(voices, power / power.sum(axis=0), exponents, strict=True):
        here = np.interp(places, np.arange(n_blocks), share)
        weighted = voice * (here**exponent).astype(voice.dtype)
        kept.append(Clip(weighted[here >= LEAST * exponent], exponent))
    return kept


def _exponents(voices: Real, quality: Sequence[Quality]) -> list[float]:
    """Of the share by which every voice is weighted: 1 fully, 0 not at all."""
    if len(voices) < 2 or not quality:
        return [0.0] * len(voices)
    energy = np.sum(voices**2, axis=1, dtype=np.float64) + SILENCE
    softer = 10 * np.log10((energy.sum() - energy) / (len(voices) - 1) / energy)
    poor = [(GOOD - each.si_sdr) / (GOOD - POOR) for each in quality]
    return [float(np.clip(min(both), 0, 1)) for both in zip(poor, softer / SOFT, strict=True)]
