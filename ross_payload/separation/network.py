"""A small network over time, frequency and groups, in plain matrix products.

Patches of 4 bins x 2 frames become vectors of channels. Every block mixes channels along frequency (three taps some
rows apart), with the mean of the other groups and the mean over all rows of the frame, then along time, and adds the
result to its input. The last layer sees the patch again beside what the blocks made of it. The same weights serve every
group: permuting groups permutes the outputs.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from importlib.resources import files

import numpy as np

from ross_payload.array_files import decode_arrays, encode_arrays
from ross_payload.computing import on_threads
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Real

ROWS, COLUMNS = 4, 2  # bins and frames of a patch
PAIR = np.complex64  # as large as the frames of a patch in one bin
PLACES = 3  # numbers that say where in the spectrum a patch is
LIMIT = 8.0  # bound of what comes out
AT_ONCE = 3000  # patches of all groups worked on together: what they need stays in the cache
STEPS = (1, 2, 4, 8, 1, 2)  # between the taps of every block [patches]
EDGE = max(STEPS)  # rows of zeros between columns, which the taps along frequency reach


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

    def corrections(self, shown: Sequence[Real], frequencies: Real) -> Real:
        """Log PSD corrections of every bin, (n_groups, n_freqs, n_frames), within -LIMIT .. LIMIT.

        Parameters
        ----------
        shown
            Features, each (n_freqs, n_groups, n_frames) or to be broadcast to it.
        frequencies
            [Hz], evenly spaced, (n_freqs,).
        """
        n_freqs, _, n_frames = _shape(shown)
        hidden, seen = self._entered(shown, places(frequencies))
        height = seen.shape[2] + EDGE
        inner = np.empty_like(hidden)
        inner[:, :EDGE] = 0
        strips = list(_strips(seen))
        for block in self.blocks:
            on_threads(partial(_fill_inner, block, hidden, inner, height=height), strips)
            on_threads(partial(_mix_along_time, block, hidden, inner, height=height), strips)
            _columns(hidden[:, EDGE:], height)[:, :, -EDGE:] = 0
        return self._left(hidden, seen)[:, :n_freqs, :n_frames]

    def advance(self, shown: Sequence[Real], frequencies: Real, past: Past) -> tuple[Real, Past]:
        """Log PSD corrections of the two newest frames, (n_groups, n_freqs, 2), and what the next call needs.

        As `corrections`, with nothing known of what follows. Called for every frame: patches then overlap by one.

        Parameters
        ----------
        shown
            Features of both, each (n_freqs, n_groups, 2) or to be broadcast to it.
        past
            What the last call returned; () at the beginning.
        """
        n_freqs = len(frequencies)
        hidden, seen = self._entered(shown, places(frequencies))
        height = seen.shape[2] + EDGE
        inner, column, kept = np.zeros_like(hidden), slice(EDGE, EDGE + height), []
        for index, block in enumerate(self.blocks):
            _fill_inner(block, hidden, inner, column, height=height)
            before, here, _ = _taps(block.along_time)
            queue = past[index] if past else ()
            kept.append((*queue[1 - COLUMNS * block.step :], inner[:, column] @ before.T))
            hidden[:, column] += inner[:, column] @ here.T + block.bias_after[:, 0]
            if len(queue) == COLUMNS * block.step:
                hidden[:, column] += queue[0]
            hidden[:, -EDGE:] = 0
        return self._left(hidden, seen)[:, :n_freqs], tuple(kept)

    def _entered(self, shown: Sequence[Real], where: Real) -> tuple[Real, Real]:
        """Vectors of the patches, and what the last layer sees of them.

        The first column by column, `EDGE` zeros before and after each, (n_groups, n, C); the second
        (n_groups, n_columns, n_rows, H + ROWS COLUMNS).
        """
        (_, n_groups, n_frames), n_rows = _shape(shown), where.shape[1]
        n_columns, height = -(-n_frames // COLUMNS), n_rows + EDGE
        first = np.hstack([self.enter, self.enter_bias]).T
        last = np.vstack([np.hstack([self.recall, self.gather_bias]), np.hstack([self.skip, self.leave_bias])]).T
        hidden = np.empty((n_groups, EDGE + n_columns * height, len(self.enter)), np.float32)
        hidden[:, :EDGE] = 0
        inside = _columns(hidden[:, EDGE:], height)
        inside[:, :, n_rows:] = 0
        seen = np.empty((n_groups, n_columns, n_rows, last.shape[1]), np.float32)

        def enter(columns: slice) -> None:
            patches = _patched(shown, where, columns)
            np.maximum(patches @ first, 0, out=inside[:, columns, :n_rows])
            np.matmul(patches, last, out=seen[:, columns])

        on_threads(enter, _some_columns(seen))
        return hidden, seen

    def _left(self, hidden: Real, seen: Real) -> Real:
        """The output of every bin, whole patches, (n_groups, n_freqs, n_frames)."""
        n_groups, n_columns, n_rows, _ = seen.shape
        inside = _columns(hidden[:, EDGE:], n_rows + EDGE)[:, :, :n_rows]
        out = np.empty((n_groups, n_rows, ROWS, n_columns, COLUMNS), np.float32)

        def leave(columns: slice) -> None:
            recalled, skipped = np.split(seen[:, columns], [len(self.recall)], axis=3)
            last = inside[:, columns] @ self.gather.T
            last += recalled
            np.maximum(last, 0, out=last)
            made = last @ self.leave.T
            made += skipped
            out[:, :, :, columns] = made.reshape(*made.shape[:3], ROWS, COLUMNS).transpose(0, 2, 3, 1, 4)

        on_threads(leave, _some_columns(seen))
        return np.asarray(LIMIT * np.tanh(out.reshape(n_groups, n_rows * ROWS, n_columns * COLUMNS) / LIMIT))


def places(frequencies: Real) -> Real:
    """Mean frequency of every row of patches, twice, and the distance of its bins, scaled, (PLACES, n_rows)."""
    centres = _filled(frequencies[:, None, None])[:, 0, 0].reshape(-1, ROWS).mean(axis=1) / 4000
    width = np.log2(max(frequencies[1] - frequencies[0], 1e-3) / 10)
    return np.stack([centres, np.sqrt(centres), np.full_like(centres, width)]).astype(np.float32)


def _shape(shown: Sequence[Real]) -> tuple[int, int, int]:
    """(n_freqs, n_groups, n_frames) of all features together."""
    n_freqs, n_groups, n_frames = np.broadcast_shapes(*(feature.shape for feature in shown))
    return n_freqs, n_groups, n_frames


def _filled(values: Real) -> Real:
    """Repeat the last bin and frame, (n_freqs, .., n_frames), until patches fill the plane."""
    rows, columns = -len(values) % ROWS, -values.shape[2] % COLUMNS
    return np.pad(values, [(0, rows), (0, 0), (0, columns)], mode="edge") if rows or columns else values


def _patched(shown: Sequence[Real], where: Real, columns: slice) -> Real:
    """What is known of some columns of patches, and 1, which the biases are multiplied by.

    (n_groups, n_columns, n_rows, n + 1). The frames of a patch are moved as one number.
    """
    (n_freqs, n_groups, n_frames), n_known = _shape(shown), ROWS * COLUMNS * len(shown)
    patches = np.empty((n_groups, columns.stop - columns.start, where.shape[1], n_known + PLACES + 1), np.float32)
    patches[..., n_known:-1] = where.T
    patches[..., -1] = 1
    pairs, frames = patches.view(PAIR), slice(COLUMNS * columns.start, COLUMNS * columns.stop)
    for index, feature in enumerate(shown):
        part = _filled(np.broadcast_to(feature, (n_freqs, feature.shape[1], n_frames))[..., frames])
        both = np.ascontiguousarray(part, np.float32).view(PAIR)
        split = both.reshape(-1, ROWS, *both.shape[1:]).transpose(2, 3, 0, 1)
        pairs[..., ROWS * index : ROWS * (index + 1)] = split
    return patches


def _some_columns(seen: Real) -> Iterator[slice]:
    """Columns that are worked on together: what they need stays in the cache."""
    n_groups, n_columns, n_rows, _ = seen.shape
    width = max(AT_ONCE // (n_groups * n_rows), 1)
    for low in range(0, n_columns, width):
        yield slice(low, min(low + width, n_columns))


def _strips(seen: Real) -> Iterator[slice]:
    """Where such columns are among the vectors, with the zeros after each."""
    height = seen.shape[2] + EDGE
    for columns in _some_columns(seen):
        yield slice(EDGE + columns.start * height, EDGE + columns.stop * height)


def _columns(vectors: Real, height: int) -> Real:
    """A strip by column and row, (n_groups, n_columns, height, C)."""
    return vectors.reshape(len(vectors), -1, height, vectors.shape[2])


def _fill_inner(block: Block, hidden: Real, inner: Real, strip: slice, *, height: int) -> None:
    """Write what a block makes of some columns, each alone."""
    weights, (n_groups, _, n_channels) = block.along_frequency, hidden.shape
    columns = _columns(hidden[:, strip], height)
    mean = np.full((1, height), 1 / (height - EDGE), np.float32) @ columns  # in BLAS: many short sums are slow
    frame = mean @ block.frame.T + block.bias[:, 0]
    made = _columns(inner[:, strip], height)
    if n_groups > 1:  # the mean of the others is that of all less the own: the product with all serves every group
        others = block.others / np.float32(n_groups - 1)
        weights = weights.copy()
        weights[n_channels : 2 * n_channels] -= others
        np.add(columns.sum(axis=0) @ others.T, frame, out=made)
    else:
        made[...] = frame
    _add_taps(inner, weights, hidden, block.step, strip)
    np.maximum(made, 0, out=made)


def _mix_along_time(block: Block, hidden: Real, inner: Real, strip: slice, *, height: int) -> None:
    """Add to some columns what a block makes of those before, here, and after."""
    _add_taps(hidden, block.along_time, inner, block.step * height, strip)
    hidden[:, strip] += block.bias_after[:, 0]


def _taps(weights: Real) -> tuple[Real, Real, Real]:
    """The weights of what lies before, here, and after, (C, C) each."""
    n_channels = weights.shape[1]
    return weights[:n_channels], weights[n_channels:-n_channels], weights[-n_channels:]


def _add_taps(onto: Real, weights: Real, values: Real, shift: int, strip: slice) -> None:
    """Add three taps to a strip: what lies ``shift`` before, here, and ``shift`` after; zeros outside."""
    for to, seen in zip(onto, values, strict=True):
        for tap, by in zip(_taps(weights), (-shift, 0, shift), strict=True):
            low, high = max(strip.start, -by), min(strip.stop, len(seen) - by)
            if low < high:
                to[low:high] += seen[low + by : high + by] @ tap.T


@cache
def shipped_network() -> Network:
    """The network of the package, trained by `ross_sim.study.train_refiner`."""
    return network_of(shipped_arrays())


def shipped_arrays() -> dict[str, Real]:
    """The weights of the package by name."""
    return arrays_of(files(__package__).joinpath("refiner.npz").read_bytes(), "refiner.npz")


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
    arrays = arrays_of(content, name)
    try:
        return network_of(arrays)
    except KeyError as error:
        raise ConfigError(f"{name}: expected the weights of a refiner, got something else") from error


def arrays_of(content: bytes, name: str) -> dict[str, Real]:
    """Read the arrays that `encode_network` wrote, by name; ``name`` is for the error.

    Raises
    ------
    ConfigError
        When it is damaged or something else.
    """
    arrays = decode_arrays(content, name, "the weights of a refiner")
    return {key: np.asarray(array, np.float32) for key, array in arrays.items()}


def encode_network(arrays: Mapping[str, Real]) -> bytes:
    """Write arrays by name in half precision; no pickle."""
    return encode_arrays({key: np.asarray(array, np.float16) for key, array in arrays.items()})


def network_of(arrays: Mapping[str, Real]) -> Network:
    """The network of arrays ``in in_b hid see hid_b out skip out_b``, ``f o c b t d`` and the number of every block."""
    steps = STEPS[: sum(name.startswith("f") for name in arrays)]
    blocks = tuple(Block(step, *(arrays[f"{part}{i}"] for part in "focbtd")) for i, step in enumerate(steps))
    last = (arrays[name] for name in ("hid", "see", "hid_b", "out", "skip", "out_b"))
    return Network(arrays["in"], arrays["in_b"], blocks, *last)
