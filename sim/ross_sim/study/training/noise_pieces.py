"""The clips in noise that the refiner is trained on, kept in half precision, and pieces as the network sees them."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from ross_payload.dsp.covariance import outer
from ross_payload.interfaces import Real
from ross_payload.separation.evened_noise import LOWEST_VOICE
from ross_payload.separation.network import places
from ross_payload.separation.refined import shown_in_noise
from ross_payload.separation.refiner_features import LEAST, stacked
from ross_sim.cache import Array, cached
from ross_sim.study.training.noise_clips import NoisyClip, clip_in_noise
from ross_sim.study.training.refiner_clips import Batch
from ross_sim.study.training.refiner_data import FRAME
from ross_sim.study.training.training_voices import voices_fingerprint


def packed(made: NoisyClip) -> dict[str, Array]:
    """Arrays of a clip by name, spectra, fields and logarithms in half precision."""
    mixture, wanted = (np.stack([part.real, part.imag]) for part in (made.mixture, made.wanted))
    logs = {"log_psds": made.psds, "log_level": made.level}
    halves = {"mixture": mixture, "wanted": wanted, "field": made.field}
    halves |= {name: np.log(np.maximum(array, LEAST)) for name, array in logs.items()}
    exact = {"rate": np.array(made.rate), "covariances": made.covariances, "noise": made.noise}
    return {name: array.astype(np.float16) for name, array in halves.items()} | exact


def noisy_clips(voices: Mapping[str, Real], motor: Real | None, folder: Path, count: int, seed: int) -> Iterator[Path]:
    """Make the clips that a folder lacks; other voices, and another motor, have other ones."""
    propeller = None if motor is None else hashlib.sha256(motor.tobytes()).hexdigest()
    folder /= voices_fingerprint(voices, seed=seed, motor=propeller, noise=True)
    for index in range(count):
        path = folder / f"{seed}-{index:05d}.npz"
        if not path.exists():
            cached(path, lambda index=index: packed(clip_in_noise(voices, motor, seed, index)))  # type: ignore[misc]
        yield path


def piece_in_noise(kept: Mapping[str, Array], start: int, n_frames: int) -> Batch:
    """What `refiner_model.loss_in_noise` takes, some frames from ``start``; whole patches of bins."""
    n_freqs = len(kept["noise"]) // 4 * 4
    rows, cut = slice(0, n_freqs), slice(start, start + n_frames)
    mixture, wanted = (kept[name][..., rows, cut].astype(np.float32) for name in ("mixture", "wanted"))
    field = kept["field"][rows, :, cut].astype(np.float32)
    level = np.exp(kept["log_level"][rows, cut].astype(np.float32))
    psds = np.exp(kept["log_psds"][rows, :, cut].astype(np.float32))
    noise, covariances = kept["noise"][rows], kept["covariances"][rows]
    observed = outer(mixture[0] + 1j * mixture[1]).astype(np.float32)
    shown = stacked(shown_in_noise(observed, covariances, psds, noise, field))
    width = float(kept["rate"]) / FRAME
    where = places((np.ceil(LOWEST_VOICE / width) + np.arange(n_freqs)) * width)
    return shown, where, covariances, field, level, mixture, wanted
