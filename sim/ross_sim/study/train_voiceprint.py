"""Train the model of voices that the voice print ships with.

``python -m ross_sim.study.train_voiceprint --readers DIR --speech DIR --work DIR [--seed 0] OUT``

The folder of readers has one recording of each and a list, MANIFEST.tsv, that says who is in the set `train`. Of them
`N_KEPT` are kept out of the training and, with the talkers of other corpora in the folder of speech, calibrate the
result. What is made on the way is kept in ``--work``: a run that was interrupted goes on from there and ends with the
same bytes. One thread computes, whatever the machine offers: several would add in another order each time.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray
from sklearn.mixture import GaussianMixture
from threadpoolctl import threadpool_limits

from ross_payload.atomic_files import write_whole
from ross_payload.errors import ConfigError, RossError
from ross_payload.interfaces import Real
from ross_payload.voiceprint.built_in import (
    Background,
    BuiltInModel,
    Factors,
    Parameters,
    encode_model,
    pitch_of,
    read_model,
)
from ross_payload.voiceprint.disturbed_copies import disturbed
from ross_payload.voiceprint.features import Features, analyse
from ross_sim.cache import Array, cached
from ross_sim.study.calibrate_voice_model import logistic
from ross_sim.study.mixtures import RATE as MIXTURE_RATE
from ross_sim.study.reader_mixtures import COLOURED, groups_of, heard
from ross_sim.study.training_voices import readers, recipes, synthetic
from ross_sim.study.voice_augmentation import RATE, coloured, excerpt
from ross_sim.study.voice_factors import discriminants, first_loadings, improved_loadings
from ross_sim.study.voiceprint_study import DURATIONS, OUTSIDE, TALKERS, scenes
from ross_sim.talkers.speech import ENROLMENT, TalkerVoice, load_folder, resampled

N_SYNTHETIC, SYNTHETIC_SECONDS = 28, 14.0
N_KEPT, LONG_ENOUGH = 40, 14.2  # readers who calibrate, of those with so much speech [s]
ONE_PERSON = ("ls4267", "ls8226")  # sound alike: no strangers to each other in trials
N_ROUNDS = 1  # in which everybody is heard in a mixture
PIECES = (20.0, 3.0, 3.0, 3.0, 5.0)  # of every separated voice [s]
CLEAN_PIECES, COPY_PIECE = (20.0, 4.0), 6.0  # of every recording and every disturbed copy of it [s]
LEAST_FRAMES = 80  # loud ones of a piece
N_GAUSSIANS, N_FACTORS, SIZE = 64, 150, 100
FRAMES_OF_EACH, N_FRAMES = 25, 60_000  # that the mixture is fitted to
INDEPENDENCE, SHRINKAGE = 0.2, 0.05
N_STEPS = 5  # of expectation maximisation
ROOMS, N_SCENES = ("S1", "S2", "A0.45"), 4  # mixtures of every room and corpus to calibrate on
MARGIN = 1.0  # a stranger is heard more often than the target, and has to be so far below [nat]


@dataclass(frozen=True, slots=True)
class Piece:
    """Some seconds of a talker."""

    talker: str
    features: Features


@dataclass(frozen=True, slots=True)
class Heard:
    """The embedding of a separated voice."""

    scene: str  # which mixture it was in
    seconds: float
    talker: str
    embedding: Real  # (size,)


def kept_out(voices: Mapping[str, Real], seed: int) -> list[str]:
    """Draw the readers that no parameter is fitted to, sorted."""
    able = [name for name in sorted(voices) if len(voices[name]) > LONG_ENOUGH * RATE and name not in ONE_PERSON]
    if len(able) < N_KEPT:
        raise ConfigError(f"expected at least {N_KEPT} readers of more than {LONG_ENOUGH} s, got {len(able)}")
    return sorted(np.random.default_rng([seed, 5]).choice(able, N_KEPT, replace=False).tolist())


def training_pieces(voices: Mapping[str, Real], work: Path, seed: int) -> Iterator[Piece]:
    """Make pieces of everybody (n,): clean, disturbed, and separated from others in `N_ROUNDS` rounds of mixtures."""
    for index, (name, voice) in enumerate(sorted(voices.items())):

        def alone(index: int = index, name: str = name, voice: Real = voice) -> dict[str, Array]:
            rng = np.random.default_rng([seed, 1, index])
            clips = [(voice, CLEAN_PIECES), *((copy, (COPY_PIECE,)) for copy in disturbed(voice, index))]
            shaded = [(coloured(clip, rng) if rng.random() < COLOURED else clip, cut) for clip, cut in clips]
            return _packed([piece for clip, cut in shaded for piece in _pieces(name, clip, cut, rng)])

        yield from _unpacked(cached(work / f"reader-{index:03d}.npz", alone))
    lengths = {name: len(voice) for name, voice in voices.items()}
    for number in range(N_ROUNDS):
        for index, names in enumerate(groups_of(lengths, seed, number)):

            def together(number: int = number, index: int = index, names: Sequence[str] = names) -> dict[str, Array]:
                rng = np.random.default_rng([seed, 2, number, index])
                found = zip(names, heard([voices[name] for name in names], rng), strict=True)
                return _packed([p for name, one in found if one is not None for p in _pieces(name, one, PIECES, rng)])

            yield from _unpacked(cached(work / f"mixture-{number}-{index:03d}.npz", together))


def _pieces(talker: str, voice: Real, seconds: Sequence[float], rng: np.random.Generator) -> list[Piece]:
    found = [Piece(talker, analyse(excerpt(voice, each, rng), RATE)) for each in seconds if len(voice)]
    return [piece for piece in found if len(piece.features.cepstra) >= LEAST_FRAMES]


def _packed(pieces: Sequence[Piece]) -> dict[str, Array]:
    found = {"talkers": np.array([piece.talker for piece in pieces], dtype="U32")}
    for index, piece in enumerate(pieces):
        found |= {f"cepstra{index}": piece.features.cepstra, f"pitch{index}": piece.features.pitch}
    return found


def _unpacked(arrays: Mapping[str, Array]) -> Iterator[Piece]:
    for index, talker in enumerate(arrays["talkers"]):
        yield Piece(str(talker), Features(arrays[f"cepstra{index}"], arrays[f"pitch{index}"]))


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


def trained(voices: Mapping[str, Real], work: Path, seed: int) -> Parameters:
    """Learn everything but the calibration from the recordings (n,) of talkers."""
    pieces = list(training_pieces(voices, work, seed))
    fitted = cached(work / "gaussians.npz", lambda: mixture(pieces, seed))
    found = [Background(**fitted).statistics(piece.features.cepstra) for piece in pieces]
    counts = np.array([count for count, _ in found])
    sums = np.array([total.ravel() for _, total in found])
    loadings = cached(work / "loadings-0.npz", lambda: {"all": first_loadings(counts, sums, N_FACTORS)})["all"]
    for step in range(1, N_STEPS + 1):

        def better(before: Array = loadings) -> dict[str, Array]:
            return {"all": improved_loadings(counts, sums, before, INDEPENDENCE)}

        loadings = cached(work / f"loadings-{step}.npz", better)["all"]
    steps = np.abs(loadings).max(axis=0) / 127
    whole = np.round(loadings / steps)
    factors = Factors(whole * steps, INDEPENDENCE)
    vectors = [
        np.append(factors.of(*each), pitch_of(piece.features)) for each, piece in zip(found, pieces, strict=True)
    ]
    centre, directions = discriminants(np.array(vectors), [piece.talker for piece in pieces], SIZE, SHRINKAGE)
    learnt = {"loadings": whole, "steps": steps, "centre": centre, "directions": directions}
    neutral = {"slopes": np.ones(2), "thresholds": np.zeros(2), "separated": np.array(0.0)}
    return Parameters(**fitted, **learnt, independence=np.array(INDEPENDENCE), **neutral)


def corpora(folder: Path, held: Mapping[str, Real]) -> dict[str, list[TalkerVoice]]:
    """Return those to calibrate on, at the rate of mixtures: the readers kept out, and talkers of other corpora."""
    cut = round(ENROLMENT * MIXTURE_RATE)
    at_rate = {name: resampled(voice, RATE, MIXTURE_RATE) for name, voice in held.items()}
    known = [TalkerVoice(name, voice[:-cut], voice[-cut:], MIXTURE_RATE) for name, voice in at_rate.items()]
    others = [voice for voice in load_folder(folder, MIXTURE_RATE) if voice.name not in OUTSIDE]
    if len(others) < TALKERS:
        raise ConfigError(f"{folder}: expected at least {TALKERS} talkers beside {', '.join(OUTSIDE)}")
    return {"readers": known, "others": others}


def calibrated(parameters: Parameters, people: Mapping[str, list[TalkerVoice]], work: Path, seed: int) -> Parameters:
    """Fit slopes and thresholds to separated voices, every corpus alike, and the criterion of separated prints."""
    model = BuiltInModel(parameters)
    heard_of = {corpus: _heard(corpus, voices, model, work, seed) for corpus, voices in people.items()}
    prints_of = {
        corpus: {voice.name: model.enrolled(*_enrolment(voice), separated=False).embedding for voice in voices}
        for corpus, voices in people.items()
    }
    fits = []
    for seconds in DURATIONS:
        parts = []
        for corpus, prints in prints_of.items():
            trials = [(one, name) for one in heard_of[corpus] if one.seconds == seconds for name in prints]
            cosines = np.array([float(one.embedding @ prints[name]) for one, name in trials])
            parts.append((cosines, np.array([one.talker == name for one, name in trials])))
        fits.append(_fitted(parts))
    slopes = np.array([round(slope, 1) for slope, _ in fits])
    thresholds = np.array([round(threshold + MARGIN / slope, 3) for slope, threshold in fits])
    found = replace(parameters, slopes=slopes, thresholds=thresholds)
    return replace(found, separated=np.array(_criterion(BuiltInModel(found), heard_of["others"])))


def _criterion(model: BuiltInModel, heard_in_scenes: Sequence[Heard]) -> float:
    """Return the ratio [nat] that tells separated voices apart by prints of what was separated of other mixtures.

    It is the mean of those of all durations; the talkers must have spoken for long enough to say something else.
    """
    enrolments = [one for one in heard_in_scenes if one.seconds == max(DURATIONS)]
    criteria = []
    for seconds in DURATIONS:
        scored = [one for one in heard_in_scenes if one.seconds == seconds]
        pairs = [(print_, one) for print_ in enrolments for one in scored if print_.scene != one.scene]
        ratios = [model.calibration.ratio(float(print_.embedding @ one.embedding), seconds) for print_, one in pairs]
        own = np.array([print_.talker == one.talker for print_, one in pairs])
        slope, threshold = logistic(np.array(ratios), own)
        criteria.append(threshold + MARGIN / slope)
    return round(float(np.mean(criteria)), 1)


def _fitted(parts: Sequence[tuple[Real, NDArray[np.bool_]]]) -> tuple[float, float]:
    """Fit slope [nat] and threshold to the cosines (n,) of corpora; they, and targets and strangers, count alike."""
    cosines, own = np.concatenate([values for values, _ in parts]), np.concatenate([same for _, same in parts])
    shares = [np.where(same, 1 / same.sum(), 1 / (~same).sum()) for _, same in parts]
    weights = np.concatenate(shares)
    return logistic(cosines, own, weights * len(own) / weights.sum())


def _enrolment(voice: TalkerVoice) -> tuple[Real, Features]:
    samples = resampled(voice.enrolment, voice.rate, RATE).astype(float)
    return samples, analyse(samples, RATE)


def _heard(corpus: str, voices: Sequence[TalkerVoice], model: BuiltInModel, work: Path, seed: int) -> list[Heard]:
    """Return the separated voices of some mixtures."""
    found = []
    for where, room in enumerate(ROOMS):
        for number in range(N_SCENES):

            def made(room: str = room, where: int = where, number: int = number) -> dict[str, Array]:
                rng = np.random.default_rng([seed, 4, where, number])
                heard_here = [each for each in scenes(voices, room, rng) if each[1]]
                pieces = [Piece(talker, analyse(signal, MIXTURE_RATE)) for *_, talker, signal in heard_here]
                return _packed(pieces) | {"seconds": np.array([each[0] for each in heard_here])}

            arrays = cached(work / f"{corpus}-{room}-{number:02d}.npz", made)
            for seconds, piece in zip(arrays["seconds"].tolist(), _unpacked(arrays), strict=True):
                embedding = model.embedding_of(piece.features)
                found.append(Heard(f"{room} {number}", seconds, piece.talker, embedding))
    return found


def talkers(folder: Path, seed: int) -> tuple[dict[str, Real], dict[str, Real]]:
    """Return whom to train on, synthetic voices among them, and the readers kept out: recordings (n,) at `RATE`."""
    voices = readers(folder, "train")
    held = {name: voices.pop(name) for name in kept_out(voices, seed)}
    rng = np.random.default_rng([seed, 6])
    for index, recipe in enumerate(recipes(N_SYNTHETIC, rng)):
        voices[recipe.name] = excerpt(synthetic(recipe, index), SYNTHETIC_SECONDS, rng)
    return voices, held


@click.command(help=__doc__)
@click.option("--readers", "folder", type=click.Path(path_type=Path), required=True, help="Folder with MANIFEST.tsv.")
@click.option("--speech", type=click.Path(path_type=Path), required=True, help="Folder of talkers of other corpora.")
@click.option("--work", type=click.Path(path_type=Path), required=True, help="What is made on the way is kept here.")
@click.option("--seed", type=int, default=0, show_default=True)
@click.argument("out", type=click.Path(path_type=Path))
def main(folder: Path, speech: Path, work: Path, seed: int, out: Path) -> None:
    """Train, calibrate and write the model."""
    try:
        with threadpool_limits(1):
            voices, held = talkers(folder, seed)
            people = corpora(speech, held)
            content = encode_model(calibrated(trained(voices, work, seed), people, work, seed))
        write_whole(out, content)
    except RossError as error:
        raise click.ClickException(str(error)) from error
    read = read_model(content, out.name)
    click.echo(f"{out.name}: {len(content) / 1000:.0f} kB, {read.fingerprint}, {read.calibration}")


if __name__ == "__main__":
    main()
