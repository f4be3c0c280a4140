"""AuxIVA for two microphones and two groups, with closed-form updates."""

from __future__ import annotations

import numpy as np

from ross_payload.dsp.covariance import ROOT2, adjugate, determinant, outer
from ross_payload.dsp.noise import guessed_psd
from ross_payload.dsp.smoothing import average
from ross_payload.dsp.steering import ALIAS, groups_of, steering_vectors
from ross_payload.dsp.stft import band
from ross_payload.interfaces import Complex, Groups, Real, Scene

ITERATIONS = 20
LOW, HIGH = 100.0, 6000.0  # the contrast hears speech only [Hz]
LOADING = 1e-4  # of the diagonal, relative to the trace
PARALLEL = 1e-9  # rows with less of a determinant tell nothing apart
TINY = 1e-12  # smallest power, relative to the mean


def demix(observed: Real, use: Real, start: Complex, iterations: int = ITERATIONS) -> Complex:
    """Demixing rows that make two outputs independent, scaled to microphone 1 (projected back).

    Auxiliary-function IVA (Ono 2011) with the time-varying Gaussian contrast: per iteration the variance of each
    output, r_k(t), is its mean power over the bins in use; V_k(f) = mean_t x x^H / r_k(t); the two rows of a bin are
    the generalised eigenvectors of (V_1, V_2), as in Ono's stereo case (2012).

    Parameters
    ----------
    observed
        Coordinates of x x^H, (n_freqs, 4, n_frames).
    use
        Bins that the contrast hears, (n_freqs,).
    start
        Demixing matrix to begin with, (n_freqs, 2, 2).

    Returns
    -------
    ndarray
        W, (n_freqs, 2, 2): output k is W[:, k] @ x, both outputs add up to microphone 1.
    """
    n_freqs, _, n_frames = observed.shape
    weight = (use / use.sum()).astype(observed.dtype)
    heard, flat = observed.reshape(-1, n_frames), observed.reshape(n_freqs * 4, n_frames)
    demixing = projected_back(start)
    for _ in range(iterations):
        probe = coordinates(demixing).astype(observed.dtype) * weight[:, None, None]
        variance = np.maximum(np.swapaxes(probe, 0, 1).reshape(2, -1) @ heard, TINY)
        weighted = (flat @ (1 / variance).T / n_frames).reshape(n_freqs, 4, 2)
        demixing = projected_back(_closed_form(weighted.astype(np.float64)))
    return demixing


def projected_back(demixing: Complex) -> Complex:
    """Scale the rows of W so that the outputs are what microphone 1 hears: row k times (W^-1)_1k (Matsuoka 2001).

    >>> projected_back(np.array([[[2.0, -2], [0, 5]]]))[0].tolist()
    [[1.0, -1.0], [0.0, 1.0]]
    """
    a, b, c, d = demixing.reshape(-1, 4).T
    scale = np.stack([d, -b], axis=-1)
    return demixing * (scale / (a * d - b * c)[:, None])[:, :, None]


def start_from(frequencies: Real, tau: Real | None) -> Complex:
    """Demixing matrix that nulls each of two directions in the other output, or the identity when tau is None."""
    if tau is None:
        return np.broadcast_to(np.eye(2, dtype=complex), (frequencies.size, 2, 2))
    mixing = steering_vectors(frequencies, tau)
    mixing[:, 1] *= np.array([1.0, 1.0]) + 0.1 * np.array([1.0, -1.0])  # never singular, also at 0 Hz
    return np.linalg.inv(mixing)


def coordinates(rows: Complex) -> Real:
    """Coordinates m of each row u with |u x|^2 = m . (coordinates of x x^H), (n_freqs, 2, 4)."""
    first, second = rows[..., 0], rows[..., 1]
    cross = ROOT2 * first.conj() * second
    return np.stack([np.abs(first) ** 2, np.abs(second) ** 2, cross.real, cross.imag], axis=-1)


def _closed_form(weighted: Real) -> Complex:
    """Rows w_k^H from V_k (n_freqs, 4, 2): eigenvectors of V_2^-1 V_1, the smaller eigenvalue first."""
    trace = weighted[:, 0] + weighted[:, 1]
    weighted[:, :2] += LOADING * trace[:, None] + np.finfo(float).tiny
    one, two = matrices(weighted[..., 0]), matrices(adjugate(weighted[..., 1]))
    product = two @ one / determinant(weighted[..., 1])[:, None, None]
    half = 0.5 * (product[:, 0, 0] + product[:, 1, 1]).real
    root = np.sqrt(np.maximum(half**2 - _determinants(product).real, 0))
    rows = [_eigenvector(product, half - root).conj(), _eigenvector(product, half + root).conj()]
    demixing = np.stack(rows, axis=1)
    sizes = np.sqrt((np.abs(demixing) ** 2).sum(axis=-1)).prod(axis=-1)
    parallel = np.abs(_determinants(demixing)) <= PARALLEL * sizes
    return np.where(parallel[:, None, None], np.eye(2), demixing)


@np.errstate(divide="ignore", invalid="ignore")  # flags that OpenBLAS for arm64 sets, where matrices are real
def _determinants(of: Complex) -> Complex:
    return np.asarray(np.linalg.det(of))


def matrices(hermitian: Real) -> Complex:
    """Write matrices given by their four coordinates (n, 4) in full, (n, 2, 2).

    >>> matrices(np.array([[1.0, 2.0, 0.0, 2**0.5]])).round(6).tolist()
    [[[(1+0j), 1j], [-1j, (2+0j)]]]
    """
    cross = (hermitian[:, 2] + 1j * hermitian[:, 3]) / ROOT2
    rows = [[hermitian[:, 0] + 0j, cross], [cross.conj(), hermitian[:, 1] + 0j]]
    return np.moveaxis(np.array(rows), -1, 0)


def _eigenvector(matrix: Complex, value: Real) -> Complex:
    """Eigenvector of 2 x 2 matrices (n, 2, 2), from the better conditioned of both rows, (n, 2)."""
    upper = np.stack([matrix[:, 0, 1], value - matrix[:, 0, 0]], axis=-1)
    lower = np.stack([value - matrix[:, 1, 1], matrix[:, 1, 0]], axis=-1)
    better = (np.abs(upper) ** 2).sum(-1) >= (np.abs(lower) ** 2).sum(-1)
    return np.where(better[:, None], upper, lower)


class Auxiva:
    """The separator: two outputs; from known TDOAs it starts there and says whom each output holds."""

    name = "auxiva"

    def batch(self, spectrogram: Complex, scene: Scene) -> Groups:
        """Separate a recording (2, n_freqs, n_frames) into two groups, with a Wiener gain against the noise."""
        members, tau = two_sides(scene)
        power = float((np.abs(spectrogram) ** 2).mean()) if spectrogram.size else 0.0
        if not scene.n_sources or not power > 0:
            return Groups(np.zeros((len(members), *spectrogram.shape[1:]), spectrogram.dtype), members, self.name)
        unit = spectrogram / np.float32(np.sqrt(power))
        use = band(scene.frequencies, LOW, HIGH).astype(float)
        use = use if use.any() else np.ones(scene.frequencies.size)
        observed = outer(unit).astype(np.float32)
        rows = demix(observed, use, start_from(scene.frequencies, tau))
        noise = scene.noise_psd / power if scene.noise_psd is not None else guessed_psd(unit)
        outputs = np.stack([(rows[:, k, :1] * unit[0] + rows[:, k, 1:] * unit[1]) for k in range(len(members))])
        leak = noise[None, :] * (np.abs(rows) ** 2).sum(axis=-1).T[: len(members)]
        gains = np.stack([_gain(output, noisy) for output, noisy in zip(outputs, leak, strict=True)])
        signals = (outputs * gains * np.sqrt(power)).astype(spectrogram.dtype)
        return Groups(signals, members, self.name, masks=gains)


def _gain(output: Complex, noise_psd: Real) -> Real:
    power = np.maximum(average(np.abs(output) ** 2), TINY)
    return np.asarray(np.maximum(1 - noise_psd[:, None] / power, 0))


def two_sides(scene: Scene) -> tuple[tuple[tuple[int, ...], ...], Real | None]:
    """Members of both outputs and the TDOAs to begin with: the tau axis is cut at its widest gap."""
    if scene.tau is None or scene.n_sources == 0:
        return tuple(() for _ in range(min(scene.n_sources, 2))), None
    tau = np.asarray(scene.tau, float)
    longest = scene.spacing / scene.speed_of_sound
    if len(groups_of(tau, ALIAS * longest)) == 1:
        centre = float(tau.mean())
        return (tuple(range(tau.size)),), np.array([centre, centre - np.copysign(longest, centre)])
    order = np.argsort(tau, kind="stable")
    cut = int(np.diff(tau[order]).argmax()) + 1
    sides = sorted(tuple(sorted(int(i) for i in part)) for part in (order[:cut], order[cut:]))
    return tuple(sides), np.array([tau[list(side)].mean() for side in sides])


separator = Auxiva()
