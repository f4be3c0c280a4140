"""A small network over time, frequency and groups, in plain matrix products.

Patches of 4 bins x 2 frames become vectors of channels. Every block mixes channels along frequency (three taps some
rows apart), with the mean of the other groups and the mean over all rows of the frame, then along time, and adds the
result to its input. The last layer sees the patch again beside what the blocks made of it. The same weights serve every
group: permuting groups permutes the outputs.
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import numpy as np

from ross_payload.errors import ConfigError
from ross_payload.interfaces import Real

ROWS, COLUMNS = 4, 2  # bins and frames of a patch
PLACES = 3  # numbers that say where in the spectrum a patch is
LIMIT = 8.0  # bound of what comes out
AT_ONCE = 3000  # patches of all groups worked on together: what they need stays in the cache
STEPS = (1, 2, 4, 8, 1, 2)  # between the taps of every block [patches]


Past = tuple[tuple[Real, ...], ...]  # of every block, what its newest columns give to later ones


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """Weights of one residual block of C channels; the steps between taps are rows and columns of patches."""

    step: int
    along_frequency: Real  # the taps before, at and after stacked, (3 C, C)
    others: Real  # of the mean over the other groups, (C, C)
    frame: Real  # of the mean over the rows, (C, C)
    bias: Real  # (C, 1)
    along_time: Real  # (3 C, C)
    bias_after: Real  # (C, 1)


@dataclass(frozen=True, slots=True, eq=False)
class Network:
    """Weights of everything; n = ROWS COLUMNS n_features + PLACES."""

    enter: Real  # (C, n)
    enter_bias: Real  # (C, 1)
    blocks: tuple[Block, ...]
    gather: Real  # what is known of the patch, (H, C)
    recall: Real  # and what it looked like, (H, n)
    gather_bias: Real  # (H, 1)
    leave: Real  # (ROWS COLUMNS, H)
    skip: Real  # (ROWS COLUMNS, n)
    leave_bias: Real  # (ROWS COLUMNS, 1)

    def corrections(self, shown: Real, frequencies: Real) -> Real:
        """Log PSD corrections of every bin, (n_groups, n_freqs, n_frames), within -LIMIT .. LIMIT.

        Parameters
        ----------
        shown
            Features, (n_groups, n_features, n_freqs, n_frames).
        frequencies
            [Hz], evenly spaced, (n_freqs,).
        """
        n_freqs, n_frames = shown.shape[2:]
        patches = _patched(_filled(shown), places(_filled(frequencies[:, None])[:, 0]))
        hidden = np.maximum(_product(self.enter, patches) + self.enter_bias[..., None], 0)
        for block in self.blocks:
            _add_taps(hidden, block.along_time, _inner(block, hidden), block.step, axis=3)
            hidden += block.bias_after[..., None]
        return self._leave(hidden, patches)[:, :n_freqs, :n_frames]

    def advance(self, shown: Real, frequencies: Real, past: Past) -> tuple[Real, Past]:
        """Log PSD corrections of the two newest frames, (n_groups, n_freqs, 2), and what the next call needs.

        As `corrections`, with nothing known of what follows. Called for every frame: patches then overlap by one.

        Parameters
        ----------
        shown
            Features of both, (n_groups, n_features, n_freqs, 2).
        past
            What the last call returned; () at the beginning.
        """
        n_freqs = shown.shape[2]
        patches = _patched(_filled(shown), places(_filled(frequencies[:, None])[:, 0]))
        hidden = np.maximum(_product(self.enter, patches) + self.enter_bias[..., None], 0)
        kept = []
        for index, block in enumerate(self.blocks):
            inner = _inner(block, hidden)
            before, here, _ = np.split(_product(block.along_time, inner), 3, axis=1)
            queue = past[index] if past else ()
            hidden = hidden + here + block.bias_after[..., None]
            if len(queue) == COLUMNS * block.step:
                hidden += queue[0]
            kept.append((*queue[1 - COLUMNS * block.step :], before))
        return self._leave(hidden, patches)[:, :n_freqs], tuple(kept)

    def _leave(self, hidden: Real, patches: Real) -> Real:
        """The output of every bin, whole patches, (n_groups, n_freqs, n_frames)."""
        last = _product(self.gather, hidden) + _product(self.recall, patches) + self.gather_bias[..., None]
        np.maximum(last, 0, out=last)
        out = _product(self.leave, last) + _product(self.skip, patches) + self.leave_bias[..., None]
        out = LIMIT * np.tanh(out / LIMIT)
        n_groups, _, rows, columns = out.shape
        bins = out.reshape(n_groups, ROWS, COLUMNS, rows, columns).transpose(0, 3, 1, 4, 2)
        return np.asarray(bins.reshape(n_groups, rows * ROWS, columns * COLUMNS))


def places(frequencies: Real) -> Real:
    """Mean frequency of every row of patches, twice, and the distance of its bins, scaled, (PLACES, n_rows)."""
    centres = frequencies.reshape(-1, ROWS).mean(axis=1) / 4000
    width = np.log2(max(frequencies[1] - frequencies[0], 1e-3) / 10)
    return np.stack([centres, np.sqrt(centres), np.full_like(centres, width)]).astype(np.float32)


def _filled(values: Real) -> Real:
    """Repeat the last bin and frame until patches fill the plane of the last two axes."""
    rows, columns = (-size % unit for size, unit in zip(values.shape[-2:], (ROWS, COLUMNS), strict=True))
    return np.pad(values, [(0, 0)] * (values.ndim - 2) + [(0, rows), (0, columns)], mode="edge")


def _patched(shown: Real, where: Real) -> Real:
    n_groups, n_features, n_freqs, n_frames = shown.shape
    rows, columns = n_freqs // ROWS, n_frames // COLUMNS
    split = shown.reshape(n_groups, n_features, rows, ROWS, columns, COLUMNS).transpose(0, 1, 3, 5, 2, 4)
    flat = split.reshape(n_groups, -1, rows, columns)
    same = np.broadcast_to(where[None, :, :, None], (n_groups, len(where), rows, columns))
    return np.concatenate([flat, same], axis=1).astype(np.float32)


def _product(weights: Real, values: Real) -> Real:
    """Mix the channels, the second axis of (n_groups, n_channels, n_rows, n_columns)."""
    n_groups, n_channels, rows, columns = values.shape
    return (weights @ values.reshape(n_groups, n_channels, -1)).reshape(n_groups, -1, rows, columns)


def _inner(block: Block, hidden: Real) -> Real:
    """What a block makes of every column alone."""
    weights, n_channels = block.along_frequency, hidden.shape[1]
    inner = np.empty_like(hidden)
    inner[...] = _product(block.frame, hidden.mean(axis=2, keepdims=True)) + block.bias[..., None]
    if len(hidden) > 1:  # the mean of the others is that of all less the own: the product with all serves every group
        others = block.others / np.float32(len(hidden) - 1)
        weights = weights.copy()
        weights[n_channels : 2 * n_channels] -= others
        inner += _product(others, hidden.sum(axis=0, keepdims=True))
    _add_taps(inner, weights, hidden, block.step, axis=2)
    return np.maximum(inner, 0, out=inner)


def _add_taps(onto: Real, weights: Real, values: Real, step: int, axis: int) -> None:
    """Add three taps: what lies ``step`` before, here, and ``step`` after along an axis; zeros outside.

    One matrix product for some rows at a time, so that what it needs stays in the cache.
    """
    n_groups, n_channels, n_rows, n_columns = values.shape
    side_by_side = np.hstack(np.split(weights, 3))  # (C, 3 C)
    height = max(AT_ONCE // (n_groups * n_columns), 1)
    for low in range(0, n_rows, height):
        rows = slice(low, min(low + height, n_rows))
        seen = np.empty((n_groups, 3, n_channels, rows.stop - low, n_columns), values.dtype)
        seen[:, 1] = values[:, :, rows]
        for place, shift in ((0, -step), (2, step)):
            _shifted(seen[:, place], values, rows, shift, axis)
        made = side_by_side @ seen.reshape(n_groups, 3 * n_channels, -1)
        onto[:, :, rows] += made.reshape(n_groups, n_channels, -1, n_columns)


def _shifted(out: Real, values: Real, rows: slice, shift: int, axis: int) -> None:
    """Write some rows of the values that lie ``shift`` further along an axis, zeros beyond the edges."""
    size = values.shape[axis]
    low, high = (rows.start, rows.stop) if axis == 2 else (0, size)
    first, last = min(max(low + shift, 0), size), min(max(high + shift, 0), size)
    inside = slice(first - shift - low, last - shift - low)
    if axis == 2:
        out[:, :, : inside.start] = out[:, :, inside.stop :] = 0
        out[:, :, inside] = values[:, :, first:last]
    else:
        out[..., : inside.start] = out[..., inside.stop :] = 0
        out[..., inside] = values[:, :, rows, first:last]


@cache
def shipped_network() -> Network:
    """The network of the package, trained by `ross_sim.study.train_refiner`."""
    return network_of(shipped_arrays())


def shipped_arrays() -> dict[str, Real]:
    """The weights of the package by name."""
    return _arrays(files(__package__).joinpath("refiner.npz").read_bytes(), "refiner.npz")


@cache
def network_in_noise() -> Network:
    """The network of the package for noise that has a direction, trained by the same command."""
    return read_network(files(__package__).joinpath("refiner_in_noise.npz").read_bytes(), "refiner_in_noise.npz")


def read_network(content: bytes, name: str) -> Network:
    """Read what `encode_network` wrote; ``name`` is for the error.

    Raises
    ------
    ConfigError
        When it is damaged or something else.
    """
    arrays = _arrays(content, name)
    try:
        return network_of(arrays)
    except KeyError as error:
        raise ConfigError(f"{name}: expected the weights of a refiner, got something else") from error


def _arrays(content: bytes, name: str) -> dict[str, Real]:
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as arrays:
            return {key: np.asarray(arrays[key], np.float32) for key in arrays.files}
    except Exception as error:  # zipfile, zlib and numpy each have their own way to fail on damaged bytes
        raise ConfigError(f"{name}: expected the weights of a refiner, got something else") from error


def encode_network(arrays: Mapping[str, Real]) -> bytes:
    """Write arrays by name in half precision; no pickle."""
    buffer = io.BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, **{key: np.asarray(a, np.float16) for key, a in arrays.items()})
    return buffer.getvalue()


def network_of(arrays: Mapping[str, Real]) -> Network:
    """The network of arrays ``in in_b hid see hid_b out skip out_b``, ``f o c b t d`` and the number of every block."""
    steps = STEPS[: sum(name.startswith("f") for name in arrays)]
    blocks = tuple(Block(step, *(arrays[f"{part}{i}"] for part in "focbtd")) for i, step in enumerate(steps))
    last = (arrays[name] for name in ("hid", "see", "hid_b", "out", "skip", "out_b"))
    return Network(arrays["in"], arrays["in_b"], blocks, *last)
