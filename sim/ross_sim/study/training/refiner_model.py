"""The refiner as a differentiable function: network, multichannel Wiener filter, loss.

``xp`` is ``jax.numpy`` for training; numpy does as well, without derivatives.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ross_payload.interfaces import Real
from ross_payload.separation.network import COLUMNS, LIMIT, PLACES, ROWS, STEPS
from ross_payload.separation.refiner_features import N_FEATURES, N_IN_NOISE, SCALE, STEADY

CLIPPED, QUIET = 1e-3, 3e-3  # error that counts as none, and of a group that is silent, relative to its power


def initial(n_channels: int, n_blocks: int, n_last: int, rng: np.random.Generator) -> dict[str, Real]:
    """Random weights by name as `ross_payload.separation.network.network_of` reads them; the output starts near 0."""
    n_in, n_out, c, h = N_FEATURES * ROWS * COLUMNS + PLACES, ROWS * COLUMNS, n_channels, n_last
    weights = {"in": rng.normal(0, np.sqrt(2 / n_in), (c, n_in)), "in_b": np.zeros((c, 1))}
    weights |= {"hid": rng.normal(0, np.sqrt(1 / c), (h, c)), "see": rng.normal(0, np.sqrt(1 / n_in), (h, n_in))}
    weights |= {"hid_b": np.zeros((h, 1)), "out": rng.normal(0, 0.01, (n_out, h))}
    weights |= {"skip": np.zeros((n_out, n_in)), "out_b": np.zeros((n_out, 1))}
    for i in range(n_blocks):
        weights[f"f{i}"] = rng.normal(0, np.sqrt(1 / (3 * c)), (3 * c, c))
        weights[f"o{i}"] = rng.normal(0, np.sqrt(0.5 / c), (c, c))
        weights[f"c{i}"] = rng.normal(0, np.sqrt(0.5 / c), (c, c))
        weights[f"b{i}"] = np.zeros((c, 1))
        weights[f"t{i}"] = rng.normal(0, 0.3 * np.sqrt(2 / (3 * c)), (3 * c, c))
        weights[f"d{i}"] = np.zeros((c, 1))
    return {name: np.asarray(array, np.float32) for name, array in weights.items()}


def widened(weights: Mapping[str, Real]) -> dict[str, Real]:
    """Weights that see what is shown in noise, and make of it what they made without: new inputs weigh nothing."""
    each, before = ROWS * COLUMNS, N_FEATURES * ROWS * COLUMNS
    new = each * (N_IN_NOISE - N_FEATURES)
    found = {name: np.asarray(array, np.float32) for name, array in weights.items()}
    for name in ("in", "see", "skip"):
        array = found[name]
        found[name] = np.hstack([array[:, :before], np.zeros((len(array), new), np.float32), array[:, before:]])
    return found


def corrections(xp: Any, weights: Mapping[str, Any], shown: Any, where: Any, ahead: Any = 1.0) -> Any:
    """Log PSD corrections as `ross_payload.separation.network.Network.corrections`; whole patches only.

    Channels come first here, so that every matrix product is one for all groups.

    Parameters
    ----------
    shown
        (n_groups, N_FEATURES, n_freqs, n_frames).
    where
        `ross_payload.separation.network.places`, (PLACES, n_freqs / ROWS).
    ahead
        1: what follows is known; 0: it is not, as in `ross_payload.separation.network.Network.advance`.
    """
    n_groups, n_features, n_freqs, n_frames = shown.shape
    rows, columns = n_freqs // ROWS, n_frames // COLUMNS
    split = shown.reshape(n_groups, n_features, rows, ROWS, columns, COLUMNS).transpose(1, 3, 5, 0, 2, 4)
    same = xp.broadcast_to(where[:, None, :, None], (len(where), n_groups, rows, columns))
    patches = xp.concatenate([split.reshape(-1, n_groups, rows, columns), same], axis=0)
    hidden = xp.maximum(_mix(weights["in"], patches) + weights["in_b"][..., None, None], 0)
    for i, step in enumerate(STEPS[: sum(name.startswith("f") for name in weights)]):
        hidden = hidden + _residual(xp, {part: weights[f"{part}{i}"] for part in "focbtd"}, step, hidden, ahead)
    last = _mix(weights["hid"], hidden) + _mix(weights["see"], patches) + weights["hid_b"][..., None, None]
    out = _mix(weights["out"], xp.maximum(last, 0)) + _mix(weights["skip"], patches)
    out = LIMIT * xp.tanh((out + weights["out_b"][..., None, None]) / LIMIT)
    bins = out.reshape(ROWS, COLUMNS, n_groups, rows, columns).transpose(2, 3, 0, 4, 1)
    return bins.reshape(n_groups, n_freqs, n_frames)


def filtered(xp: Any, log_psds: Any, covariances: Any, noise: Any, mixture: Any) -> Any:
    """Multichannel Wiener output at microphone 1 in real numbers, (2, n_groups, n_freqs, n_frames).

    The determinant is a sum of what is positive, so that single precision is enough: det(sum_j v_j R_j) =
    sum_jk v_j v_k tr(R_j adj R_k) / 2.

    Parameters
    ----------
    log_psds
        (n_groups, n_freqs, n_frames).
    covariances
        Coordinates, trace 2, the noise last, (n_freqs, n_groups + 1, 4).
    noise
        (n_freqs,).
    mixture
        Real and imaginary part, (2, 2 microphones, n_freqs, n_frames).
    """
    psds, n = [xp.exp(row) for row in log_psds], xp.maximum(noise, STEADY)[:, None]
    parts = [[covariances[:, k, i, None] for i in range(4)] for k in range(len(psds))]
    h11, h22, real, imag = (sum(v * part[i] for v, part in zip(psds, parts, strict=True)) for i in range(4))
    h11, h22, determinant = h11 + n, h22 + n, n**2
    for k, (v, own) in enumerate(zip(psds, parts, strict=True)):
        determinant = determinant + 2 * n * v + 0.5 * _gram(xp, own, own) * v**2
        for w, other in zip(psds[:k], parts[:k], strict=True):
            determinant = determinant + _gram(xp, own, other) * v * w
    return _wiener(xp, zip(psds, parts, strict=True), (h11, h22, real, imag), determinant, mixture)


def _wiener(xp: Any, groups: Any, total: Any, determinant: Any, mixture: Any) -> Any:
    """What every group (PSD, covariance) has of a mixture whose covariance is ``total``, with this determinant."""
    h11, h22, real, imag = total
    (r1, r2), (i1, i2) = mixture
    real, imag = -real / np.sqrt(2), -imag / np.sqrt(2)
    first = (h22 * r1 + real * r2 - imag * i2) / determinant, (h22 * i1 + real * i2 + imag * r2) / determinant
    second = (real * r1 + imag * i1 + h11 * r2) / determinant, (real * i1 - imag * r1 + h11 * i2) / determinant
    signals = []
    for v, (a, _, b, c) in groups:
        across = b / np.sqrt(2), c / np.sqrt(2)
        out_real = v * (a * first[0] + across[0] * second[0] - across[1] * second[1])
        out_imag = v * (a * first[1] + across[0] * second[1] + across[1] * second[0])
        signals.append(xp.stack([out_real, out_imag]))
    return xp.stack(signals, axis=1)


def loss(xp: Any, weights: Mapping[str, Any], batch: Any, ahead: Any = 1.0) -> Any:
    """Mean over the groups of the error over the wanted signal at microphone 1 [dB], bounded at -30 dB."""
    shown, where, covariances, noise, mixture, wanted = batch
    log_psds = shown[:, 0] / SCALE + corrections(xp, weights, shown, where, ahead)
    error = ((filtered(xp, log_psds, covariances, noise, mixture) - wanted) ** 2).sum(axis=(0, 2, 3))
    power, heard = (wanted**2).sum(axis=(0, 2, 3)), (mixture[:, 0] ** 2).sum()
    return 10 * xp.log10((error + CLIPPED * power + 1e-4 * heard) / (power + QUIET * heard)).mean()


def filtered_in_noise(xp: Any, log_psds: Any, covariances: Any, field: Any, mixture: Any) -> Any:
    """As `filtered`, where the noise, the last of the PSDs, has a covariance in every bin.

    Parameters
    ----------
    log_psds
        The noise last, (n_groups + 1, n_freqs, n_frames).
    covariances
        Coordinates, trace 2, (n_freqs, n_groups, 4).
    field
        Coordinates of the covariance of the noise, trace 2, (n_freqs, 4, n_frames).
    mixture
        Real and imaginary part, (2, 2 microphones, n_freqs, n_frames).
    """
    psds = [xp.exp(row) for row in log_psds]
    parts = [[covariances[:, k, i, None] for i in range(4)] for k in range(len(psds) - 1)]
    parts.append([field[:, i] for i in range(4)])
    psds[-1] = xp.maximum(psds[-1], STEADY * (1 + sum(psds[:-1])))
    h11, h22, real, imag = (sum(v * part[i] for v, part in zip(psds, parts, strict=True)) for i in range(4))
    determinant = 0.0
    for k, (v, own) in enumerate(zip(psds, parts, strict=True)):
        determinant = determinant + 0.5 * _gram(xp, own, own) * v**2
        for w, other in zip(psds[:k], parts[:k], strict=True):
            determinant = determinant + _gram(xp, own, other) * v * w
    return _wiener(xp, zip(psds[:-1], parts[:-1], strict=True), (h11, h22, real, imag), determinant, mixture)


def loss_in_noise(xp: Any, weights: Mapping[str, Any], batch: Any, ahead: Any = 1.0) -> Any:
    """As `loss` of what was divided by the level of the noise and is multiplied by it again."""
    shown, where, covariances, field, level, mixture, wanted = batch
    log_psds = shown[:, 0] / SCALE + corrections(xp, weights, shown, where, ahead)
    error = (((filtered_in_noise(xp, log_psds, covariances, field, mixture) - wanted) * level) ** 2).sum(axis=(0, 2, 3))
    power = ((wanted * level) ** 2).sum(axis=(0, 2, 3))
    heard = power.mean()
    return 10 * xp.log10((error + CLIPPED * power + 1e-4 * heard) / (power + QUIET * heard)).mean()


def _gram(xp: Any, one: Any, other: Any) -> Any:
    """tr(R_j adj R_k), (n_freqs, 1)."""
    return xp.maximum(one[0] * other[1] + one[1] * other[0] - one[2] * other[2] - one[3] * other[3], 1e-6)


def _mix(weights: Any, values: Any) -> Any:
    """Mix the channels, the first axis of (n_channels, n_groups, n_rows, n_columns)."""
    return (weights @ values.reshape(len(values), -1)).reshape(-1, *values.shape[1:])


def _residual(xp: Any, part: Mapping[str, Any], step: int, hidden: Any, ahead: Any) -> Any:
    inner = _taps(xp, _mix(part["f"], hidden), step, 2) + part["b"][..., None, None]
    if hidden.shape[1] > 1:
        mixed = _mix(part["o"], hidden)
        inner = inner + (mixed.sum(axis=1, keepdims=True) - mixed) / (hidden.shape[1] - 1)
    inner = inner + _mix(part["c"], hidden.mean(axis=2, keepdims=True))
    before, here, after = xp.split(part["t"], 3)
    taps = xp.concatenate([before, here, ahead * after])
    return _taps(xp, _mix(taps, xp.maximum(inner, 0)), step, 3) + part["d"][..., None, None]


def _taps(xp: Any, stacked: Any, step: int, axis: int) -> Any:
    before, here, after = xp.split(stacked, 3)
    size = stacked.shape[axis]
    margins = [(0, 0)] * 4
    margins[axis] = (step, step)
    early, late = [slice(None)] * 4, [slice(None)] * 4
    early[axis], late[axis] = slice(0, size), slice(2 * step, 2 * step + size)
    return here + xp.pad(before, margins)[tuple(early)] + xp.pad(after, margins)[tuple(late)]
