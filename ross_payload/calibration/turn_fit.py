"""One source at rest, heard at many headings: the delays of the whole turn lie on one sinusoid.

At heading phi the microphones hear a source at azimuth theta with the delay
``tau = (d / v_p) cos(theta - phi) + tau_0``: the amplitude is the spacing, the phase the azimuth, and tau_0 a delay
between the converters. All bins of all headings are explained at once,

    Gamma(f, phi) = s e^{j (2 pi f tau_0 + arctan(f_0 / f))} (rho(f) e^{j 2 pi f (tau - tau_0)} + kappa(f)),

with the polarity s = +-1, a share rho of direct sound, and a share kappa of sound from all sides, which is the same at
all headings; both are constant over bands. f_0 is how much higher microphone 2 rolls off at low frequencies. Delays
beyond half a period are no harm, since one sinusoid explains all frequencies.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.fft import next_fast_len

from ross_payload.angles import difference
from ross_payload.calibration.cross_spectrum import HeadingSpectrum
from ross_payload.interfaces import Complex, Real

BANDS = 8  # in which the shares are constant
DAMPING = 0.02  # of the share from all sides, as a part of all weight: after a small turn it looks like direct sound
FINE = 16  # steps of the delay per sample in the search
AMPLITUDES = 64  # tried in the search
AZIMUTHS = np.arange(180) * np.pi / 90  # tried there [rad]
TINY = 1e-12
DELAYS = np.arange(-4, 5) * 3e-5  # between the converters, tried in the search [s]
ELSEWHERE = np.deg2rad(20.0)  # from a source: another one [rad]
SCALE = 1e-6  # of the parameters that are delays [s]
HERTZ = 10.0  # scale of the roll-off
SCALES = np.array([SCALE, SCALE, SCALE, HERTZ])
STEP = 0.05  # of the differences, in the scales of the parameters


@dataclass(frozen=True, slots=True)
class Turn:
    """What was heard at all headings of a turn."""

    headings: Real  # [rad], (n_headings,)
    frequencies: Real  # [Hz], (n_freqs,)
    phase: Complex  # (n_headings, n_freqs)
    weight: Real  # (n_headings, n_freqs)
    level_db: Real  # (n_headings, n_freqs)

    @classmethod
    def of(cls, spectra: Sequence[HeadingSpectrum]) -> Turn:
        """Put together what was heard at every heading."""
        return cls(
            np.array([each.heading for each in spectra]),
            spectra[0].frequencies,
            np.stack([each.phase for each in spectra]),
            np.stack([each.weight for each in spectra]),
            np.stack([each.level_db for each in spectra]),
        )

    def pooled(self, bins: int) -> Turn:
        """The same with fewer frequencies: each stands for so many neighbours, those left over at the top for none.

        The phase is their weighted mean, of a modulus below 1 where they disagree; a delay tau turns it by
        ``2 pi tau`` times their distance, and shortens it by what a mean over that arc is shorter.
        """
        n = len(self.frequencies) // bins

        def groups(values: NDArray[Any]) -> NDArray[Any]:
            return values[..., : n * bins].reshape(*values.shape[:-1], n, bins)

        weight = groups(self.weight)
        whole = weight.sum(axis=-1)
        phase, level = ((weight * groups(each)).sum(axis=-1) / (whole + TINY) for each in (self.phase, self.level_db))
        return Turn(self.headings, groups(self.frequencies).mean(axis=-1), phase, whole, level)


@dataclass(frozen=True, slots=True)
class TurnFit:
    """The sinusoid that explains a turn."""

    amplitude: float  # d / v_p cos(elevation) [s]
    azimuth: float  # of the source, in the frame of the headings [rad]
    delay: float  # of microphone 2 before microphone 1, whatever the heading [s]
    roll_off: float  # of microphone 2 above that of microphone 1 [Hz]
    inverted: bool  # the microphones have opposite polarity
    direct: float  # share of direct sound in what both have in common, 0 to 1
    bands: Real  # the same in every band, (n_bands,)
    diffuse: Real  # share of what is the same at all headings in every band, (n_bands,)
    covariance: Real  # of amplitude [s], azimuth [rad], delay [s] and roll-off [Hz], (4, 4)


def fit(turn: Turn, widest: float, *, free: bool = True) -> TurnFit:
    """Find the sinusoid that explains most of a turn.

    Parameters
    ----------
    turn
        Headings that reach over a third of a turn at least.
    widest
        The largest amplitude to be looked for [s].
    free
        Whether a delay between the converters and a difference of roll-off are looked for; after a small turn they
        cannot be told from the rest.
    """
    start, inverted = _search(turn, widest, free_delay=free)
    model = _Model(turn, -1.0 if inverted else 1.0)
    best = _descend(model, start, 4 if free else 2)
    covariance = _covariance(model, best, 4 if free else 2)
    direct, diffuse, total = model.shares(best)
    a, b, delay, roll_off = best * SCALES
    amplitude = float(np.hypot(a, b))
    turned = np.eye(4)
    turned[:2, :2] = [[a / amplitude, b / amplitude], [-b / amplitude**2, a / amplitude**2]]
    return TurnFit(
        amplitude, float(np.arctan2(b, a)), float(delay), float(roll_off), inverted,
        direct=float((direct * total).sum() / total.sum()), bands=direct, diffuse=diffuse,
        covariance=turned @ (covariance * np.outer(SCALES, SCALES)) @ turned.T,
    )  # fmt: skip


class Steered:
    """How much of a turn a source with given delays explains, from a table of delays; a part of ``phase`` is looked at.

    Parameters
    ----------
    turn
        Weights, frequencies and headings.
    phase
        That of the turn, or what is left of it, (n_headings, n_freqs).
    """

    def __init__(self, turn: Turn, phase: Complex) -> None:
        apart = turn.frequencies[1] - turn.frequencies[0]
        first = round(turn.frequencies[0] / apart)
        size = next_fast_len(2 * FINE * (first + len(turn.frequencies)), real=True)
        self._step, self._half = 1 / (size * apart), size // 2
        self._curves = []
        for heard, weight in zip(phase, turn.weight, strict=True):
            spectrum = np.zeros(self._half + 1, complex)
            spectrum[first : first + len(heard)] = (weight * heard).conj() / (weight.sum() + TINY)
            self._curves.append(np.fft.fftshift(np.fft.irfft(spectrum, size) * size / 2))

    def share(self, delays: Real) -> Real:
        """Share of the weight that such a source explains, mean over the headings; delays (n_headings, n) [s]."""
        total = np.zeros(delays.shape[1])
        for curve, wanted in zip(self._curves, delays, strict=True):
            place = wanted / self._step + self._half
            left = place.astype(int)
            total += curve[left] + (place - left) * (curve[left + 1] - curve[left])
        return total / len(delays)


def second_source(turn: Turn, found: TurnFit) -> tuple[float, float]:
    """Share of the weight that another source at rest explains best of what a fit leaves, and its azimuth [rad]."""
    away = AZIMUTHS[np.abs(difference(AZIMUTHS, found.azimuth)) > ELSEWHERE]
    delays = found.amplitude * np.cos(away - turn.headings[:, None]) + found.delay
    shares = Steered(turn, _left_over(turn, found)).share(delays) * (-1 if found.inverted else 1)
    return float(shares.max()), float(away[shares.argmax()])


def _left_over(turn: Turn, found: TurnFit) -> Complex:
    """What a fit does not explain, (n_headings, n_freqs)."""
    model = _Model(turn, -1.0 if found.inverted else 1.0)
    a, b = np.cos(found.azimuth) * found.amplitude, np.sin(found.azimuth) * found.amplitude
    return np.asarray(turn.phase - model.modelled(np.array([a, b, found.delay, found.roll_off]) / SCALES))


def _search(turn: Turn, widest: float, *, free_delay: bool) -> tuple[Real, bool]:
    """Try amplitudes, azimuths and delays on a grid; the best, [SCALE], and whether the polarity is reversed."""
    steered, best, found = Steered(turn, turn.phase), 0.0, (0.0, 0.0, 0.0)
    cosines = np.cos(AZIMUTHS - turn.headings[:, None])
    for delay in DELAYS if free_delay else (0.0,):
        for amplitude in widest * np.arange(1, AMPLITUDES + 1) / AMPLITUDES:
            shares = steered.share(amplitude * cosines + delay)
            place = int(np.abs(shares).argmax())
            if abs(shares[place]) > abs(best):
                best, found = float(shares[place]), (float(amplitude), float(AZIMUTHS[place]), float(delay))
    amplitude, azimuth, delay = found
    return np.array([amplitude * np.cos(azimuth), amplitude * np.sin(azimuth), delay, 0.0]) / SCALES, best < 0


class _Model:
    """The misfit of a turn for any sinusoid.

    Parameters are a, b of ``a cos(phi) + b sin(phi)``, tau_0 and f_0, in `SCALES`.
    """

    def __init__(self, turn: Turn, sign: float) -> None:
        self.turn, self.sign = turn, sign
        n = len(turn.frequencies)
        self.band = np.arange(n) * BANDS // n
        self._omega = 2 * np.pi * turn.frequencies * SCALE
        self._directions = np.stack([np.cos(turn.headings), np.sin(turn.headings)], axis=1)
        self._total = self._by_band(turn.weight.sum(axis=0))

    def shares(self, at: Real) -> tuple[Real, Real, Real]:
        """Direct share, share from all sides, and weight of every band, (n_bands,) each."""
        wave, heard = self._wave(at), self._unshifted(at)
        weight = self.turn.weight
        direct = self._by_band((weight * (heard * wave.conj()).real).sum(axis=0))
        same = self._by_band((weight * heard.real).sum(axis=0))
        both = self._by_band((weight * wave.real).sum(axis=0))
        total = self._total + TINY
        damped = total * (1 + DAMPING)
        share = np.clip((damped * direct - both * same) / (total * damped - both**2), 0.0, 1.0)
        return share, (same - both * share) / damped, total

    def modelled(self, at: Real) -> Complex:
        """What the model says with its best shares, (n_headings, n_freqs)."""
        direct, diffuse, _ = self.shares(at)
        modelled = direct[self.band] * self._wave(at) + diffuse[self.band]
        return np.asarray(self._shift(at) * modelled)

    def misfits(self, at: Real, shares: tuple[Real, Real, Real]) -> Real:
        """Squared residuals at every heading with these shares, (n_headings,)."""
        modelled = shares[0][self.band] * self._wave(at) + shares[1][self.band]
        return np.asarray((self.turn.weight * np.abs(self._unshifted(at) - modelled) ** 2).sum(axis=1))

    def misfit(self, at: Real) -> float:
        """Squared residuals with the best shares, and the price of the share from all sides."""
        shares = self.shares(at)
        return float(self.misfits(at, shares).sum() + DAMPING * (shares[2] * shares[1] ** 2).sum())

    def _wave(self, at: Real) -> Complex:
        return np.asarray(np.exp(1j * np.outer(self._directions @ at[:2], self._omega)))

    def _unshifted(self, at: Real) -> Complex:
        return np.asarray(self.turn.phase * self._shift(at).conj())

    def _shift(self, at: Real) -> Complex:
        """What polarity, delay and roll-off do to the phase at all headings, (n_freqs,)."""
        corner = np.arctan(at[3] * HERTZ / self.turn.frequencies)
        return np.asarray(self.sign * np.exp(1j * (self._omega * at[2] + corner)))

    def _by_band(self, values: Real) -> Real:
        return np.asarray(np.bincount(self.band, values, BANDS), dtype=float)


def _descend(model: _Model, start: Real, free: int) -> Real:
    """The parameters of the least misfit near ``start``; the first ``free`` of them vary."""
    from scipy.optimize import minimize  # noqa: PLC0415  half a second to import, for one command

    def misfit(part: Real) -> float:
        return model.misfit(np.concatenate([part, start[free:]]))

    corners = start[:free] + np.vstack([np.zeros(free), np.eye(free)])
    found = minimize(
        misfit,
        start[:free],
        method="Nelder-Mead",
        options={"initial_simplex": corners, "xatol": 1e-3, "fatol": 1e-6},
    )
    return np.concatenate([found.x, start[free:]])


def _covariance(model: _Model, best: Real, free: int) -> Real:
    """Covariance of the parameters in `SCALES` that allows for errors which all bins of one heading share (White 1980).

    ``H^-1 (sum_i g_i g_i^T) H^-1 n / (n - free)``: g_i the gradient of each heading's misfit, H the Hessian of all.
    """
    shares, n = model.shares(best), len(model.turn.headings)
    steps = np.eye(4)[:free] * STEP
    slopes = [(model.misfits(best + h, shares) - model.misfits(best - h, shares)) / (2 * STEP) for h in steps]
    gradients = np.stack(slopes, axis=1)
    hessian = np.empty((free, free))
    for i, one in enumerate(steps):
        for j, other in enumerate(steps):
            ends = [model.misfit(best + s * one + t * other) * s * t for s in (1, -1) for t in (1, -1)]
            hessian[i, j] = sum(ends) / (4 * STEP**2)
    inverse = np.linalg.pinv(hessian)
    covariance = np.zeros((4, 4))
    covariance[:free, :free] = inverse @ gradients.T @ gradients @ inverse * n / max(n - free, 1)
    return covariance
