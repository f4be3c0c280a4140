"""How good a separation is."""

from __future__ import annotations

import numpy as np

from ross_payload.errors import AudioError
from ross_payload.interfaces import Real


def si_sdr(estimate: Real, reference: Real) -> float:
    """Scale-invariant signal-to-distortion ratio [dB], on zero-mean signals.

    10 log10(|a s|^2 / |a s - e|^2) with a = <e, s> / |s|^2; Le Roux et al., "SDR - half-baked or well done?",
    ICASSP 2019, Eq. (3).

    Parameters
    ----------
    estimate, reference
        e and s, (n_samples,).

    Returns
    -------
    float
        inf for a scaled copy of the reference, -inf for an estimate without any of it.

    Raises
    ------
    AudioError
        When the lengths differ, a sample is not finite, or one of them is silent (constant).

    Examples
    --------
    Error and signal orthogonal, the error a tenth in amplitude:

    >>> s, e = np.array([1.0, -1, 1, -1]), np.array([1.0, 1, -1, -1])
    >>> round(si_sdr(s + 0.1 * e, s), 6)
    20.0
    """
    e, s = (_centred(signal, name) for signal, name in ((estimate, "estimate"), (reference, "reference")))
    if e.shape != s.shape:
        raise AudioError(f"SI-SDR: expected an estimate of {s.size} samples, as the reference has, got {e.size}")
    target = (e @ s) / (s @ s) * s
    with np.errstate(divide="ignore"):
        return float(10 * np.log10((target @ target) / np.float64((target - e) @ (target - e))))


def si_sdri(estimate: Real, mixture: Real, reference: Real) -> float:
    """Improvement of the SI-SDR [dB] of the estimate over the mixture, both (n_samples,).

    >>> s, e = np.array([1.0, -1, 1, -1]), np.array([1.0, 1, -1, -1])
    >>> round(si_sdri(s + 0.1 * e, s + e, s), 6)
    20.0
    """
    return si_sdr(estimate, reference) - si_sdr(mixture, reference)


def _centred(signal: Real, name: str) -> Real:
    values = np.asarray(signal, np.float64)
    if values.ndim != 1 or not values.size:
        raise AudioError(f"SI-SDR {name}: expected one channel with samples, got shape {values.shape}")
    if not np.isfinite(values).all():
        raise AudioError(f"SI-SDR {name}: expected finite samples, got NaN or infinity")
    centred = values - values.mean()
    if np.abs(centred).max() <= 1e-12 * np.abs(values).max():
        raise AudioError(f"SI-SDR {name}: expected sound, got silence")
    return np.asarray(centred)
