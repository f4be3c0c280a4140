"""How clean a separated voice is: measured against the truth, and as the local Gaussian model expects of its output.

Given the mixture, a group's image at microphone 1 has the posterior variance ``v_k R_k[1,1] - v_k^2 r_k^H S^-1 r_k``
with ``r_k = R_k e_1`` and ``S = sum_j v_j R_j``: the power that the Wiener output misses. The rest of the prior power
it has. Their ratio grows with the SI-SDR, which a line maps it to; recordings with known talkers gave the line.
"""

from __future__ import annotations

import numpy as np

from ross_payload.dsp.covariance import ROOT2, adjugate, determinant
from ross_payload.errors import AudioError
from ross_payload.interfaces import Quality, Real

SLOPE = 1.37  # of the SI-SDR over the ratio, both in dB
OFFSET = -1.55  # [dB]
LEAST = 1e-12
FINEST = 1e-6  # of a power, below which single precision does not tell what a difference is


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


def qualities(psds: Real, covariances: Real, bonus: float = 0.0) -> tuple[Quality, ...]:
    """Estimate SI-SDR and SI-SDRi [dB] of every group.

    Parameters
    ----------
    psds, covariances
        As of `ross_payload.separation.local_gaussian_model.source_psds`, the noise last.
    bonus
        By how much the output is better than that of the local Gaussian model alone [dB].
    """
    columns = _first_columns(covariances[:, :-1])
    total = np.swapaxes(covariances, 1, 2) @ psds
    tiny = np.finfo(psds.dtype).tiny
    explained = columns @ adjugate(total, axis=1) / np.maximum(determinant(np.swapaxes(total, 1, 2)), tiny)[:, None]
    powers = psds * covariances[:, :, :1]
    prior = powers.sum(axis=(0, 2), dtype=float)
    kept = (psds[:, :-1] ** 2 * explained).sum(axis=(0, 2), dtype=float)
    kept = np.nan_to_num(kept, nan=0.0, posinf=0.0, neginf=0.0)  # of what has no inverse nothing
    kept = np.clip(kept, 0.0, prior[:-1])
    missed = np.maximum(prior[:-1] - kept, FINEST * prior[:-1] + LEAST)
    ratio = _db(kept / missed)
    heard = _db(prior[:-1] / np.maximum(prior.sum() - prior[:-1], LEAST))
    clean = SLOPE * ratio + OFFSET + bonus
    return tuple(Quality(float(a), float(a - b)) for a, b in zip(clean, heard, strict=True))


def _centred(signal: Real, name: str) -> Real:
    values = np.asarray(signal, np.float64)
    if values.ndim != 1 or not values.size:
        raise AudioError(f"SI-SDR {name}: expected one channel with samples, got shape {values.shape}")
    if not np.isfinite(values).all():
        raise AudioError(f"SI-SDR {name}: expected finite samples, got NaN or infinity")
    values = np.ldexp(values, -np.frexp(np.abs(values).max())[1])  # exact, and no square overflows or is 0
    centred = values - values.mean()
    if np.abs(centred).max() <= 1e-12 * np.abs(values).max():
        raise AudioError(f"SI-SDR {name}: expected sound, got silence")
    return np.asarray(centred)


def _first_columns(covariances: Real) -> Real:
    """Coordinates of r r^H with r = R e_1, (..., 4)."""
    first, across = covariances[..., 0], (covariances[..., 2] - 1j * covariances[..., 3]) / ROOT2  # R11, R21
    cross = ROOT2 * first * across.conj()
    return np.stack([first**2, np.abs(across) ** 2, cross.real, cross.imag], axis=-1).astype(covariances.dtype)


def _db(ratio: Real) -> Real:
    return np.asarray(10 * np.log10(np.maximum(ratio, LEAST)))
