"""How the cosines of a network are read: ``python -m ross_sim.study.calibrate_voice_model FILE.onnx OUT.json``.

As in `ross_sim.study.voiceprint_study`, three talkers stand around the array in each room and are separated by `auto`
at their best headings; every separated voice is compared with the print of everybody in the folder. Logistic
regression with both classes weighted alike gives slope and threshold at 3 and 10 s; a stranger is heard more often
than the target, and has to be `MARGIN` below. `ross voice-model add FILE.onnx --calibration OUT.json` takes the result.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np

from ross_payload.atomic_files import write_whole
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Real
from ross_payload.voiceprint.embedding_model import EmbeddingModel
from ross_payload.voiceprint.embedding_print import Calibration
from ross_payload.voiceprint.model_folder import read_model
from ross_sim.study.mixtures import RATE
from ross_sim.study.room_settings import SETTINGS
from ross_sim.study.voiceprint_study import DURATIONS, OUTSIDE, TALKERS, trials
from ross_sim.talkers.speech import load_folder

PENALTY = 1e-5  # of the squared slope: where a network makes no mistake, its slope would have no bound
MARGIN = 1.0  # [nat]
COSINES = Calibration((1.0, 1.0), (0.0, 0.0))  # scores are the cosines themselves


def logistic(cosines: Real, own: Real, weights: Real | None = None) -> tuple[float, float]:
    """Fit slope [nat] and threshold to cosines (n,), ``own`` (n,) where the voice was that of the print.

    Both classes count alike, unless there are ``weights`` (n,).

    >>> slope, threshold = logistic(np.array([0.1, 0.2, 0.5, 0.4, 0.6, 0.7]), np.array([0, 0, 0, 1, 1, 1]))
    >>> bool(0.4 < threshold < 0.5), bool(5 < slope < 100)
    (True, True)
    """
    from sklearn.linear_model import LogisticRegression  # noqa: PLC0415  takes a second

    alike = "balanced" if weights is None else None
    model = LogisticRegression(class_weight=alike, C=1 / (PENALTY * len(own)), max_iter=1000, tol=1e-8)
    model.fit(cosines[:, None], own, sample_weight=weights)
    slope = float(model.coef_[0, 0])
    return slope, -float(model.intercept_[0]) / slope


def calibration(model: EmbeddingModel, speech: Path, rooms: Sequence[str], draws: int, seed: int) -> Calibration:
    """Measure a network whose scores are cosines, `COSINES`, on the talkers of a folder but for `OUTSIDE`.

    Raises
    ------
    ConfigError
        When the folder has too few talkers.
    """
    enough = max(DURATIONS) * RATE
    voices = [voice for voice in load_folder(speech, RATE) if voice.name not in OUTSIDE and len(voice.speech) > enough]
    if len(voices) < TALKERS:
        least = f"at least {TALKERS} talkers with more than {max(DURATIONS):g} s of speech beside the enrolment"
        raise ConfigError(f"{speech}: expected {least}, got {len(voices)}")
    found = [trial for room in rooms for trial in trials(voices, model, room, draws, seed) if trial.separated]
    slopes, thresholds = [], []
    for seconds in DURATIONS:
        part = [trial for trial in found if trial.seconds == seconds]
        own = np.array([trial.talker == trial.print_of for trial in part])
        slope, threshold = logistic(np.array([trial.value for trial in part]), own)
        slopes.append(round(slope, 1))
        thresholds.append(round(threshold + MARGIN / slope, 3))
    told = f"{len(voices)} talkers in {', '.join(rooms)}, {draws} mixtures each, seed {seed}"
    return Calibration((slopes[0], slopes[1]), (thresholds[0], thresholds[1]), told)


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, and write the calibration."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", type=Path, metavar="FILE.onnx")
    parser.add_argument("out", type=Path, metavar="OUT.json")
    parser.add_argument("--speech", type=Path, required=True, help="folder of talkers; the more, the better")
    parser.add_argument("--rooms", nargs="+", choices=SETTINGS, default=["S2", "A0.45"])
    parser.add_argument("--draws", type=int, default=20, help="mixtures in every room")
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args(arguments)
    try:
        model = EmbeddingModel(read_model(asked.file), str(asked.file), COSINES)
        found = calibration(model, asked.speech, asked.rooms, asked.draws, asked.seed)
    except ConfigError as error:
        parser.error(str(error))
    write_whole(asked.out, (json.dumps(asdict(found)) + "\n").encode())
    sys.stdout.write(f"{found}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
