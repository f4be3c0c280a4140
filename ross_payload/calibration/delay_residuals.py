"""What talkers whose azimuths are about known tell of the array: its spacing, and how differently it rolls off.

Where one talker rules a bin of frequency f its phase is, with the unit ``u = d / v_p`` as it is configured,

    2 pi f (u a_k cos(theta_k - phi) + tau_0) + f_0 / f.

Elevations and reflections make amplitudes a smaller than 1; only a wider array, or colder air, makes them larger.
Azimuths that an explorer has found without f_0 are off by it. So all of these are corrected together by least squares
(Gauss-Newton), and what they leave at each heading tells how sure they are (delete-one jackknife; Efron 1982).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ross_payload.calibration.estimate import DELAY_FROM, span_of
from ross_payload.dsp.itd import RULED, band_limits, weighted_itd
from ross_payload.dsp.stft import Stft, band
from ross_payload.events import Estimate
from ross_payload.interfaces import Real, Samples

FRAME = 0.05  # [s], rounded to a power of two in samples
NEAR = (0.25, 0.15, 0.15)  # from the delay of a talker, round by round [u]
FEWEST = 200  # bins
HEADINGS = 7
TALKERS = 2  # the reflections of one alone may all say the same
WORTH_HZ = 15.0  # a word: 1.7 deg of phase at 500 Hz
SURE = 5.0  # standard deviations
WIDER = 1.04  # times the configured spacing: from there on sources appear where nobody is
RIDGE = 1e-9
MICRO = 1e-6


@dataclass(frozen=True, slots=True)
class Bins:
    """What one talker rules at all headings, (n,) each."""

    frequency: Real  # [Hz]
    delay: Real  # [u]
    weight: Real
    heading: Real  # [rad]
    stretch: Real  # which of what was heard it is from, from 0, rising


@dataclass(frozen=True, slots=True)
class Residuals:
    """What the delays of several talkers leave unexplained; every ``_sigma`` is one standard deviation."""

    wider: float  # median of the talkers' amplitudes a
    wider_sigma: float
    roll_off: float  # f_0: of microphone 2 above microphone 1 [Hz]
    roll_off_sigma: float


def finer_contradiction(
    heard: Iterable[tuple[float, Samples]], found: Estimate, rate: int, unit: float
) -> tuple[float | None, float | None]:
    """Times by which the array is wider than configured, at least, and its difference of roll-off [Hz].

    None where one is not sure, or not worth a word. The roll-off is judged more strictly where reverberation widens the
    standard deviations of azimuths, and not at all where an explorer does not tell how much. Parameters as of
    `residuals_of`.
    """
    if found.k < TALKERS:
        return None, None
    left = residuals_of(heard, found.azimuths, rate, unit)
    if left is None:
        return None, None
    if left.wider > max(WIDER, 1 + SURE * left.wider_sigma):  # its delays tell nothing finer then
        return left.wider, None
    widened = [source.sigma / source.nominal_sigma for source in found.sources if source.nominal_sigma]
    if not widened:
        return None, None
    wet = max(float(np.median(widened)), 1.0)
    unequal = abs(left.roll_off) > max(WORTH_HZ * wet**2, SURE * wet * left.roll_off_sigma)
    return None, left.roll_off if unequal else None


def residuals_of(heard: Iterable[tuple[float, Samples]], azimuths: Real, rate: int, unit: float) -> Residuals | None:
    """Correct azimuths, amplitudes, delay and roll-off together by what was heard.

    Parameters
    ----------
    heard
        Heading [rad] and samples (2, n) of everything that was heard at rest.
    azimuths
        Of the talkers, as an explorer has found them [rad], (k,).
    rate
        Of the samples [Hz].
    unit
        d / v_p as configured [s].

    Returns
    -------
    Residuals or None
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
        slopes, left, weight, stretch = _linearised(bins, found, unit, near)
        if len(left) < FEWEST:
            return None
        if not late:
            slopes[:, -2] = 0.0
        sums = [_sums(slopes[part], left[part], weight[part]) for part in _parts(stretch)]
        squares, products = (np.array(each) for each in zip(*sums, strict=True))
        ridge = RIDGE * float(np.trace(squares.sum(axis=0))) * np.eye(2 * k + 2)
        change = np.linalg.solve(squares.sum(axis=0) + ridge, products.sum(axis=0))
        found = found + change
    without = squares.sum(axis=0) - squares + ridge, products.sum(axis=0) - products
    others = found + np.linalg.solve(without[0], without[1][..., None])[..., 0]
    wider, n = np.median(others[:, k : 2 * k], axis=1), len(sums)
    sigmas = (math.sqrt((n - 1) * float(np.var(each))) for each in (wider, others[:, -1]))
    return Residuals(float(np.median(found[k : 2 * k])), next(sigmas), float(found[-1]), next(sigmas))


def _bins(heard: Iterable[tuple[float, Samples]], rate: int, unit: float) -> Bins:
    frame = 2 ** round(math.log2(FRAME * rate))
    stft = Stft(rate, frame, frame // 2)
    used = band(stft.frequencies, *band_limits(unit, 1.0))
    frequencies = stft.frequencies[used]
    parts = []
    for stretch, (heading, samples) in enumerate(heard):
        if samples.shape[1] >= 2 * frame:
            spectrogram = stft.analyse(samples)[:, used]
            delay, weight = weighted_itd(spectrogram, frequencies, stft.period, None, RULED)
            i, j = np.nonzero(weight)
            same = np.full((2, len(i)), [[heading], [stretch]])
            parts.append(np.stack([frequencies[i], delay[i, j] / unit, weight[i, j], *same]))
    return Bins(*np.concatenate([np.zeros((5, 0)), *parts], axis=1))


def _linearised(bins: Bins, found: Real, unit: float, near: float) -> tuple[Real, Real, Real, Real]:
    """Slopes of the phase by every parameter (n, 2 k + 2), phases left over, weights, and stretches.

    Parameters are azimuths [rad], amplitudes, the delay [us] and the roll-off [Hz].
    """
    k = len(found) // 2 - 1
    azimuths, amplitudes, (delay, higher) = found[:k], found[k : 2 * k], found[2 * k :]
    turn = 2 * np.pi * unit * bins.frequency  # phase of one unit of delay [rad]
    around = azimuths[:, None] - bins.heading
    away = bins.delay - amplitudes[:, None] * np.cos(around) - MICRO * delay / unit - higher / bins.frequency / turn
    ruled = np.abs(away).min(axis=0) < near
    talker, n = np.abs(away).argmin(axis=0)[ruled], np.arange(int(np.count_nonzero(ruled)))
    turn, away, around = turn[ruled], away[:, ruled], around[:, ruled]
    slopes = np.zeros((len(n), 2 * k + 2))
    slopes[n, talker] = -turn * amplitudes[talker] * np.sin(around[talker, n])
    slopes[n, k + talker] = turn * np.cos(around[talker, n])
    slopes[:, -2] = turn * MICRO / unit
    slopes[:, -1] = 1 / bins.frequency[ruled]
    return slopes, turn * away[talker, n], bins.weight[ruled] / turn, bins.stretch[ruled]


def _parts(stretch: Real) -> list[slice]:
    """Where every stretch of which there is something begins and ends.

    >>> _parts(np.array([0.0, 0.0, 2.0]))
    [slice(0, 2, None), slice(2, 3, None)]
    """
    ends = [0, *(np.flatnonzero(np.diff(stretch)) + 1).tolist(), len(stretch)]
    return [slice(*pair) for pair in itertools.pairwise(ends)]


def _sums(slopes: Real, left: Real, weight: Real) -> tuple[Real, Real]:
    weighted = slopes * weight[:, None]
    return weighted.T @ slopes, weighted.T @ left
