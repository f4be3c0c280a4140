"""Train the network of the separator `refined`: `python -m ross_sim.study.train_refiner --speech DIR OUT`.

Clips of random mixtures are made once and kept in a folder; then a network is trained on random pieces of them, one
piece per step, with Adam, a falling step size and an average of the weights. Needs the packages jax and optax.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import click
import numpy as np
from threadpoolctl import threadpool_limits

from ross_payload.errors import ConfigError, RossError
from ross_payload.interfaces import Real
from ross_payload.separation.network import encode_network, places
from ross_sim.study import refiner_model
from ross_sim.study.mixtures import VOICES
from ross_sim.study.refiner_data import FRAME, RATES, Clip, clip
from ross_sim.study.refiner_model import initial
from ross_sim.study.training_voices import recipes, synthetic
from ross_sim.talkers.speech import load_folder, resampled

N_SYNTHETIC, SYNTHETIC_RATE, SYNTHETIC_SEED = 3, 16000, 5
N_CHANNELS, N_BLOCKS = 32, 4
PIECE = 64  # frames
GROUPS = (2, 3, 4)  # clips with more or fewer only take time
FASTEST, SLOWEST, WARM = 2e-3, 1e-5, 0.02  # step size of Adam, and the share of the steps in which it rises
MEMORY = 0.01  # of the average of the weights, per step
YOUNG = 200  # steps during which the average begins


def talkers(folder: Path, leave_out: Sequence[str]) -> dict[str, dict[int, Real]]:
    """Recordings (n,) by talker and rate [Hz]: those of a folder, and synthetic voices that nobody casts."""
    voices: dict[str, dict[int, Real]] = {}
    for rate in RATES:
        for voice in load_folder(folder, rate):
            if voice.name not in leave_out:
                voices.setdefault(voice.name, {})[rate] = voice.speech.astype(float)
    for index, recipe in enumerate(recipes(N_SYNTHETIC, np.random.default_rng(SYNTHETIC_SEED))):
        spoken = synthetic(recipe, index)
        voices[recipe.name] = {rate: resampled(spoken, SYNTHETIC_RATE, rate).astype(float) for rate in RATES}
    return voices


def keep(made: Clip, path: Path) -> None:
    """Write a clip in half precision."""
    mixture, wanted = (np.stack([part.real, part.imag]) for part in (made.mixture, made.wanted))
    halves = {"shown": made.shown, "mixture": mixture, "wanted": wanted}
    exact = {"rate": np.array(made.rate), "covariances": made.covariances, "noise": made.noise}
    np.savez(path, allow_pickle=False, **{name: a.astype(np.float16) for name, a in halves.items()}, **exact)


def clips(voices: Mapping[str, Mapping[int, Real]], folder: Path, count: int, seed: int) -> Iterator[Path]:
    """Make the clips that a folder lacks."""
    folder.mkdir(parents=True, exist_ok=True)
    for index in range(count):
        path = folder / f"{index:05d}.npz"
        if not path.exists():
            keep(clip(voices, seed, index), path)
        yield path


def load(path: Path) -> dict[str, Real]:
    """Read a clip, or weights, by name."""
    with np.load(path, allow_pickle=False) as arrays:
        return {name: arrays[name] for name in arrays.files}


def piece(kept: Mapping[str, Real], start: int) -> tuple[Real, ...]:
    """What `refiner_model.loss` takes, PIECE frames from ``start``."""
    n_freqs = kept["shown"].shape[2]
    where = places(np.arange(n_freqs) * float(kept["rate"]) / FRAME)
    shown, mixture, wanted = (
        kept[name][..., start : start + PIECE].astype(np.float32) for name in ("shown", "mixture", "wanted")
    )
    return shown, where, kept["covariances"], kept["noise"], mixture, wanted


def step_size(share: float) -> float:
    """Step size when this share of the steps is done: up at first, then down by a cosine.

    >>> step_size(1.0) == SLOWEST
    True
    """
    return FASTEST * min(1.0, WARM + share / WARM) * (0.5 + 0.5 * float(np.cos(np.pi * share))) + SLOWEST


def train(paths: Sequence[Path], n_steps: int, seed: int, start: Mapping[str, Real]) -> dict[str, Real]:
    """Train a network on clips from ``start``; returns the averaged weights by name.

    Raises
    ------
    ConfigError
        When jax or optax is missing.
    """
    jax, rng = _import("jax"), np.random.default_rng(seed)
    known = [kept for kept in map(load, paths) if len(kept["shown"]) in GROUPS]
    method, step = _method(jax, _import("optax"))
    weights: Any = dict(start)
    state, mean, values = method.init(weights), weights, []
    for index in range(n_steps):
        kept = known[int(rng.integers(len(known)))]
        batch = piece(kept, int(rng.integers(kept["shown"].shape[-1] - PIECE)))
        state.hyperparams["learning_rate"] = jax.numpy.asarray(step_size(index / n_steps))
        weights, state, value = step(weights, state, batch)
        memory = max(MEMORY, 1 / (index + 1)) if index < YOUNG else MEMORY
        mean = jax.tree.map(lambda old, new, part=memory: old + part * (new - old), mean, weights)
        values.append(float(value))
        if index % 100 == 99:
            click.echo(f"step {index + 1}: {np.mean(values[-100:]):.2f} dB")
    return {name: np.asarray(array) for name, array in mean.items()}


def _method(jax: Any, optax: Any) -> tuple[Any, Any]:
    """Adam with a step size that is set from outside, and one step of it."""

    def chain(learning_rate: float) -> Any:
        return optax.chain(optax.clip_by_global_norm(1.0), optax.adam(learning_rate, b2=0.99))

    def step(weights: Any, state: Any, batch: Any) -> Any:
        value, gradient = slope(weights, batch)
        change, state = method.update(gradient, state)
        return optax.apply_updates(weights, change), state, value

    method = optax.inject_hyperparams(chain)(learning_rate=FASTEST)
    slope = jax.value_and_grad(lambda weights, batch: refiner_model.loss(jax.numpy, weights, batch))
    return method, jax.jit(step)


def _import(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise ConfigError(f"training needs the package {name}: pip install jax optax") from error


@click.command()
@click.option("--speech", type=click.Path(path_type=Path), required=True, help="Folder of talkers.")
@click.option("--leave-out", multiple=True, default=VOICES, help="Talkers not to train on.")
@click.option("--clips", "folder", type=click.Path(path_type=Path), required=True, help="Where the clips are kept.")
@click.option("--count", type=click.IntRange(min=1), default=400, show_default=True, help="Clips.")
@click.option("--start", type=click.Path(path_type=Path), help="Weights to begin with, instead of random ones.")
@click.option("--steps", type=click.IntRange(min=1), default=3000, show_default=True)
@click.option("--seed", type=int, default=0, show_default=True)
@click.argument("out", type=click.Path(path_type=Path))
def main(
    *,
    speech: Path,
    leave_out: tuple[str, ...],
    folder: Path,
    count: int,
    start: Path | None,
    steps: int,
    seed: int,
    out: Path,
) -> None:
    """Train and write the weights (.npz)."""
    try:
        with threadpool_limits(1):
            paths = list(clips(talkers(speech, leave_out), folder, count, seed))
            weights = load(start) if start else initial(N_CHANNELS, N_BLOCKS, np.random.default_rng(seed))
            content = encode_network(train(paths, steps, seed, weights))
    except RossError as error:
        raise click.ClickException(str(error)) from error
    out.write_bytes(content)
    click.echo(f"{out.name}: {len(content) / 1000:.0f} kB")


if __name__ == "__main__":
    main()
