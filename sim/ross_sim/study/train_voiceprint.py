"""Train the model of voices that the voice print ships with.

``python -m ross_sim.study.train_voiceprint --readers DIR --speech DIR --work DIR [--seed 0] OUT``

The folder of readers has one recording of each and a list, MANIFEST.tsv, that says who is in the set `train`. All of
them train the model, and all of them calibrate it, each scored by what was learnt without this reader's fold; so do
talkers of other corpora in the folder of speech. What is made on the way is kept in ``--work``: a run that was
interrupted goes on from there and ends with the same bytes. One thread computes, whatever the machine offers: several
would add in another order each time.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path

import click
import numpy as np
from sklearn.mixture import GaussianMixture
from threadpoolctl import threadpool_limits

from ross_payload.interfaces import Real
from ross_payload.voiceprint.built_in import Background, Factors, Parameters, encode_model, pitch_of, read_model
from ross_payload.voiceprint.embedding_print import unit
from ross_sim.cache import Array, cached
from ross_sim.study.option_types import NATURAL
from ross_sim.study.script_errors import expect_writable, told_in_a_line, write_result
from ross_sim.study.training.calibration_voices import (
    N_FOLDS,
    enrolled_readers,
    enrolments,
    folds_of,
    heard_in_rooms,
    others,
    reader_voice,
    speaks_long,
)
from ross_sim.study.training.training_voices import readers, recipes, synthetic, voices_fingerprint
from ross_sim.study.training.voice_augmentation import excerpt
from ross_sim.study.training.voice_calibration import Corpus, calibrated
from ross_sim.study.training.voice_factors import discriminants, first_loadings, improved_loadings
from ross_sim.study.training.voice_pieces import Piece, reader_of, training_pieces, with_speeds

N_SYNTHETIC, SYNTHETIC_SECONDS = 28, 14.0
N_GAUSSIANS, N_FACTORS = 256, 150
FRAMES_OF_EACH, N_FRAMES = 17, 60_000  # that the mixture is fitted to
INDEPENDENCE, SHRINKAGE = 0.2, 0.1
N_STEPS = 3  # of expectation maximisation


def talkers(folder: Path, seed: int) -> tuple[dict[str, Real], dict[str, Real]]:
    """Return the readers, and whom to train on: these, the same at other speeds, synthetic voices; (n,) at `RATE`."""
    base = readers(folder, "train")
    voices, rng = with_speeds(base, seed), np.random.default_rng([seed, 6])
    for index, recipe in enumerate(recipes(N_SYNTHETIC, rng)):
        voices[recipe.name] = excerpt(synthetic(recipe, index), SYNTHETIC_SECONDS, rng)
    return base, voices


def mixture(pieces: Sequence[Piece], seed: int) -> dict[str, Array]:
    """Fit the Gaussian mixture: weights, means and deviations."""
    rng = np.random.default_rng([seed, 3])
    each = [p.features.cepstra for p in pieces]
    drawn = [frames[rng.choice(len(frames), min(FRAMES_OF_EACH, len(frames)), replace=False)] for frames in each]
    frames = rng.permutation(np.concatenate(drawn))[:N_FRAMES].astype(float)
    fit = GaussianMixture(
        N_GAUSSIANS, covariance_type="diag", random_state=seed, max_iter=100, tol=3e-3, reg_covar=1e-3
    ).fit(frames)
    return {"weights": fit.weights_, "means": fit.means_, "deviations": np.sqrt(fit.covariances_)}


def trained(
    voices: Mapping[str, Real], folds: Mapping[str, int], work: Path, seed: int
) -> dict[int | None, Parameters]:
    """Learn everything but the calibration from recordings (n,) of talkers: of all (None), and without each fold."""
    pieces = list(training_pieces(voices, work, seed))
    work /= f"learnt-{voices_fingerprint(voices, folds=dict(folds), seed=seed)}"
    pitches = np.array([pitch_of(piece.features) for piece in pieces])
    owners = np.array([folds.get(reader_of(piece.talker), -1) for piece in pieces])
    learnt: dict[int | None, Parameters] = {}
    for fold in (None, *sorted(set(folds.values()))):
        kept = np.flatnonzero(np.ones(len(owners)) if fold is None else owners != fold)
        mark, known = "all" if fold is None else f"without-{fold}", [pieces[i] for i in kept]
        fitted = cached(work / mark / "gaussians.npz", partial(mixture, known, seed))
        background = Background(**fitted)
        found = [background.statistics(piece.features.cepstra) for piece in known]
        counts = np.array([count for count, _ in found])
        whole, steps = loadings(counts, np.array([total.ravel() for _, total in found], np.float32), work / mark)
        extract = Factors(whole * steps, INDEPENDENCE)
        each = np.array([np.append(extract.of(*of), pitch) for of, pitch in zip(found, pitches[kept], strict=True)])
        talkers_of = [piece.talker for piece in known]
        centre, directions = discriminants(each, talkers_of, SHRINKAGE)
        learnt[fold] = Parameters(
            **fitted,
            loadings=whole,
            steps=steps,
            independence=np.array(INDEPENDENCE),
            centre=centre,
            directions=directions,
            cohort=cohort((each - centre) @ directions, talkers_of),
            slopes=np.ones(2),
            thresholds=np.zeros(2),
            separated=np.array(0.0),
        )
    return learnt


def cohort(vectors: Real, talkers: Sequence[str]) -> Real:
    """Return one embedding (n, size) of each talker, not of those at other speeds, by what was heard of them (m, size).

    >>> cohort(np.array([[3.0, 0.0], [0.0, 4.0], [1.0, 0.0], [1.0, 1.0]]), ["b", "a", "b", "a@0.9"]).tolist()
    [[0.0, 1.0], [1.0, 0.0]]
    """
    owners, lengths = np.array(talkers), np.linalg.norm(vectors, axis=1, keepdims=True)
    names = [name for name in sorted(set(talkers)) if reader_of(name) == name]
    return np.array([unit((vectors / lengths)[owners == name].sum(axis=0)) for name in names])


def loadings(counts: Real, sums: Real, work: Path) -> tuple[Real, Real]:
    """Learn the loadings in whole steps, (n_gaussians * n_features, n_factors), and the steps, (n_factors,)."""
    found = cached(work / "loadings-0.npz", lambda: {"all": first_loadings(counts, sums, N_FACTORS)})["all"]
    for step in range(1, N_STEPS + 1):

        def better(before: Array = found) -> dict[str, Array]:
            return {"all": improved_loadings(counts, sums, before, INDEPENDENCE)}

        found = cached(work / f"loadings-{step}.npz", better)["all"]
    steps = np.abs(found).max(axis=0) / 127
    return np.round(found / steps), steps


def corpora(base: Mapping[str, Real], folds: Mapping[str, int], speech: Path, work: Path, seed: int) -> list[Corpus]:
    """Return those to calibrate on: readers by fold, and talkers of other corpora."""
    known = enrolled_readers(base, folds)
    long = [
        [reader_voice(n, base[n]) for n in sorted(base) if folds[n] == f and speaks_long(n, base[n])]
        for f in range(N_FOLDS)
    ]
    strange = others(speech)
    prints = [enrolments(part, work) for part in known]
    return [
        Corpus(heard_in_rooms("readers", long, work, seed), dict(enumerate(prints))),
        Corpus(heard_in_rooms("others", [strange], work, seed), {None: enrolments(strange, work)}),
    ]


@click.command(help=__doc__)
@click.option("--readers", "folder", type=click.Path(path_type=Path), required=True, help="Folder with MANIFEST.tsv.")
@click.option("--speech", type=click.Path(path_type=Path), required=True, help="Folder of talkers of other corpora.")
@click.option("--work", type=click.Path(path_type=Path), required=True, help="What is made on the way is kept here.")
@click.option("--seed", type=NATURAL, default=0, show_default=True)
@click.argument("out", type=click.Path(path_type=Path))
def main(folder: Path, speech: Path, work: Path, seed: int, out: Path) -> None:
    """Train, calibrate and write the model."""
    with told_in_a_line():
        expect_writable(out)
        with threadpool_limits(1):
            base, voices = talkers(folder, seed)
            folds = folds_of(base, seed)
            learnt = trained(voices, folds, work, seed)
            people = corpora(base, folds, speech, work, seed)
            parameters, lines = calibrated(learnt, people)
            content = encode_model(parameters)
        write_result(out, content)
    read = read_model(content, out.name)
    click.echo("\n".join(lines))
    click.echo(f"{out.name}: {len(content) / 1000:.0f} kB, {read.fingerprint}, {read.calibration}")


if __name__ == "__main__":
    main()
