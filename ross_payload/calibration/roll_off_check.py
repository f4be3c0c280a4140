"""How differently two microphones roll off, heard from several talkers whose azimuths are about known.

Where one talker rules a bin of frequency f its phase is, with the unit ``u = d / v_p`` and amplitudes a of 1 at most,

    2 pi f (u a_k cos(theta_k - phi) + tau_0) + f_0 / f.

Elevations and reflections shorten delays, and azimuths that an explorer has found without f_0 are off by it. So all of
these are corrected together by least squares (Gauss-Newton), and what they leave at each heading tells how sure f_0 is
(delete-one jackknife; Efron 1982).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ross_payload.calibration.estimate import DELAY_FROM, span_of
from ross_payload.dsp.itd import Trust, band_limits, weighted_itd
from ross_payload.dsp.stft import Stft, band
from ross_payload.events import Estimate
from ross_payload.interfaces import Real, Samples

FRAME = 0.05  # [s], rounded to a power of two in samples
RULED = Trust(neighbourhood=(3, 3), coherence=0.99)  # bins that one talker rules
NEAR = (0.25, 0.25, 0.15, 0.15)  # from the delay of a talker, round by round [u]
APART = 1.6  # times as far must that of any other talker be
FEWEST = 200  # bins
HEADINGS = 7
TALKERS = 2  # the reflections of one alone may all say the same
WORTH_HZ = 15.0  # a word: 1.7 deg of phase at 500 Hz
SURE = 5.0  # standard deviations
RIDGE = 1e-9
MICRO = 1e-6


@dataclass(frozen=True, slots=True)
class Bins:
    """What one talker rules at all headings, (n,) each."""

    frequency: Real  # [Hz]
    delay: Real  # [u]
    weight: Real
    heading: Real  # [rad]


def roll_off_contradiction(
    heard: Iterable[tuple[float, Samples]], found: Estimate, rate: int, unit: float
) -> float | None:
    """By how much microphone 2 rolls off above microphone 1 [Hz]; None where that is not sure, or not worth a word.

    Both are judged more strictly where reverberation widens the standard deviations of azimuths. Parameters as of
    `roll_off_apart`.
    """
    if found.k < TALKERS:
        return None
    wider = float(np.median([source.sigma / source.nominal for source in found.sources]))
    told = roll_off_apart(heard, np.array([source.azimuth for source in found.sources]), rate, unit)
    if told is None or abs(told[0]) < max(WORTH_HZ * wider**2, SURE * wider * told[1]):
        return None
    return told[0]


def roll_off_apart(
    heard: Iterable[tuple[float, Samples]], azimuths: Real, rate: int, unit: float
) -> tuple[float, float] | None:
    """By how much microphone 2 rolls off above microphone 1 [Hz], and one standard deviation.

    Parameters
    ----------
    heard
        Heading [rad] and samples (2, n) of everything that was heard at rest.
    azimuths
        Of the talkers, as an explorer has found them [rad], (k,).
    rate
        Of the samples [Hz].
    unit
        d / v_p [s].

    Returns
    -------
    tuple or None
        None when too little was heard, or at too few headings.
    """
    bins = _bins(heard, rate, unit)
    headings = np.unique(bins.heading)
    if not len(azimuths) or len(headings) < HEADINGS:
        return None
    late = span_of(headings.tolist()) >= DELAY_FROM  # then a delay can be told from the rest
    k = len(azimuths)
    found = np.concatenate([azimuths, np.ones(k), np.zeros(2)])
    for near in NEAR:
        slopes, left, weight, at = _linearised(bins, found, unit, near)
        if len(left) < FEWEST:
            return None
        if not late:
            slopes[:, -2] = 0.0
        sums = [_sums(slopes[at == heading], left[at == heading], weight[at == heading]) for heading in headings]
        squares, products = (np.array(each) for each in zip(*sums, strict=True))
        ridge = RIDGE * float(np.trace(squares.sum(axis=0))) * np.eye(2 * k + 2)
        change = np.linalg.solve(squares.sum(axis=0) + ridge, products.sum(axis=0))
        found = found + change
    without = squares.sum(axis=0) - squares + ridge, products.sum(axis=0) - products
    others = np.linalg.solve(without[0], without[1][..., None])[:, -1, 0]
    n = len(headings)
    return float(found[-1]), math.sqrt((n - 1) * float(np.var(others)))


def _bins(heard: Iterable[tuple[float, Samples]], rate: int, unit: float) -> Bins:
    frame = 2 ** round(math.log2(FRAME * rate))
    stft = Stft(rate, frame, frame // 2)
    used = band(stft.frequencies, *band_limits(unit, 1.0))
    frequencies = stft.frequencies[used]
    parts = []
    for heading, samples in heard:
        if samples.shape[1] >= 2 * frame:
            spectrogram = stft.analyse(samples)[:, used]
            delay, weight = weighted_itd(spectrogram, frequencies, stft.period, None, RULED)
            i, j = np.nonzero(weight)
            parts.append(np.stack([frequencies[i], delay[i, j] / unit, weight[i, j], np.full(len(i), heading)]))
    return Bins(*np.concatenate([np.zeros((4, 0)), *parts], axis=1))


def _linearised(bins: Bins, found: Real, unit: float, near: float) -> tuple[Real, Real, Real, Real]:
    """Slopes of the phase by every parameter (n, 2 k + 2), phases left over, weights, and headings.

    Parameters are azimuths [rad], amplitudes, the delay [us] and the roll-off [Hz].
    """
    k = len(found) // 2 - 1
    azimuths, amplitudes, (delay, higher) = found[:k], found[k : 2 * k], found[2 * k :]
    turn = 2 * np.pi * unit * bins.frequency  # phase of one unit of delay [rad]
    around = azimuths[:, None] - bins.heading
    away = bins.delay - amplitudes[:, None] * np.cos(around) - MICRO * delay / unit - higher / bins.frequency / turn
    ordered = np.sort(np.abs(away), axis=0)
    alone = ordered[0] < near if k == 1 else (ordered[0] < near) & (ordered[1] > APART * near)
    talker, n = np.abs(away).argmin(axis=0)[alone], np.arange(int(np.count_nonzero(alone)))
    turn, away, around = turn[alone], away[:, alone], around[:, alone]
    slopes = np.zeros((len(n), 2 * k + 2))
    slopes[n, talker] = -turn * amplitudes[talker] * np.sin(around[talker, n])
    slopes[n, k + talker] = turn * np.cos(around[talker, n])
    slopes[:, -2] = turn * MICRO / unit
    slopes[:, -1] = 1 / bins.frequency[alone]
    return slopes, turn * away[talker, n], bins.weight[alone] / turn, bins.heading[alone]


def _sums(slopes: Real, left: Real, weight: Real) -> tuple[Real, Real]:
    weighted = slopes * weight[:, None]
    return weighted.T @ slopes, weighted.T @ left
