"""The clips that the refiner is trained on, kept in half precision, and pieces of them as the network sees them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from ross_payload.dsp.covariance import outer
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Real
from ross_payload.separation.network import places
from ross_payload.separation.refiner_features import LEAST, features, stacked
from ross_sim.cache import Array, cached
from ross_sim.study.training.refiner_data import FRAME, Clip, clip
from ross_sim.study.training.training_voices import voices_fingerprint
from ross_sim.study.training.voice_augmentation import RATE

N_KEPT, LONG_ENOUGH = 16, 10.0  # readers of whom only the clips that watch the training are made, and their speech [s]

Batch = tuple[Array, ...]


def kept_out(voices: Mapping[str, Real], seed: int) -> list[str]:
    """Draw the readers that the network is not trained on, sorted.

    Raises
    ------
    ConfigError
        When too few speak for long enough.
    """
    able = [name for name in sorted(voices) if len(voices[name]) > LONG_ENOUGH * RATE]
    if len(able) < N_KEPT:
        raise ConfigError(f"expected at least {N_KEPT} readers of more than {LONG_ENOUGH} s, got {len(able)}")
    return sorted(np.random.default_rng([seed, 5]).choice(able, N_KEPT, replace=False).tolist())


def packed(made: Clip) -> dict[str, Array]:
    """Arrays of a clip by name, spectra and logarithms of PSDs in half precision."""
    mixture, wanted = (np.stack([part.real, part.imag]) for part in (made.mixture, made.wanted))
    halves = {"mixture": mixture, "wanted": wanted, "log_psds": np.log(np.maximum(made.psds[:, :-1], LEAST))}
    exact = {"rate": np.array(made.rate), "covariances": made.covariances, "noise": made.psds[:, -1, 0]}
    return {name: array.astype(np.float16) for name, array in halves.items()} | exact


def clips(
    voices: Mapping[str, Real], folder: Path, count: int, seed: int, longest: float | None = None
) -> Iterator[Path]:
    """Make the clips that a folder lacks, up to another T60 [s] than usual when told; other voices have other ones."""
    folder /= voices_fingerprint(voices, seed=seed, longest=longest)
    for index in range(count):
        path = folder / f"{seed}-{index:05d}.npz"
        if not path.exists():
            cached(path, lambda index=index: packed(clip(voices, seed, index, longest)))  # type: ignore[misc]
        yield path


def load(path: Path) -> dict[str, Array]:
    """Read arrays by name."""
    with np.load(path, allow_pickle=False) as arrays:
        return {name: arrays[name] for name in arrays.files}


def piece(kept: Mapping[str, Array], start: int, n_frames: int) -> Batch:
    """What `ross_sim.study.training.refiner_model.loss` takes, some frames from ``start``."""
    cut = slice(start, start + n_frames)
    mixture, wanted = (kept[name][..., cut].astype(np.float32) for name in ("mixture", "wanted"))
    psds, noise, covariances = np.exp(kept["log_psds"][..., cut].astype(np.float32)), kept["noise"], kept["covariances"]
    every = np.broadcast_to(noise[:, None, None], (len(psds), 1, psds.shape[2]))
    observed = outer(mixture[0] + 1j * mixture[1]).astype(np.float32)
    shown = stacked(features(observed, covariances, np.concatenate([psds, every], axis=1)))
    where = places(np.arange(len(psds)) * float(kept["rate"]) / FRAME)
    return shown, where, covariances, noise, mixture, wanted
