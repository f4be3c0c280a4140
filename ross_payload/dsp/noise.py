"""The noise PSD: measured while nobody talks, or guessed from the quietest frames."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaincinv

from ross_payload.interfaces import Complex, Real

SPREAD = 3.0  # frames within this of the quiet level are noise [dB]
RISE = 6.0  # what comes later is at least this much louder [dB]
FRAMES = 8  # fewer quiet frames tell nothing
SHARE = 0.4  # of the lead-in that must be quiet
QUANTILE = 0.1  # of the bin powers, for the guess
LOUDEST = 4  # the loudest quarter of the bins tells voices from machines
VARYING = 3.9  # the power in a bin that varies by more is no steady noise; Gaussian noise has 2.5 [dB]
EXCESS = 5.0  # and no noise either if what follows is that much lower at times [dB]


def frame_levels(spectrogram: Complex) -> Real:
    """Mean power per frame over microphones and frequencies, (n_frames,)."""
    return np.asarray((np.abs(spectrogram) ** 2).mean(axis=(0, 1)), float)


def quiet_psd(lead_in: Complex, later: Complex) -> Real | None:
    """Noise PSD E|noise|^2 per bin and microphone from a lead-in in which nobody talks, else None.

    The frames within 3 dB of the lower quartile of the levels are quiet: a cough or a talker who starts early stays
    out. They are noise when they are at least 40 % of the lead-in (speech is not that stationary) and the loud tenth
    of what comes later is at least 6 dB above them. Several people who talk at once can be that stationary, but not
    in every bin: if the bins vary as those of voices do and what comes later is 5 dB lower at times, somebody talked.

    Parameters
    ----------
    lead_in, later
        Spectrograms (2, n_freqs, n_frames).

    Returns
    -------
    ndarray or None
        (n_freqs,), the mean over the quiet frames and both microphones.
    """
    levels, loud = frame_levels(lead_in), frame_levels(later)
    if levels.size < FRAMES or not loud.size:
        return None
    quiet = quiet_frames(lead_in)
    if quiet.size < max(FRAMES, SHARE * levels.size):
        return None
    if np.quantile(loud, 0.9) < 10 ** (RISE / 10) * levels[quiet].mean() or not loud.max():
        return None
    power = np.abs(lead_in[:, :, quiet]) ** 2
    psd = np.asarray(power.mean(axis=(0, 2)), float)
    loudest = np.argsort(psd)[-max(1, psd.size // LOUDEST) :]
    heard = later[:, loudest][:, :, loud > 0]  # a gap in a recording is no pause of talkers
    excess = _decibel(psd[loudest]) - _decibel(guessed_psd(heard))
    if np.median(flatness(power[:, loudest])) > VARYING and np.median(excess) > EXCESS:
        return None
    return psd


def flatness(power: Real) -> Real:
    """Arithmetic over geometric mean of the powers of the last axis [dB], at least 0.

    A bin of stationary Gaussian noise has an exponentially distributed power: 10 log10(e) times Euler's constant,
    2.51 dB. Bins of voices have 4 to 12 dB, as they are empty between harmonics and sounds.
    """
    return np.asarray(_decibel(power.mean(axis=-1)) - _decibel(power).mean(axis=-1))


def quiet_frames(lead_in: Complex) -> NDArray[np.intp]:
    """Indices of the frames of (2, n_freqs, n_frames) that are within 3 dB of the lower quartile of the levels."""
    inner = _decibel(frame_levels(lead_in)[1:-1])  # the frames at the ends are partly empty
    return np.flatnonzero(np.abs(inner - np.quantile(inner, 0.25)) <= SPREAD) + 1


def guessed_psd(spectrogram: Complex) -> Real:
    """Guess the noise PSD per bin and microphone from the quietest tenth of a mixture, (n_freqs,).

    A low quantile of the power per bin, divided by that quantile of the mean power of two independent channels of
    Gaussian noise (a gamma distribution of shape 2); Martin 2001 uses the minimum in the same way.
    """
    if not spectrogram.shape[-1]:
        return np.zeros(spectrogram.shape[1])
    power = (np.abs(spectrogram) ** 2).mean(axis=0)
    unit = 0.5 * float(gammaincinv(2, QUANTILE))
    return np.asarray(np.quantile(power, QUANTILE, axis=-1) / unit, float)


def _decibel(power: Real) -> Real:
    return np.asarray(10 * np.log10(np.maximum(power, 1e-30)))
