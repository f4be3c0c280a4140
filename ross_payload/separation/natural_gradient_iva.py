"""Natural-gradient IVA for two microphones, as the paper's reference uses it (Kim, Attias, Lee and Lee 2007).

Whom each output of a blind separator holds is told by the directions (`outputs_of`).
"""

from __future__ import annotations

from itertools import permutations

import numpy as np

from ross_payload.dsp.covariance import outer
from ross_payload.dsp.steering import steering_vectors
from ross_payload.dsp.stft import band
from ross_payload.interfaces import Complex, Groups, Real, Scene
from ross_payload.separation.auxiva import LOADING, TINY, coordinates, matrices, projected_back, two_sides

ITERATIONS = 200
STEP = 0.3
SILENT = 1e-6  # of the diagonal, relative to its mean over all bins
LOW, HIGH = 100.0, 6000.0  # where speech has a direction [Hz]


def demix(observed: Real, iterations: int = ITERATIONS, step: float = STEP) -> Complex:
    """Demixing rows that make two outputs independent, scaled to microphone 1 (projected back).

    W <- W + step (I - E[phi(y) y^H]) W with the score of the spherical Laplace distribution, phi(y_k)(f, t) =
    y_k(f, t) / sqrt(sum_f |y_k(f, t)|^2), on whitened observations; Kim et al., "Blind source separation exploiting
    higher-order frequency dependencies", IEEE TASLP 15(1), 2007. Row k of the expectation is w_k^H V_k W^H with
    V_k = mean_t x x^H / r_k(t), so that no output is ever formed. No update is larger than ``step`` times W, which a
    fixed step does not ensure: it diverges when one output is quiet while the other one is loud.

    Parameters
    ----------
    observed
        Coordinates of x x^H, (n_freqs, 4, n_frames).

    Returns
    -------
    ndarray
        W, (n_freqs, 2, 2): output k is W[:, k] @ x, both outputs add up to microphone 1.
    """
    n_freqs, _, n_frames = observed.shape
    heard, flat = observed.reshape(-1, n_frames), observed.reshape(n_freqs * 4, n_frames)
    demixing = whitening(observed)
    for _ in range(iterations):
        probe = coordinates(demixing).astype(observed.dtype)
        power = np.maximum(np.swapaxes(probe, 0, 1).reshape(2, -1) @ heard, TINY)
        weighted = (flat @ (1 / np.sqrt(power)).T / n_frames).reshape(n_freqs, 4, 2).astype(np.float64)
        _load(weighted)
        adjoint = np.swapaxes(demixing.conj(), 1, 2)
        moments = [demixing[:, k : k + 1] @ matrices(weighted[..., k]) @ adjoint for k in (0, 1)]
        gradient = np.eye(2) - np.concatenate(moments, axis=1)
        size = np.linalg.norm(gradient, axis=(1, 2), keepdims=True)
        demixing = demixing + step / np.maximum(size, 1) * gradient @ demixing
    return projected_back(demixing)


def whitening(observed: Real) -> Complex:
    """Matrix C^(-1/2) of every bin, C = mean_t x x^H, slightly loaded, (n_freqs, 2, 2)."""
    mean = observed.mean(axis=-1, dtype=np.float64)
    _load(mean)
    values, vectors = np.linalg.eigh(matrices(mean))
    return np.asarray((vectors / np.sqrt(values)[:, None]) @ np.swapaxes(vectors.conj(), 1, 2))


def _load(covariances: Real) -> None:
    """Add to the diagonal, in place, what keeps bins regular in which one wave or nothing at all is heard."""
    diagonal = covariances[:, :2]
    diagonal += LOADING * diagonal.sum(axis=1, keepdims=True) + SILENT * diagonal.mean(axis=(0, 1))


def outputs_of(cross: Complex, frequencies: Real, tau: Real) -> tuple[int, ...]:
    """The output that holds each group: the assignment with the largest sum of mean cos(phase - 2 pi f tau).

    Parameters
    ----------
    cross
        E[x_2 x_1*] of every output as heard by both microphones; only its phase counts, (n_freqs, n_outputs).
    frequencies
        [Hz], (n_freqs,).
    tau
        TDOA of every group [s], (n_groups,); at most as many as outputs.

    Examples
    --------
    A quarter of a cycle ahead and behind at 1 kHz:

    >>> outputs_of(np.array([[-1j, 1j]]), np.array([1000.0]), np.array([0.25e-3, -0.25e-3]))
    (1, 0)
    """
    use = band(frequencies, LOW, HIGH)
    use = use if use.any() else np.ones(frequencies.size, bool)
    size = np.abs(cross[use])
    phases = np.divide(cross[use], size, out=np.zeros_like(cross[use]), where=size > 0)
    expected = steering_vectors(frequencies[use], tau)[:, 1]
    agreement = (expected.conj().T @ phases).real
    n_groups, n_outputs = agreement.shape  # few of each: all are tried; scipy.optimize takes 20 MB
    return max(permutations(range(n_outputs), n_groups), key=lambda order: agreement[range(n_groups), order].sum())


def images_of(demixing: Complex) -> Complex:
    """E[x_2 x_1*] up to a factor of what each row of W lets through, from the columns of W^-1, (n_freqs, 2).

    >>> images_of(np.array([[[1.0, -1], [1, 1]]])).tolist()
    [[-1.0, 1.0]]
    """
    a, b, c, d = demixing.reshape(-1, 4).T
    first, second = (d, -c), (-b, a)  # columns of W^-1, times det W
    return np.stack([column[1] * np.conj(column[0]) for column in (first, second)], axis=1)


class NaturalIva:
    """The separator: two outputs, found blindly; known TDOAs only say whom each output holds."""

    name = "iva"

    def batch(self, spectrogram: Complex, scene: Scene) -> Groups:
        """Separate a recording (2, n_freqs, n_frames) into two groups."""
        members, tau = two_sides(scene)
        power = float((np.abs(spectrogram) ** 2).mean()) if spectrogram.size else 0.0
        if not members or not power > 0:
            return Groups(np.zeros((len(members), *spectrogram.shape[1:]), spectrogram.dtype), members, self.name)
        unit = spectrogram / np.float32(np.sqrt(power))
        rows = demix(outer(unit).astype(np.float32))
        order = tuple(range(len(members)))
        if tau is not None:
            order = outputs_of(images_of(rows), scene.frequencies, tau)[: len(members)]
        signals = np.stack([rows[:, k, :1] * spectrogram[0] + rows[:, k, 1:] * spectrogram[1] for k in order])
        return Groups(signals.astype(spectrogram.dtype), members, self.name)


separator = NaturalIva()
