"""Talkers who rest while the array listens: how often the tracker wrongly says that somebody has moved.

``python -m ross_sim.study.resting_talkers --speech DIR [--settings S1,S2,A0.45] [--k 3,4] [--draws 8] [--seed S]
[--unexplored] [--out ROWS.csv]``

K talkers speak for 16 s around an array that rests at the best heading for one of them. The tracker begins with their
azimuths, wrong by as much as an exploration of that room is, and with the directness that one tells of it (`TOLD`);
``--unexplored``: with azimuths alone, as somebody tells them.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ross_payload.alignment.predicted_gain import best_headings
from ross_payload.angles import difference, wrap
from ross_payload.dsp.noise import quiet_psd
from ross_payload.dsp.stft import short_frames
from ross_payload.events import Estimate, SourceEstimate
from ross_payload.interfaces import Real, Samples
from ross_payload.localization import tracking
from ross_payload.localization.phase_statistics import FrameStatistics, statistics
from ross_payload.mission.source_tracking import ECHOES, UPDATE, SourceTracker
from ross_sim.study.option_types import NATURAL, POSITIVE, CommaSeparated, argument
from ross_sim.study.rows.resting_rows import RestingRow, resting
from ross_sim.study.rows.result_rows import number
from ross_sim.study.rows.row_files import as_csv
from ross_sim.study.scenes.exploration import render
from ross_sim.study.scenes.mixtures import SNR_DB, spread
from ross_sim.study.scenes.room_settings import SETTINGS, SPACING, SPEED_OF_SOUND
from ross_sim.study.script_errors import expect_writable, told_by, write_result
from ross_sim.talkers.synthetic_voices import voices_of

RATE = 16000  # [Hz]
STFT = short_frames(RATE)  # as the payload tracks
SECONDS, LEAD_IN = 16.0, 2  # heard, and noise alone before that [s]
TOLD = {"S1": (1.0, 0.3), "S2": (0.953, 0.4), "A0.3": (0.85, 0.8), "A0.45": (0.8, 1.0), "B0.45": (0.68, 2.0)}
KS = ("1", "2", "3", "4", "5")
SIGMA = np.radians(1.0)  # that is told with the azimuths [rad]


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """Talkers at rest, and what is heard of them."""

    setting: str
    azimuths: Real  # [rad], (k,)
    heading: float  # [rad]
    heard: tuple[FrameStatistics, ...]  # every `UPDATE`


def scene_of(setting: str, k: int, seed: int, voices: Sequence[Samples], seconds: float = SECONDS) -> Scene:
    """Let random talkers speak in a room, and pick the trustworthy bins of what is heard."""
    rng = np.random.default_rng([seed, k])
    azimuths = spread(k, rng)
    chosen = [voices[index] for index in rng.permutation(len(voices))[:k]]
    heading = float(best_headings(azimuths, directness=TOLD[setting][0])[0])
    mixture = render(chosen, azimuths, SETTINGS[setting], np.array([heading]), rng, seconds=seconds, rate=RATE)[0]
    spectrogram = STFT.analyse(mixture.astype(np.float32))
    level = np.sqrt(np.mean(mixture**2) / (1 + 10 ** (SNR_DB / 10)))
    lead_in = (level * rng.standard_normal((2, LEAD_IN * RATE))).astype(np.float32)
    noise = quiet_psd(STFT.analyse(lead_in), spectrogram)
    step, echoes = round(UPDATE / STFT.period), round(ECHOES / STFT.period)
    heard = []
    for first in range(0, spectrogram.shape[-1] - step + 1, step):
        skip = min(first, echoes)
        frames, still = spectrogram[:, :, first - skip : first + step], np.full(step + skip, heading)
        heard.append(statistics(frames, STFT.frequencies, still, noise, period=STFT.period, skip=skip))
    return Scene(setting, azimuths, heading, tuple(heard))


def tracked(scene: Scene, seed: int, *, directness: float | None = None, explored: bool = True) -> RestingRow:
    """Let the tracker hear a scene; ``directness``: told instead of what an exploration tells of such a room.

    If it was not ``explored`` nothing is told of the room.
    """
    told, error_deg = TOLD[scene.setting]
    errors = np.random.default_rng([seed, len(scene.azimuths), 1]).normal(
        0.0, np.radians(error_deg), scene.azimuths.size
    )
    sources = tuple(
        SourceEstimate(wrap(float(azimuth)), SIGMA, confidence=1.0, resolved=True)
        for azimuth in scene.azimuths + errors
    )
    known = (told if directness is None else directness) if explored else None
    anchor = Estimate(sources, certain=True, directness=known)
    tracker = SourceTracker(anchor, 0, STFT, SPACING, SPEED_OF_SOUND, None, None)
    time, first, said, worst = 0.0, None, 0, 0.0
    for heard in scene.heard:
        time += heard.seconds
        tracker.tracks = tracking.step(tracker.tracks, heard)
        tracker.corrected(time)
        if tracker.acts:
            first, said = time if first is None else first, said + 1
            off = np.abs(difference(tracker.tracks.azimuths, scene.azimuths))[tracker.moved]
            worst = max(worst, float(np.degrees(off.max())))
    return RestingRow(scene.setting, anchor.k, seed, explored, first, number(said / len(scene.heard)), number(worst))


def main(arguments: Sequence[str]) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--speech", type=Path, help="folder of recordings; default: synthetic voices")
    parser.add_argument(
        "--settings", type=argument(CommaSeparated()), default=",".join(TOLD), help="rooms, separated by commas"
    )
    parser.add_argument(
        "--k", type=argument(CommaSeparated()), default="3,4", help="numbers of talkers, separated by commas"
    )
    parser.add_argument("--draws", type=argument(POSITIVE), default=8)
    parser.add_argument(
        "--seed", type=argument(NATURAL), default=0, help="of the first draw; the next have the next seeds"
    )
    parser.add_argument("--unexplored", action="store_true", help="azimuths are told, and nothing of the room")
    parser.add_argument("--out", type=Path, help="file for the rows (.csv), for `ross study table`")
    given = parser.parse_args(arguments)
    settings, ks = given.settings, given.k
    for name, found, allowed in (("settings", settings, TOLD), ("k", ks, KS)):
        if unknown := [each for each in found if each not in allowed]:
            parser.error(f"--{name}: expected some of {', '.join(allowed)}, got '{unknown[0]}'")
    with told_by(parser):
        if given.out:
            expect_writable(given.out)
        voices = [voice.speech for voice in voices_of(given.speech, RATE)]
    if len(voices) < max(map(int, ks)):
        parser.error(f"--speech: expected {max(map(int, ks))} talkers or more, got {len(voices)}")
    seeds = range(given.seed, given.seed + given.draws)
    rows = [
        tracked(scene_of(setting, int(k), seed, voices), seed, explored=not given.unexplored)
        for setting in settings
        for k in ks
        for seed in seeds
    ]
    sys.stdout.write(resting(rows).markdown())
    if given.out:
        with told_by(parser):
            write_result(given.out, as_csv(rows, RestingRow))


if __name__ == "__main__":
    main(sys.argv[1:])
