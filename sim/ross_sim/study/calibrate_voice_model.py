"""How what a network says is read: ``python -m ross_sim.study.calibrate_voice_model FILE.onnx OUT.json``.

Three and four talkers stand around the array in each room and are separated by `auto`. As a mission does, every voice
is heard for 3 s at its best heading, and for 10 s at that and two more which isolate it by half as much or more; it is
compared with the print of everybody in the folder. Logistic regression with both classes weighted alike, and all rooms
and numbers of talkers, too, gives slope and threshold at 3 and 10 s; a stranger is heard more often than the target,
and has to be `MARGIN` below. Then everybody is heard once more, 10 dB softer: those voices of which more than half is
weighed by where they dominate have a slope and a threshold of their own.
`ross voice-model add FILE.onnx --calibration OUT.json` takes the result. With `built-in` for FILE.onnx the same is told
of the built-in model, whose own calibration is that of `train_voiceprint` but for poor voices.

The network counts together with the built-in model (`ross_payload.voiceprint.embedding_model`): readers who trained
that one would be told apart too well.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from ross_payload.alignment.plan import HEADINGS, isolation
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Clip, Real
from ross_payload.mission.identify_target import APART
from ross_payload.voiceprint import VoiceModel, enrol
from ross_payload.voiceprint.built_in import built_in_model
from ross_payload.voiceprint.embedding_model import EmbeddingModel
from ross_payload.voiceprint.embedding_print import Calibration, poorness_of, unit
from ross_payload.voiceprint.features import at_rate
from ross_payload.voiceprint.model_folder import BUILT_IN, read_model
from ross_sim.study.option_types import NATURAL, POSITIVE, argument
from ross_sim.study.scenes.mixtures import RATE, excerpt, layouts
from ross_sim.study.scenes.room_settings import SETTINGS, SPACING, SPEED_OF_SOUND, Setting
from ross_sim.study.script_errors import expect_writable, told_by, write_result
from ross_sim.study.voiceprint_study import OUTSIDE, best_heading, separated_at
from ross_sim.talkers.speech import TalkerVoice, load_folder

PENALTY = 1e-5  # of the squared slope: where a network makes no mistake, its slope would have no bound
MARGIN = 2.0  # [nat]: of readers whom no network was calibrated on as many are then rejected as strangers pass ...
POOR_MARGIN = 1.0  # ... and of poor voices: 2 nat reject half of the targets where 2 % of the strangers pass
BUILT_IN_MARGIN = 0.65  # of the built-in model: as many of the folds' strangers pass at 10 s as did before ...
BUILT_IN_POOR_MARGIN = 0.5  # ... and of its poor voices
TALKERS = (3, 4)  # at a time
HEADINGS_OF = {3.0: 1, 10.0: 3}  # at how many headings a voice is heard for so long [s]
SOFTER_DB = 10.0  # than each of the others
POOR = 0.5  # `Clip.poorness` of voices that tell how poor ones are read
PLAIN = Calibration((1.0, 1.0), (0.0, 0.0))  # a score is the similarity itself


def logistic(similarity: Real, own: Real, weights: Real | None = None) -> tuple[float, float]:
    """Fit slope [nat] and threshold to similarities (n,), ``own`` (n,) where the voice was that of the print.

    Both classes count alike, unless there are ``weights`` (n,).

    >>> slope, threshold = logistic(np.array([0.1, 0.2, 0.5, 0.4, 0.6, 0.7]), np.array([0, 0, 0, 1, 1, 1]))
    >>> bool(0.4 < threshold < 0.5), bool(5 < slope < 100)
    (True, True)
    """
    from sklearn.linear_model import LogisticRegression  # noqa: PLC0415  takes a second

    alike = "balanced" if weights is None else None
    model = LogisticRegression(class_weight=alike, C=1 / (PENALTY * len(own)), max_iter=1000, tol=1e-8)
    model.fit(similarity[:, None], own, sample_weight=weights)
    slope = float(model.coef_[0, 0])
    return slope, -float(model.intercept_[0]) / slope


def calibration(model: VoiceModel, speech: Path, rooms: Sequence[str], draws: int, seed: int) -> Calibration:
    """Measure a model on the talkers of a folder but for `OUTSIDE`.

    Raises
    ------
    ConfigError
        When the folder has too few talkers.
    """
    enough = max(HEADINGS_OF) * RATE
    voices = [voice for voice in load_folder(speech, RATE) if voice.name not in OUTSIDE and len(voice.speech) > enough]
    if len(voices) < max(TALKERS):
        least = f"at least {max(TALKERS)} talkers with more than {max(HEADINGS_OF):g} s of speech beside the enrolment"
        raise ConfigError(f"{speech}: expected {least}, got {len(voices)}")
    crowd = Crowd(model, voices, {each.name: enrol(each.enrolment, each.rate, model).embedding for each in voices})
    where = [(room, talkers) for room in rooms for talkers in TALKERS]
    parts, soft = (
        [list(comparisons(crowd, room, talkers, draws, seed, softer_db=softer)) for room, talkers in where]
        for softer in (0.0, SOFTER_DB)
    )
    built_in = model.fingerprint == built_in_model().fingerprint
    margin, poor_margin = (BUILT_IN_MARGIN, BUILT_IN_POOR_MARGIN) if built_in else (MARGIN, POOR_MARGIN)
    alike = [[[each for each in part if each.seconds == seconds] for part in parts] for seconds in HEADINGS_OF]
    (short, long), (low, high) = zip(*(fitted(each, margin) for each in alike), strict=True)
    poor = [each for part in soft for each in part if each.poorness > POOR]
    known = len({each.own for each in poor}) == 2  # nobody was poor in the open
    told = f"{len(voices)} talkers, 3 and 4 at a time in {', '.join(rooms)}, {draws} mixtures each, seed {seed}"
    return Calibration((short, long), (low, high), told, fitted([poor], poor_margin) if known else None)


@dataclass(frozen=True, slots=True)
class Crowd:
    """Who may be in a mixture, and what they are compared with."""

    model: VoiceModel
    voices: Sequence[TalkerVoice]
    prints: Mapping[str, Real]  # (size,), of everybody


@dataclass(frozen=True, slots=True)
class Comparison:
    """A separated voice and a print."""

    seconds: float
    similarity: float
    own: bool  # the print is of this talker
    poorness: float = 0.0  # `Clip.poorness` of the voice


def comparisons(
    crowd: Crowd, room: str, talkers: int, draws: int, seed: int, *, softer_db: float = 0.0
) -> Iterator[Comparison]:
    """Draw mixtures of so many talkers in a room, and compare every separated voice with every print.

    Everybody in turn is softer than the others.
    """
    rng = np.random.default_rng([seed, talkers])
    for _ in range(draws):
        chosen = [crowd.voices[int(i)] for i in rng.choice(len(crowd.voices), talkers, replace=False)]
        azimuths = layouts(talkers, 1, rng)[1]
        said = [excerpt(voice.speech, round(max(HEADINGS_OF) * RATE), rng) for voice in chosen]
        for target, voice in enumerate(chosen):
            for seconds, clips in heard_of(target, said, azimuths, SETTINGS[room], rng, softer_db=softer_db):
                embeddings = [len(clip.samples) * crowd.model.embed(at_rate(clip.samples, RATE)) for clip in clips]
                embedding = unit(np.sum(embeddings, axis=0))
                if not embedding.any():
                    continue
                poorness = poorness_of(clips)
                for name, print_ in crowd.prints.items():
                    alike = crowd.model.similarity(print_, embedding)
                    yield Comparison(seconds, alike, name == voice.name, poorness)


def heard_of(
    target: int,
    said: Sequence[Real],
    azimuths: Real,
    setting: Setting,
    rng: np.random.Generator,
    *,
    softer_db: float,
) -> Iterator[tuple[float, list[Clip]]]:
    """Separate one of the talkers at ``azimuths`` [rad] who have said so much (n,); durations [s] and clips of each."""
    headings = headings_for(azimuths, target, setting, rng)
    for seconds, count in HEADINGS_OF.items():
        size = round(seconds * RATE / count)
        parts = [[clip[n * size : (n + 1) * size] for clip in said] for n in range(count)]
        yield (
            seconds,
            [
                separated_at(heading, part, azimuths, target, setting=setting, rng=rng, softer_db=softer_db)
                for heading, part in zip(headings, parts, strict=False)
            ],
        )


def headings_for(azimuths: Real, target: int, setting: Setting, rng: np.random.Generator) -> list[float]:
    """Draw headings [rad] at which a mission would hear a talker: the best one, and others that isolate enough."""
    curve = isolation(azimuths, HEADINGS, SPACING, SPEED_OF_SOUND)[target]
    clear = HEADINGS[curve >= APART * curve.max()]
    others = rng.choice(clear, max(HEADINGS_OF.values()) - 1).tolist()
    return [best_heading(azimuths, target, setting), *others]


def fitted(parts: Sequence[Sequence[Comparison]], margin: float) -> tuple[float, float]:
    """Fit slope [nat] and threshold to parts that count alike, as targets and strangers do.

    Strangers have to be ``margin`` [nat] below.
    """
    counts = [Counter(each.own for each in part) for part in parts]
    weights = [[1 / count[each.own] for each in part] for part, count in zip(parts, counts, strict=True)]
    every = [each for part in parts for each in part]
    similarity, own = np.array([each.similarity for each in every]), np.array([each.own for each in every])
    slope, threshold = logistic(similarity, own, np.concatenate(weights) * len(every) / (2 * len(parts)))
    return round(slope, 1), round(threshold + margin / slope, 3)


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, and write the calibration."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", type=Path, metavar="FILE.onnx", help=f"or {BUILT_IN}")
    parser.add_argument("out", type=Path, metavar="OUT.json")
    parser.add_argument("--speech", type=Path, required=True, help="folder of talkers; the more, the better")
    parser.add_argument("--rooms", nargs="+", choices=SETTINGS, default=["S2", "A0.45", "B0.45"])
    parser.add_argument(
        "--draws", type=argument(POSITIVE), default=20, help="mixtures in every room, of three and of four talkers"
    )
    parser.add_argument("--seed", type=argument(NATURAL), default=0)
    asked = parser.parse_args(arguments)
    with told_by(parser):
        expect_writable(asked.out)
        found = calibration(_model(asked.file), asked.speech, asked.rooms, asked.draws, asked.seed)
        write_result(asked.out, (json.dumps(asdict(found)) + "\n").encode())
    sys.stdout.write(f"{found}\n")
    return 0


def _model(file: Path) -> VoiceModel:
    if str(file) == BUILT_IN:
        return built_in_model()
    return EmbeddingModel(read_model(file), str(file), PLAIN)


if __name__ == "__main__":
    sys.exit(main())
