"""How clean a separated group is, without knowing the truth: what the local Gaussian model expects of its own output.

Given the mixture, a group's image at microphone 1 has the posterior variance ``v_k R_k[1,1] - v_k^2 r_k^H S^-1 r_k``
with ``r_k = R_k e_1`` and ``S = sum_j v_j R_j``: the power that the Wiener output misses. The rest of the prior power
it has. Their ratio grows with the SI-SDR, which a line maps it to; recordings with known talkers gave the line.
"""

from __future__ import annotations

import numpy as np

from ross_payload.dsp.covariance import ROOT2, adjugate, determinant
from ross_payload.interfaces import Quality, Real

SLOPE = 1.37  # of the SI-SDR over the ratio, both in dB
OFFSET = -1.55  # [dB]
LEAST = 1e-12


def qualities(psds: Real, covariances: Real, bonus: float = 0.0) -> tuple[Quality, ...]:
    """Estimate SI-SDR and SI-SDRi [dB] of every group.

    Parameters
    ----------
    psds, covariances
        As of `ross_payload.dsp.gaussian.source_psds`, the noise last.
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
    missed = np.maximum(prior[:-1] - kept, LEAST)
    ratio = _db(kept / missed)
    heard = _db(prior[:-1] / np.maximum(prior.sum() - prior[:-1], LEAST))
    clean = SLOPE * ratio + OFFSET + bonus
    return tuple(Quality(float(a), float(a - b)) for a, b in zip(clean, heard, strict=True))


def _first_columns(covariances: Real) -> Real:
    """Coordinates of r r^H with r = R e_1, (..., 4)."""
    first, across = covariances[..., 0], (covariances[..., 2] - 1j * covariances[..., 3]) / ROOT2  # R11, R21
    cross = ROOT2 * first * across.conj()
    return np.stack([first**2, np.abs(across) ** 2, cross.real, cross.imag], axis=-1).astype(covariances.dtype)


def _db(ratio: Real) -> Real:
    return np.asarray(10 * np.log10(np.maximum(ratio, LEAST)))
