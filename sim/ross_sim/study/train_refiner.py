"""Train the refiner: ``python -m ross_sim.study.train_refiner --readers DIR --work DIR [--seed 0] [--begin FILE] OUT``.

With ``--begin`` it goes on from the weights of an earlier training, with more clips, also in more reverberant rooms,
and smaller steps. With ``--motor``, the recording of a motor without a propeller, it is trained for noise that has a
direction, from the shipped weights on, or from those of ``--begin``.

Clips of random mixtures are made once; then a network is trained on random pieces of them, one piece per step, with
Adam and an average of the weights. The folder of readers has a list, MANIFEST.tsv, that says who is in the set
`train`; clips of `training.refiner_clips.N_KEPT` of them only watch the training. What is made on the way is kept in
``--work``: a run that was interrupted goes on from there and ends with the same bytes, because what a step does depends
on the seed and on its number alone. Needs the packages jax and optax.
"""

from __future__ import annotations

import hashlib
import importlib
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import click
import numpy as np
from threadpoolctl import threadpool_limits

from ross_payload.errors import ConfigError
from ross_payload.interfaces import Real
from ross_payload.plugins import pip
from ross_payload.separation.network import arrays_of, encode_network, shipped_arrays
from ross_sim.cache import Array, cached, fingerprint
from ross_sim.study.option_types import NATURAL
from ross_sim.study.script_errors import expect_writable, told_in_a_line, write_result
from ross_sim.study.training import noise_pieces, refiner_model
from ross_sim.study.training.refiner_clips import Batch, clips, kept_out, load, piece
from ross_sim.study.training.refiner_model import initial, widened
from ross_sim.study.training.training_voices import readers
from ross_sim.study.training.voice_augmentation import RATE
from ross_sim.talkers.speech import read

N_CLIPS, N_WATCHED = 800, 40
N_CHANNELS, N_BLOCKS, N_LAST = 48, 6, 64
N_STEPS = 7_000
N_MORE_CLIPS, LONGER = 2_400, 0.72  # when it goes on from the weights of a training, and the longest T60 in them [s]
N_NOISY_CLIPS, N_NOISY_WATCHED, N_NOISY_STEPS = 115, 8, 2_000  # from the shipped weights on
PIECE = 64  # frames
GROUPS = (2, 3, 4, 5)
BLIND = 0.25  # how often nothing is known of what follows, as frame by frame
FASTEST, SLOWER, SECOND = 1.5e-3, 5e-4, 0.995  # step size of Adam, from trained weights on, and its memory of squares
WARM, FALLING = 300, 0.35  # steps in which the step size rises, and share of them in which it falls to 0 at the end
MEMORY = 0.004  # of the average of the weights, per step
EACH = 1000  # steps between what is kept
EXISTING = click.Path(exists=True, dir_okay=False, path_type=Path)
PACKAGES = ("jax", "optax")
ONE_THREAD = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"


@dataclass(frozen=True, slots=True)
class Recipe:
    """What a training is made of; the defaults are those of the shipped weights."""

    n_steps: int = N_STEPS
    n_channels: int = N_CHANNELS
    n_blocks: int = N_BLOCKS
    n_last: int = N_LAST
    each: int = EACH
    fastest: float = FASTEST
    begun: str = ""  # fingerprint of the weights to begin with


@dataclass(frozen=True, slots=True)
class Purpose:
    """What a network is trained for: its weights to begin with, pieces of clips, and their loss."""

    begin: Callable[[Recipe, int], dict[str, Real]]
    piece: Callable[[Mapping[str, Array], int, int], Batch]
    loss: Callable[..., Any]
    groups: tuple[int, ...]  # that it is trained on, with the noise where that is one


def _random(recipe: Recipe, seed: int) -> dict[str, Real]:
    return initial(recipe.n_channels, recipe.n_blocks, recipe.n_last, np.random.default_rng([seed, 6]))


WHITE = Purpose(_random, piece, refiner_model.loss, tuple(n + 1 for n in GROUPS))


def in_noise(weights: Mapping[str, Real]) -> Purpose:
    """For noise that has a direction, from weights on that know white noise."""
    return Purpose(lambda *_: widened(weights), noise_pieces.piece_in_noise, refiner_model.loss_in_noise, (1, 2, 3, 4))


@dataclass(frozen=True, slots=True)
class Progress:
    """Weights, their average, and the state of the optimiser after some steps, by name."""

    step: int
    weights: dict[str, Any]
    mean: dict[str, Any]
    state: list[Any]
    shape: Any  # of the state, as jax has it
    losses: list[float] = field(default_factory=list)  # of the steps since the last that was kept [dB]


def step_size(step: int, n_steps: int, fastest: float = FASTEST) -> float:
    """Step size of Adam: up at first, level, and down to 0 in a straight line.

    >>> [round(step_size(step, 1000), 5) for step in (0, 299, 500, 825, 1000)]
    [1e-05, 0.0015, 0.0015, 0.00075, 0.0]
    >>> step_size(500, 1000, SLOWER)
    0.0005
    """
    return fastest * min((step + 1) / WARM, 1.0, max(n_steps - step, 0) / (FALLING * n_steps))


def train(
    paths: Sequence[Path], watched: Sequence[Path], work: Path, recipe: Recipe, *, seed: int, purpose: Purpose = WHITE
) -> dict[str, Real]:
    """Train on clips; returns the averaged weights by name.

    Raises
    ------
    ConfigError
        When jax or optax is missing, or no clip can be used.
    """
    jax, optax = map(_import, PACKAGES)
    known = list(usable(paths, purpose))
    kept = work / steps_folder(paths, recipe, seed)
    method, advance, judge = _compiled(jax, optax, purpose)
    weights = purpose.begin(recipe, seed)
    now = Progress(0, weights, weights, *jax.tree.flatten(method.init(weights)))
    while now.step < recipe.n_steps:
        done = min(now.step + recipe.each, recipe.n_steps)
        before = now

        def some(done: int = done, before: Progress = before) -> dict[str, Array]:
            after = before
            for step in range(before.step, done):
                after = _stepped(jax.tree, advance, after, _drawn(known, seed, step, purpose), recipe)
            error = (
                np.mean([float(judge(after.mean, load_whole(path, purpose))) for path in watched])
                if watched
                else np.nan
            )
            click.echo(f"step {done}: {np.mean(after.losses):.2f} dB, average of the weights on others {error:.3f} dB")
            return _packed(after, float(error))

        now = _unpacked(cached(kept / f"{done:06d}.npz", some), replace(now, step=done, losses=[]))
    return {name: np.asarray(array) for name, array in now.mean.items()}


def steps_folder(paths: Sequence[Path], recipe: Recipe, seed: int) -> str:
    """What the folder is called in which the steps of a training on these clips are kept."""
    made = [f"{path.parent.name}/{path.name}" for path in paths]  # the folder of clips says of which voices they are
    return f"steps-{fingerprint(recipe=asdict(recipe), seed=seed, clips=made)[:8]}"


def usable(paths: Sequence[Path], purpose: Purpose = WHITE) -> Iterator[Path]:
    """Those clips that have as many groups as the network is trained on."""
    for path in paths:
        with np.load(path, allow_pickle=False) as arrays:
            if arrays["covariances"].shape[1] in purpose.groups:
                yield path


def load_whole(path: Path, purpose: Purpose = WHITE) -> Batch:
    """Read a clip as one piece, as many frames as patches fill."""
    kept = load(path)
    return purpose.piece(kept, 0, kept["mixture"].shape[-1] // 2 * 2)


def _drawn(known: Sequence[Path], seed: int, step: int, purpose: Purpose) -> tuple[Batch, float]:
    """The piece of a step, and whether the network is shown what follows: 1 or 0."""
    if not known:
        raise ConfigError(f"expected clips with {purpose.groups[0]} to {purpose.groups[-1]} covariances, got none")
    rng = np.random.default_rng([seed, 7, step])
    kept = load(known[int(rng.integers(len(known)))])
    start = int(rng.integers(kept["mixture"].shape[-1] - PIECE))
    return purpose.piece(kept, start, PIECE), float(rng.random() >= BLIND)


def _stepped(tree: Any, advance: Any, before: Progress, drawn: tuple[Batch, float], recipe: Recipe) -> Progress:
    size = step_size(before.step, recipe.n_steps, recipe.fastest)
    memory = max(MEMORY, 1 / (before.step + 1))
    state = tree.unflatten(before.shape, before.state)
    now, value = advance((before.weights, before.mean, state), *drawn, np.array([size, memory], np.float32))
    weights, mean, state = now
    losses = [*before.losses, float(value)]
    return replace(before, step=before.step + 1, weights=weights, mean=mean, state=tree.leaves(state), losses=losses)


def _compiled(jax: Any, optax: Any, purpose: Purpose) -> tuple[Any, Any, Any]:
    """Adam without its step size, one step of it, and the loss of a clip."""

    def error(weights: Any, batch: Any, ahead: Any) -> Any:
        return purpose.loss(jax.numpy, weights, batch, ahead)

    def step(before: Any, batch: Any, ahead: Any, sizes: Any) -> Any:
        weights, mean, state = before
        value, gradient = slope(weights, batch, ahead)
        change, state = method.update(gradient, state)
        weights = jax.tree.map(lambda old, part: old - sizes[0] * part, weights, change)
        mean = jax.tree.map(lambda old, new: old + sizes[1] * (new - old), mean, weights)
        return (weights, mean, state), value

    method = optax.chain(optax.clip_by_global_norm(1.0), optax.scale_by_adam(b2=SECOND))
    slope = jax.value_and_grad(error)
    return method, jax.jit(step), jax.jit(lambda weights, batch: error(weights, batch, 1.0))


def _packed(progress: Progress, error: float) -> dict[str, Array]:
    found = {f"weights-{name}": np.asarray(array) for name, array in progress.weights.items()}
    found |= {f"mean-{name}": np.asarray(array) for name, array in progress.mean.items()}
    found |= {f"state-{index:04d}": np.asarray(array) for index, array in enumerate(progress.state)}
    return found | {"losses": np.array(progress.losses), "error": np.array(error)}


def _unpacked(arrays: Mapping[str, Array], blank: Progress) -> Progress:
    def of(kind: str) -> dict[str, Array]:
        return {name.removeprefix(kind): array for name, array in arrays.items() if name.startswith(kind)}

    states = of("state-")
    return replace(blank, weights=of("weights-"), mean=of("mean-"), state=[states[name] for name in sorted(states)])


def _import(name: str) -> Any:
    os.environ.setdefault("XLA_FLAGS", ONE_THREAD)  # before jax starts: several would add in another order each time
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise ConfigError(f"training needs the package {name}: {pip()} install jax optax") from error


@dataclass(frozen=True, slots=True)
class Training:
    """One way to train: what clips are made, how many, and what is done with them."""

    make: Callable[[Mapping[str, Real], Path, int, int], Iterator[Path]]
    n_clips: int
    n_watched: int
    recipe: Recipe
    purpose: Purpose = WHITE
    folder: str = ""  # what the names of its folders begin with


def training(begin: Path | None, motor: Path | None) -> Training:
    """The way that was asked for: from the beginning, from these weights on, or for noise like that of a motor.

    Raises
    ------
    ConfigError
        When a file cannot be used.
    """
    recipe, weights = Recipe(), shipped_arrays()
    if begin is not None:
        content = begin.read_bytes()
        weights = arrays_of(content, begin.name)
        recipe = Recipe(fastest=SLOWER, begun=hashlib.sha256(content).hexdigest())
    if motor is not None:
        sound = read(motor, RATE).astype(float)

        def make(voices: Mapping[str, Real], folder: Path, count: int, seed: int) -> Iterator[Path]:
            return noise_pieces.noisy_clips(voices, sound, folder, count, seed)

        begun = recipe.begun or hashlib.sha256(encode_network(weights)).hexdigest()
        recipe = replace(recipe, n_steps=N_NOISY_STEPS, each=500, fastest=FASTEST, begun=begun)
        return Training(make, N_NOISY_CLIPS, N_NOISY_WATCHED, recipe, in_noise(weights))
    if begin is not None:
        purpose = replace(WHITE, begin=lambda *_: weights)
        return Training(partial(clips, longest=LONGER), N_MORE_CLIPS, N_WATCHED, recipe, purpose, "more-")
    return Training(clips, N_CLIPS, N_WATCHED, recipe)


@click.command(help=__doc__)
@click.option("--readers", "folder", type=click.Path(path_type=Path), required=True, help="Folder with MANIFEST.tsv.")
@click.option("--work", type=click.Path(path_type=Path), required=True, help="What is made on the way is kept here.")
@click.option(
    "--clips",
    "n_clips",
    type=click.IntRange(min=1),
    help=f"{N_CLIPS}, {N_MORE_CLIPS} further, {N_NOISY_CLIPS} for noise.",
)
@click.option("--steps", type=click.IntRange(min=1), help=f"{N_STEPS}; {N_NOISY_STEPS} for noise.")
@click.option("--seed", type=NATURAL, default=0, show_default=True)
@click.option("--begin", type=EXISTING, help="Go on from the weights in this file.")
@click.option("--motor", type=EXISTING, help="Train for noise that has a direction.")
@click.argument("out", type=click.Path(path_type=Path))
def main(
    *,
    folder: Path,
    work: Path,
    n_clips: int | None,
    steps: int | None,
    seed: int,
    begin: Path | None,
    motor: Path | None,
    out: Path,
) -> None:
    """Train and write the weights (.npz)."""
    with told_in_a_line():
        expect_writable(out)
        with threadpool_limits(1):
            way = training(begin, motor)
            voices = readers(folder, "train")
            for package in PACKAGES:
                _import(package)  # said now, not after hours of making clips
            held = {name: voices.pop(name) for name in kept_out(voices, seed)}
            watched = list(
                usable(list(way.make(held, work / f"{way.folder}watched", way.n_watched, seed + 1)), way.purpose)
            )
            paths = list(way.make(voices, work / f"{way.folder}clips", n_clips or way.n_clips, seed))
            recipe = replace(way.recipe, n_steps=steps or way.recipe.n_steps)
            content = encode_network(train(paths, watched, work, recipe, seed=seed, purpose=way.purpose))
        write_result(out, content)
    click.echo(f"{out.name}: {len(content) / 1000:.0f} kB")


if __name__ == "__main__":
    main()
