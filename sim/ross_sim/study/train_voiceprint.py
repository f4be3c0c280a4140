"""Train the background model that the voice print ships with.

``python -m ross_sim.study.train_voiceprint --speech DIR [--leave-out NAME ...] [--seed 0] OUT``

DIR holds one folder of recordings per talker. Every talker is also played slower and faster, which makes further
voices; synthetic voices of random recipes are added, none of which the simulator casts. One thread computes, whatever
the machine offers: several would add in another order each time, and the mixture would settle elsewhere.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np
from sklearn.linear_model import LogisticRegression
from sklearn.mixture import GaussianMixture
from threadpoolctl import threadpool_limits

from ross_payload.errors import ConfigError
from ross_payload.interfaces import Real
from ross_payload.voiceprint.background import COHORT_STEP, Background, encode_background, read_background, reliability
from ross_payload.voiceprint.features import CEPSTRA, Features, analyse
from ross_sim.cache import cache_folder, cached, fingerprint
from ross_sim.study.mixtures import RATE as MIXTURE_RATE
from ross_sim.study.voice_augmentation import RATE, at_speed, disturbed, excerpt
from ross_sim.study.voiceprint_study import OUTSIDE, scenes
from ross_sim.talkers.speech import TalkerVoice, load_folder
from ross_sim.talkers.synthetic_voices import Recipe, levelled, speak, speech_text

COHORT_SPEEDS = (0.93, 1.0, 1.07)
SPEEDS = (0.86, 0.93, 1.0, 1.07, 1.15)
SYNTHETIC_SPEEDS = (0.95, 1.06)
N_SYNTHETIC = 28
LANGUAGES = ("en", "en-US", "en-GB-x-rp", "en-GB-scotland", "en-GB-x-gbclan", "en-GB-x-gbcwmd", "de", "fr")
N_GAUSSIANS, N_PITCHES, N_FRAMES = 64, 12, 30_000
RELEVANCE = 8.0
ENROLMENT = 4.2  # [s]
N_MIXTURES = 36  # to calibrate with: each of 7 talkers in about 15


@dataclass(frozen=True, slots=True)
class Talker:
    """A voice to train on; several speeds of one talker share the name."""

    name: str
    speed: float
    enrolment: Features  # clean
    clips: tuple[Features, ...]  # disturbed


def recipes(n: int, rng: np.random.Generator) -> Iterator[Recipe]:
    """Draw recipes of synthetic voices, low and high ones in turn."""
    for index in range(n):
        low = int(rng.uniform(65, 150) if index % 2 else rng.uniform(140, 300))
        scale = rng.uniform(84, 104) if index % 2 else rng.uniform(102, 130)
        first, second, higher = (int(scale + rng.uniform(-7, 7)) for _ in range(3))
        tilt, speed = int(rng.uniform(60, 140)), int(rng.uniform(135, 180))
        language = LANGUAGES[int(rng.integers(len(LANGUAGES)))]
        pitch = (low, int(low * rng.uniform(1.25, 1.4)))
        yield Recipe(f"train{index}", language, pitch, (first, second, higher), tilt, speed)


def synthetic(recipe: Recipe, index: int) -> Real:
    """Speak about a minute with a recipe, (n,), from the cache when it was spoken before."""
    text = speech_text(index)
    key = fingerprint(recipe=asdict(recipe), said=text, rate=RATE, engine=_engine(), use="train")
    path = cache_folder(None) / "voices" / f"{recipe.name}-{key}.npz"
    return cached(path, lambda: {"speech": levelled(*speak(recipe, text), RATE)})["speech"].astype(float)


def _engine() -> str:
    try:
        return version("espeakng-loader")
    except PackageNotFoundError as error:
        raise ConfigError("training needs synthetic voices: install the package espeakng-loader") from error


def talkers(speech: dict[str, Real], speeds: Sequence[float], n: int, rng: np.random.Generator) -> Iterator[Talker]:
    """Make the talkers of some recordings at some speeds, each with ``n`` disturbed clips of 2.5 to 10 s."""
    for name, voice in speech.items():
        others = [other for key, other in speech.items() if key != name]
        for speed in speeds:
            played = at_speed(voice, speed)
            enrolment = analyse(excerpt(played, ENROLMENT, rng), RATE)
            clips = [disturbed(excerpt(played, rng.uniform(2.5, 10), rng), others, rng) for _ in range(n)]
            features = [analyse(clip, RATE) for clip in clips]
            yield Talker(name, speed, enrolment, tuple(clip for clip in features if clip.seconds > 0.3))


def mixture(people: Sequence[Talker], seed: int) -> Background:
    """Fit the Gaussian mixtures to the frames of everybody; no cohort and no calibration yet."""
    rng = np.random.default_rng(seed)
    frames = np.concatenate([clip.cepstra for person in people for clip in (person.enrolment, *person.clips)])
    pitch = np.concatenate([clip.pitch for person in people for clip in (person.enrolment, *person.clips)])
    frames = frames[rng.choice(len(frames), min(N_FRAMES, len(frames)), replace=False)].astype(float)
    pitch = pitch[rng.choice(len(pitch), min(N_FRAMES, len(pitch)), replace=False), None]
    kind = {"covariance_type": "diag", "random_state": seed, "max_iter": 200, "tol": 3e-3, "reg_covar": 1e-3}
    voices, tones = GaussianMixture(N_GAUSSIANS, **kind).fit(frames), GaussianMixture(N_PITCHES, **kind).fit(pitch)
    return Background(
        weights=voices.weights_,
        means=voices.means_,
        deviations=np.sqrt(voices.covariances_),
        pitch_weights=tones.weights_,
        pitch_means=tones.means_[:, 0],
        pitch_deviations=np.sqrt(tones.covariances_[:, 0]),
        relevance=np.array(RELEVANCE),
        cohort=np.zeros((0, N_GAUSSIANS, 2 * CEPSTRA)),
        calibration=np.array([1.0, 0.0, 0.0]),
    )


def with_cohort(background: Background, people: Sequence[Talker]) -> Background:
    """Add the cohort: everybody's offsets, rounded to bytes."""
    offsets = np.array([background.adapt(person.enrolment).offsets for person in people])
    return replace(background, cohort=np.clip(np.round(offsets / COHORT_STEP), -127, 127))


def calibrated(background: Background, voices: Sequence[TalkerVoice], draws: int, seed: int) -> Background:
    """Fit the calibration to clean and separated recordings of mixtures of ``voices``, at their own rate.

    Targets and strangers weigh the same. A talker is kept out of the cohort (its first rows, COHORT_SPEEDS of each
    voice) while trials with this talker's recordings or print are made: in the field it knows neither of them.
    """
    rng = np.random.default_rng(seed)
    names = np.repeat([voice.name for voice in voices], len(COHORT_SPEEDS))
    owners = np.append(names, [""] * (len(background.cohort) - len(names)))
    prints = {voice.name: background.adapt(analyse(voice.enrolment, voice.rate)) for voice in voices}
    evidence, same = [], []
    for _ in range(draws):
        for _, _, _, talker, signal in scenes(voices, "S1", rng):
            clip = analyse(signal, voices[0].rate)
            for name, voice in prints.items():
                alone = replace(background, cohort=background.cohort[(owners != name) & (owners != talker)])
                evidence.append(reliability(clip) * np.append(alone.evidence(voice, clip), 1))
                same.append(name == talker)
    fit = LogisticRegression(fit_intercept=False, class_weight="balanced", C=100.0).fit(np.array(evidence), same)
    return replace(background, calibration=fit.coef_[0])


def train(speech: dict[str, Real], seed: int, n_clips: int = 24) -> Background:
    """Train a background model on recordings (n,) by name, and on synthetic voices; it is not calibrated yet."""
    rng = np.random.default_rng(seed)
    drawn = {recipe.name: synthetic(recipe, index) for index, recipe in enumerate(recipes(N_SYNTHETIC, rng))}
    real = tuple(talkers(speech, SPEEDS, n_clips, rng))
    made = tuple(talkers(drawn, SYNTHETIC_SPEEDS, n_clips // 3, rng))
    background = mixture((*real, *made), seed)
    return with_cohort(background, [*(person for person in real if person.speed in COHORT_SPEEDS), *made[::4]])


def trained(folder: Path, leave_out: Sequence[str], seed: int) -> Background:
    """Train on the talkers of a folder but those left out, and calibrate with mixtures of the same talkers."""
    known = [voice for voice in load_folder(folder, RATE) if voice.name not in leave_out]
    background = train({voice.name: voice.speech.astype(float) for voice in known}, seed)
    heard = [voice for voice in load_folder(folder, MIXTURE_RATE) if voice.name not in leave_out]
    return calibrated(background, heard, N_MIXTURES, seed)


def main(arguments: Sequence[str] | None = None) -> int:
    """Train and write the model."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--speech", type=Path, required=True, help="folder of talkers")
    parser.add_argument("--leave-out", nargs="*", default=list(OUTSIDE), help="talkers not to train on")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("out", type=Path, help="where the model goes (.npz)")
    asked = parser.parse_args(arguments)
    with threadpool_limits(1):
        content = encode_background(trained(asked.speech, asked.leave_out, asked.seed))
    asked.out.write_bytes(content)
    values = read_background(content, asked.out.name).calibration.round(3)
    sys.stdout.write(f"{asked.out.name}: {len(content) / 1000:.0f} kB, calibration {values}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
