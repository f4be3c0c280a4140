"""How well the estimated SI-SDR agrees with the truth: ``python -m ross_sim.study.quality_study``.

Two to five talkers around the array in each room, white noise 15 dB below the mixture, azimuths and noise known, 3 or
10 s long. Seven of ten recordings are heard at a talker's best heading, the others at any heading.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from ross_payload.alignment.predicted_gain import best_headings
from ross_payload.dsp.metrics import si_sdr
from ross_payload.dsp.stft import Stft
from ross_payload.separation import local_gaussian_model, refined
from ross_sim.study.option_types import NATURAL, POSITIVE, argument
from ross_sim.study.scenes.mixtures import FRAME, HOP, RATE, Mixture, excerpt, layouts, record, scene_of
from ross_sim.study.scenes.room_settings import SETTINGS
from ross_sim.study.script_errors import told_by
from ross_sim.talkers.speech import TalkerVoice
from ross_sim.talkers.synthetic_voices import voices_of

ROOMS = ("S1", "S2", "S3", "A0.45")
SEPARATORS = (local_gaussian_model.separator, refined.separator)
DURATIONS = (3.0, 10.0)  # T_check, T_run [s]
TALKERS = (2, 3, 4, 5)
ALIGNED = 0.7  # share of the recordings at the best heading


def recordings(voices: Sequence[TalkerVoice], room: str, draws: int, rng: np.random.Generator) -> Iterator[Mixture]:
    """Draw recordings in a room, ``draws`` for every number of talkers."""
    for n in np.repeat(TALKERS, draws):
        azimuths = layouts(int(n), 1, rng)[1]
        length = round(float(rng.choice(DURATIONS)) * RATE)
        clips = [excerpt(voices[int(i)].speech, length, rng) for i in rng.choice(len(voices), int(n), replace=False)]
        target = int(rng.integers(n))
        aligned = rng.random() < ALIGNED
        heading = float(best_headings(azimuths)[target]) if aligned else float(rng.uniform(0, np.pi))
        yield record(clips, azimuths, target, heading, SETTINGS[room], rng=rng)


def errors(recording: Mixture, stft: Stft) -> dict[str, list[float]]:
    """Estimate less truth [dB] of every group, by separator."""
    spectrogram, scene = stft.analyse(recording.mixture), scene_of(recording, stft, known_noise=True)
    found: dict[str, list[float]] = {}
    for separator in SEPARATORS:
        groups = separator.batch(spectrogram, scene)
        for members, signal, quality in zip(groups.members, groups.signals, groups.quality, strict=True):
            truth = recording.images[list(members), 0].sum(axis=0)
            voice = stft.synthesise(signal, recording.mixture.shape[1])
            found.setdefault(separator.name, []).append(quality.si_sdr - si_sdr(voice, truth))
    return found


def row(room: str, name: str, off: Sequence[float]) -> str:
    """One line of the table: mean, root mean square and 90th percentile of the error [dB]."""
    error = np.asarray(off)
    rms, most = np.sqrt((error**2).mean()), np.quantile(np.abs(error), 0.9)
    return f"{room:6s} {name:9s} {error.mean():+6.2f} {rms:6.2f} {most:6.2f}   ({error.size} groups)"


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--speech", type=Path, help="folder of talkers; default: the synthetic voices")
    parser.add_argument("--rooms", nargs="+", choices=SETTINGS, default=["S1"], help=f"such as {' '.join(ROOMS)}")
    parser.add_argument(
        "--draws", type=argument(POSITIVE), default=4, help="recordings for every number of talkers and room"
    )
    parser.add_argument("--seed", type=argument(NATURAL), default=0)
    asked = parser.parse_args(arguments)
    with told_by(parser):
        voices = voices_of(asked.speech, RATE)
    stft, rng = Stft(RATE, FRAME, HOP), np.random.default_rng(asked.seed)
    off: dict[tuple[str, str], list[float]] = {}
    for room in asked.rooms:
        for recording in recordings(voices, room, asked.draws, rng):
            for name, values in errors(recording, stft).items():
                off.setdefault((room, name), []).extend(values)
                off.setdefault(("all", name), []).extend(values)
    lines = ["room   method      mean    rms    p90   [dB]", *(row(*key, values) for key, values in off.items())]
    sys.stdout.write("\n".join(lines) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
