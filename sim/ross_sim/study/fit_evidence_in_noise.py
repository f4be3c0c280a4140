"""Fit what `joint` tells among noise: ``python -m ross_sim.study.fit_evidence_in_noise READERS NOISE OUT.json``.

As `fit_talker_evidence`, in the scenes of `noise_scenes`: readers of the set `train`, and rotors that are made, wind,
or the propellers of NOISE played backwards and at other speeds, so that nobody has heard the recordings themselves.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from ross_payload.interfaces import Observation, Samples
from ross_payload.localization.joint import Joint
from ross_payload.localization.talker_evidence import FEATURES, IN_NOISE
from ross_sim.study.fit_talker_evidence import (
    Descent,
    count_by_regression,
    descents_of,
    encoded,
    fit_source,
    picked_by,
    report,
)
from ross_sim.study.noise_study import observed
from ross_sim.study.option_types import NATURAL, POSITIVE, argument
from ross_sim.study.scenes.mixtures import RATE
from ross_sim.study.scenes.noise_scenes import NoiseScene, recordings, scene
from ross_sim.study.scenes.room_settings import SPACING, SPEED_OF_SOUND
from ross_sim.study.script_errors import expect_writable, told_by, write_result
from ross_sim.study.training.training_voices import readers
from ross_sim.study.training.voice_augmentation import RATE as READ_AT
from ross_sim.study.training.voice_augmentation import at_speed
from ross_sim.talkers.speech import resampled

N_SCENES = 74
PENALTY = 0.1  # as of `fit_talker_evidence`: stronger, because the scenes are few
LONG_ENOUGH, N_READERS = 10.0, 60  # of speech [s]; the first of those who speak so long
KINDS = ("recorded",) * 6 + ("drifting",) * 2 + ("synthetic", "wind")
N_TALKERS, TALKER_SHARES = (0, 1, 2, 3, 4), (0.06, 0.27, 0.3, 0.3, 0.07)
RATIOS, LOUD, NOISY = (-12.0, 5.0), 20.0, 0.92  # talkers over noise [dB]; and where the noise is low, and how often not
SPEEDS = (0.85, 1.2)  # of the recordings
ROTATIONS = (4, 8)


def noisy_scenes(voices: Sequence[Samples], clips: Sequence[Samples], count: int, seed: int) -> Iterator[NoiseScene]:
    """Scenes with all kinds of noise, one after the other."""
    for index in range(count):
        rng = np.random.default_rng([seed, index])
        k = int(rng.choice(N_TALKERS, p=TALKER_SHARES))
        ratio = float(rng.uniform(*RATIOS)) if rng.random() < NOISY else LOUD
        yield scene(k, ratio, KINDS[index % len(KINDS)], voices, clips=clips, key=[seed, index])


def descents(heard: NoiseScene, seen: Sequence[Observation], joint: Joint) -> Iterator[Descent]:
    """Mixtures of falling order after some rotations."""
    return descents_of(heard.name, heard.azimuths, seen, joint, ROTATIONS)


def voices_of(folder: Path) -> list[Samples]:
    """The voices of readers who speak for long enough, (n,) each at `RATE`."""
    every = readers(folder, "train")
    able = [name for name in sorted(every) if len(every[name]) > LONG_ENOUGH * READ_AT][:N_READERS]
    return [resampled(every[name].astype(np.float32), READ_AT, RATE).astype(np.float32) for name in able]


def played(clips: Sequence[Samples]) -> list[Samples]:
    """Recordings backwards, at other speeds."""
    return [at_speed(clip[::-1].astype(float), speed).astype(np.float32) for clip in clips for speed in SPEEDS]


def main(arguments: Sequence[str] | None = None) -> int:
    """Fit, and write the weights."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, metavar="READERS", help="recordings of talkers with a MANIFEST.tsv")
    parser.add_argument("noise", type=Path, metavar="NOISE", help="recordings of propellers")
    parser.add_argument("out", type=Path, metavar="OUT.json")
    parser.add_argument("--scenes", type=argument(POSITIVE), default=N_SCENES)
    parser.add_argument("--seed", type=argument(NATURAL), default=4242)
    asked = parser.parse_args(arguments)
    with told_by(parser):
        expect_writable(asked.out)
        voices, clips = voices_of(asked.folder), played(recordings(asked.noise))
    joint = Joint(SPACING, SPEED_OF_SOUND)
    every: list[Descent] = []
    with threadpool_limits(1):
        for heard in noisy_scenes(voices, clips, asked.scenes, asked.seed):
            seen = observed(heard)
            every += [] if seen is None else descents(heard, seen, joint)
    picked = picked_by(every, partial(count_by_regression, penalty=PENALTY))
    models = {"count": count_by_regression(every, PENALTY), "source": fit_source(picked, PENALTY)}
    about = f"{len(every) // len(ROTATIONS)} scenes in the noise of a vehicle, {len(voices)} talkers, seed {asked.seed}"
    with told_by(parser):
        write_result(asked.out, encoded(models, about, FEATURES + IN_NOISE))
    sys.stdout.write(f"{about}\n{report(picked, ROTATIONS)}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
