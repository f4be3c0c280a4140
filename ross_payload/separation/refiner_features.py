"""What the network of the separator `refined` is shown: the same few numbers about every bin of every group."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ross_payload.dsp.covariance import adjugate, determinant
from ross_payload.interfaces import Real

HIGHEST = 6000.0  # bins above this keep the PSDs of the local Gaussian model [Hz]
N_FEATURES = 10
N_IN_NOISE = N_FEATURES + 1  # the last says whether a group is the noise
SCALE = 0.2  # of logarithms: the network sees numbers around 1
LEAST, MOST = 1e-7, 1e30  # of every PSD that is shown
HIDDEN = 0.01  # of the noise: no PSD is shown, or corrected from, below it where the noise has a direction
MISFIT = 1e-3  # of a direction that fits perfectly
FAR = 8.0  # bound of logarithms of ratios
BESIDE = 2  # bins on either side that the local covariance is averaged over
WIDTHS = (6.0, 15.0)  # of bins that the network was trained for [Hz]
STEADY = 1e-5  # noise in the Wiener filter, relative to everything: no covariance is singular

Features = tuple[Real, ...]  # each (n_freqs, n_described, n_frames), or to be broadcast to it


@dataclass(frozen=True, slots=True, eq=False)
class _Groups:
    """Covariances of all groups that are described; the noise, if it is one of them, has one for every bin."""

    sources: Real  # (n_freqs, n_groups, 4)
    field: Real | None = None  # (n_freqs, 4, n_frames)

    def traces(self, others: Real) -> Real:
        """tr(R_k M) for M of every bin (n_freqs, 4, n_frames), (n_freqs, n_described, n_frames)."""
        found = self.sources @ others
        if self.field is None:
            return found
        return np.concatenate([found, (self.field * others).sum(axis=1, keepdims=True)], axis=1)

    def determinants(self) -> Real:
        """(n_freqs, n_described, 1 or n_frames)."""
        found = determinant(self.sources)[..., None]
        if self.field is None:
            return found
        noise = determinant(np.swapaxes(self.field, 1, 2))[:, None]
        return np.concatenate([np.broadcast_to(found, (*found.shape[:2], noise.shape[2])), noise], axis=1)


def features(observed: Real, covariances: Real, psds: Real) -> Features:
    """Describe every bin of every group by `N_FEATURES` numbers.

    Scaled logarithms of: the PSDs of the group, of the others and of the noise; the power of the mixture; how badly
    the direction x / |x| fits the covariance of the group; how much more likely it is than under the others'; the
    power v_k^2 x^H S^-1 R_k S^-1 x of the Wiener output; the factor by which an update would change the PSD; how badly
    the mean of x x^H over the bins around fits the covariance of the group, and how little coherent it is.

    Parameters
    ----------
    observed, covariances, psds
        As `ross_payload.separation.local_gaussian_model.fitted` returns them, the noise last.
    """
    own = psds[:, :-1]
    total = np.swapaxes(covariances, 1, 2) @ psds
    others = own.sum(axis=1, keepdims=True) - own
    return _described(observed, _Groups(covariances[:, :-1]), own, others, total=total, noise=psds[:, -1:])


def features_in_noise(observed: Real, covariances: Real, psds: Real, field: Real) -> Features:
    """The same where noise has a direction, which is one more group, the last: `N_IN_NOISE` numbers.

    The noise is not among "the others" of a talker, whom its PSD stands beside anyway.

    Parameters
    ----------
    observed, covariances, psds
        As of `features`.
    field
        Coordinates of the covariance of the noise, trace 2, (n_freqs, 4, n_frames).
    """
    talkers = psds[:, :-1]
    total = np.swapaxes(covariances[:, :-1], 1, 2) @ talkers + psds[:, -1:] * field
    every = talkers.sum(axis=1, keepdims=True)
    others = np.concatenate([every - talkers, every], axis=1)
    groups = _Groups(covariances[:, :-1], field)
    described = _described(observed, groups, psds, others, total=total, noise=psds[:, -1:])
    noise = np.zeros((1, psds.shape[1], 1), psds.dtype)
    noise[:, -1] = 1
    return (*described, noise)


def _described(observed: Real, groups: _Groups, own: Real, others: Real, *, total: Real, noise: Real) -> Features:
    inner = np.maximum(determinant(np.swapaxes(total, 1, 2)), np.finfo(own.dtype).tiny)[:, None]
    opposite = adjugate(total, axis=1)
    mixed, cross = groups.traces(opposite), groups.traces(adjugate(observed, axis=1))
    update = np.maximum((observed * opposite).sum(axis=1, keepdims=True) / inner - cross / mixed, 0)
    power = 0.5 * (observed[:, :1] + observed[:, 1:2])
    misfit = np.log(cross / (4 * power**2 + LEAST**2) * 2 * power + MISFIT)
    near = _around(observed)
    near_power = 0.5 * (near[:, :1] + near[:, 1:2])
    near_cross = groups.traces(adjugate(near, axis=1))
    near_misfit = np.log(near_cross / (4 * near_power**2 + LEAST**2) * 2 * near_power + MISFIT)
    incoherence = determinant(np.swapaxes(near, 1, 2))[:, None] / (near_power**2 + LEAST**2)
    likelihood = np.log(groups.determinants() + MISFIT) - 2 * misfit
    return (
        _log(own),
        _log(others),
        _log(noise),
        _log(power),
        SCALE * misfit,
        SCALE * _margin(likelihood),
        _log(own**2 * update * mixed / inner),
        SCALE * np.clip(np.log(update + np.float32(np.exp(-FAR))), -FAR, FAR),
        SCALE * near_misfit,
        SCALE * np.log(np.maximum(incoherence, 0) + MISFIT),
    )


def stacked(every: Features) -> Real:
    """Features in one array, (n_described, n_features, n_freqs, n_frames)."""
    n_freqs, n_described, n_frames = every[0].shape
    shown = np.empty((n_described, len(every), n_freqs, n_frames), np.float32)
    for index, feature in enumerate(every):
        shown[:, index] = np.swapaxes(feature, 0, 1)
    return shown


def _log(values: Real) -> Real:
    return np.asarray(SCALE * np.log(np.minimum(np.maximum(values, LEAST), MOST)))


def _around(observed: Real) -> Real:
    """Mean of x x^H over some neighbouring frequencies, the first axis; edges are repeated."""
    padded = np.pad(observed, ((BESIDE, BESIDE), (0, 0), (0, 0)), mode="edge")
    total = sum(padded[shift : shift + len(observed)] for shift in range(2 * BESIDE + 1))
    return np.asarray(total / np.float32(2 * BESIDE + 1))


def _margin(likelihood: Real) -> Real:
    """Log-likelihood of every group less that of the best of the others, bounded, (n_freqs, n_groups, n_frames)."""
    n_groups = likelihood.shape[1]
    if n_groups == 1:
        return np.full_like(likelihood, FAR)
    rivals = [np.delete(likelihood, group, axis=1).max(axis=1) for group in range(n_groups)]
    return np.asarray(np.clip(likelihood - np.stack(rivals, axis=1), -FAR, FAR))


def trained_for(frequencies: Real) -> bool:
    """Whether bins are as wide as those that the network knows."""
    return frequencies.size > 1 and WIDTHS[0] <= frequencies[1] - frequencies[0] <= WIDTHS[1]
