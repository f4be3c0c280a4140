"""How well the voice print tells separated talkers apart: ``python -m ross_sim.study.voiceprint_study``.

Three talkers stand around the array in each room of `--rooms`, white noise 15 dB below the mixture, azimuths known.
The array turns to each talker's best heading, the separator `auto` separates what it hears for T_check or T_run, and
the group that holds this talker is scored against the print of everybody in the folder, enrolled from a clean clip, or
with ``--enrol pointed`` from what is separated of another such mixture, as the order to enrol does. In brackets: 95 %
intervals by drawing whole mixtures anew.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ross_payload.alignment.predicted_gain import best_headings
from ross_payload.config import Exploit
from ross_payload.dsp.stft import Stft
from ross_payload.errors import AudioError
from ross_payload.interfaces import Clip, Real
from ross_payload.separation.auto_separator import separator
from ross_payload.voiceprint import EmbeddingPrint, VoiceModel, enrol, model_folder
from ross_payload.voiceprint.built_in import read_model
from ross_payload.voiceprint.dominance import dominant
from ross_payload.voiceprint.features import RATE as VOICE_RATE
from ross_payload.voiceprint.features import at_rate
from ross_sim.study.mixtures import FRAME, HOP, RATE, excerpt, layouts, record, scene_of
from ross_sim.study.option_types import NATURAL, POSITIVE, argument
from ross_sim.study.room_settings import SETTINGS, Setting
from ross_sim.study.script_errors import told_by
from ross_sim.talkers.speech import TalkerVoice, load_folder
from ross_sim.talkers.synthetic_voices import synthetic_voices

DURATIONS = (3.0, 10.0)  # T_check, T_run [s]
CRITERION = Exploit().criterion  # of missions, unless it is set [nat]
TALKERS = 3
REDRAWN = 1000  # times, for intervals
COLUMNS = ("false rejects", "false accepts", "EER", "identified", "mixtures rejected")
ROOMS = ("S1", "S2", "S3", "A0.45")
OUTSIDE = ("ls3005", "ls3331", "ls2414", "ls3080", "ls533")  # whom no model was trained or chosen on


@dataclass(frozen=True, slots=True)
class Trial:
    """One recording, alone or separated, against one print."""

    room: str
    scene: int  # trials with one number come from one mixture
    seconds: float
    separated: bool
    talker: str
    print_of: str
    present: bool  # the enrolled talker is in the mixture
    value: float  # [nat]


def equal_error_rate(targets: Real, strangers: Real) -> float:
    """Share of errors at the threshold where rejected targets (n,) and accepted strangers (m,) are as frequent.

    >>> equal_error_rate(np.array([1.0, 2, 3, 4]), np.array([-3.0, -2, -1, 1.5]))
    0.25
    """
    thresholds = np.sort(np.concatenate([targets, strangers]))
    rejected = np.searchsorted(np.sort(targets), thresholds, side="right") / targets.size
    accepted = 1 - np.searchsorted(np.sort(strangers), thresholds, side="right") / strangers.size
    best = int(np.argmin(np.abs(rejected - accepted)))
    return float((rejected[best] + accepted[best]) / 2)


def trials(
    voices: Sequence[TalkerVoice], model: VoiceModel, room: str, draws: int, seed: int, *, pointed: bool = False
) -> Iterator[Trial]:
    """Draw mixtures of three talkers in a room and score every talker, clean and separated, against every print."""
    rng = np.random.default_rng(seed)
    prints = {}
    for voice in voices:
        with suppress(AudioError):  # who says too little to be enrolled is heard all the same
            prints[voice.name] = enrol(voice.enrolment, voice.rate, model)
    if pointed:
        own = np.random.default_rng([seed, 1])  # the mixtures to be scored are those of clean prints
        prints = {voice.name: pointed_print(voices, voice, room, model, own) for voice in voices}
    for scene in range(draws):
        for seconds, separated, chosen, talker, clip in scenes(voices, room, rng):
            heard = at_rate(clip.samples, RATE)
            embedding = model.embed(heard)
            for name, one in prints.items():
                present = any(other.name == name for other in chosen)
                value = one.compared(embedding, len(heard) / VOICE_RATE, clip.poorness).value
                yield Trial(room, scene, seconds, separated, talker, name, present, value)


def scenes(
    voices: Sequence[TalkerVoice], room: str, rng: np.random.Generator, *, whole: bool = False
) -> Iterator[tuple[float, bool, list[TalkerVoice], str, Clip]]:
    """Draw one mixture: duration [s], separated or clean, who is in it, whose recording, the recording.

    Of separated voices that is what a mission compares, or the ``whole``.
    """
    chosen = [voices[int(i)] for i in rng.choice(len(voices), TALKERS, replace=False)]
    azimuths = layouts(TALKERS, 1, rng)[1]
    clips = [excerpt(voice.speech, round(max(DURATIONS) * RATE), rng) for voice in chosen]
    for seconds in DURATIONS:
        heard = [clip[: round(seconds * RATE)] for clip in clips]
        for index, voice in enumerate(chosen):
            yield seconds, False, chosen, voice.name, Clip(heard[index])
            clip = separated_voice(heard, azimuths, index, SETTINGS[room], rng, whole=whole)
            yield seconds, True, chosen, voice.name, clip


def pointed_print(
    voices: Sequence[TalkerVoice], talker: TalkerVoice, room: str, model: VoiceModel, rng: np.random.Generator
) -> EmbeddingPrint:
    """Enrol a talker among two others in a room: the clip of a clean enrolment, separated at the best heading."""
    others = [voice for voice in voices if voice.name != talker.name]
    chosen = [others[int(i)] for i in rng.choice(len(others), TALKERS - 1, replace=False)]
    size = min(len(talker.enrolment), round(max(DURATIONS) * RATE))
    clips = [talker.enrolment[:size], *(excerpt(voice.speech, size, rng) for voice in chosen)]
    azimuths = layouts(TALKERS, 1, rng)[1]
    voice = separated_voice(clips, azimuths, 0, SETTINGS[room], rng)
    return enrol(voice.samples, RATE, model, separated=True)


def values_of(part: Sequence[Trial]) -> tuple[Real, Real]:
    """Return the values of those who are whom they are compared with, (n,), and of strangers, (m,)."""
    same = np.array([trial.talker == trial.print_of for trial in part], bool)
    values = np.array([trial.value for trial in part])
    return values[same], values[~same]


def errors(targets: Real, strangers: Real) -> Real:
    """Return false rejects and false accepts at the criterion, and the equal error rate, (3,)."""
    return np.array(
        [np.mean(targets <= CRITERION), np.mean(strangers > CRITERION), equal_error_rate(targets, strangers)]
    )


def intervals(part: Sequence[Trial]) -> Real:
    """Return where 95 % of `errors` lie when whole mixtures are drawn anew with replacement, (2, 3)."""
    mixtures: dict[tuple[str, int], list[Trial]] = {}
    for trial in part:
        mixtures.setdefault((trial.room, trial.scene), []).append(trial)
    values = [values_of(trials) for trials in mixtures.values()]
    rng, found = np.random.default_rng(0), []
    for _ in range(REDRAWN):
        drawn = rng.integers(len(values), size=len(values))
        targets, strangers = (np.concatenate([values[index][kind] for index in drawn]) for kind in (0, 1))
        if targets.size and strangers.size:
            found.append(errors(targets, strangers))
    return np.asarray(np.percentile(found, [2.5, 97.5], axis=0))


def summary(found: Sequence[Trial]) -> list[str]:
    """Lines of a table: errors at the criterion, equal error rate, identification, mixtures without the target.

    The last lines are of all rooms but the open one together, when there are several.
    """
    lines = [f"{'':21s}" + "".join(f"{name:>18s}" for name in COLUMNS)]
    parts: dict[tuple[str, bool, float], list[Trial]] = {}
    for trial in found:
        parts.setdefault((trial.room, trial.separated, trial.seconds), []).append(trial)
    for room, separated, seconds in list(parts):
        if SETTINGS[room].t60:
            parts.setdefault(("rooms", separated, seconds), []).extend(parts[room, separated, seconds])
    several = len({room for room, *_ in parts if room != "rooms" and SETTINGS[room].t60}) > 1
    for (room, separated, seconds), part in parts.items():
        if room != "rooms" or several:
            lines.append(f"{room:5s} {'separated' if separated else 'clean':9s} {seconds:3.0f} s {_row(part)}")
    return lines


def _row(part: Sequence[Trial]) -> str:
    rivals: dict[tuple[str, int, str], list[Trial]] = {}
    for trial in part:
        rivals.setdefault((trial.room, trial.scene, trial.print_of), []).append(trial)
    best = [max(group, key=lambda trial: trial.value) for group in rivals.values()]
    right = [trial.talker == trial.print_of for trial in best if trial.present]
    rejected = [trial.value <= CRITERION for trial in best if not trial.present]
    low, high = intervals(part)
    cells = [
        f"{100 * share:.1f} ({100 * least:.0f}-{100 * most:.0f})"
        for share, least, most in zip(errors(*values_of(part)), low, high, strict=True)
    ]
    cells += [f"{100 * float(np.mean(shares)):.1f}" if shares else "-" for shares in (right, rejected)]
    targets = sum(trial.talker == trial.print_of for trial in part)
    return "".join(f"{cell:>18s}" for cell in cells) + f"   ({targets} targets, {len(part) - targets} strangers)"


def separated_voice(
    voices: Sequence[Real],
    azimuths: Real,
    target: int,
    setting: Setting,
    rng: np.random.Generator,
    *,
    whole: bool = False,
) -> Clip:
    """Separate one of several talkers (n,) each at ``azimuths`` [rad] at its best heading in a room.

    Returned is what a mission compares, or the ``whole`` voice.
    """
    heading = best_heading(azimuths, target, setting)
    return separated_at(heading, voices, azimuths, target, setting=setting, rng=rng, whole=whole)


def best_heading(azimuths: Real, target: int, setting: Setting) -> float:
    """Return the heading [rad] at which one of the talkers at ``azimuths`` [rad] gains most in a room."""
    return float(best_headings(azimuths, directness=float(setting.t60 == 0))[target])


def separated_at(
    heading: float,
    voices: Sequence[Real],
    azimuths: Real,
    target: int,
    *,
    setting: Setting,
    rng: np.random.Generator,
    softer_db: float = 0.0,
    whole: bool = False,
) -> Clip:
    """Do as `separated_voice` at any heading [rad]; the target may be softer than the others."""
    recording = record(voices, azimuths, target, heading, setting, rng=rng, softer_db=softer_db)
    stft = Stft(RATE, FRAME, HOP)
    groups = separator.batch(stft.analyse(recording.mixture), scene_of(recording, stft, known_noise=True))
    index = next(i for i, members in enumerate(groups.members) if target in members)
    separated = stft.synthesise(groups.signals, recording.mixture.shape[1])
    return Clip(separated[index]) if whole else dominant(separated, groups.quality, RATE)[index]


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--speech", type=Path, help="folder of talkers; default: the synthetic voices")
    parser.add_argument("--talkers", nargs="*", default=list(OUTSIDE), help="of that folder; default: all")
    parser.add_argument("--built-in", type=Path, help="another built-in model (.npz) than the one shipped")
    parser.add_argument("--model", default="built-in", help="a network that `ross voice-model add` keeps")
    parser.add_argument("--rooms", nargs="+", choices=SETTINGS, default=["S1"], help=f"such as {' '.join(ROOMS)}")
    parser.add_argument("--enrol", choices=("clean", "pointed"), default="clean", help="what prints are made from")
    parser.add_argument("--draws", type=argument(POSITIVE), default=20, help="mixtures in every room")
    parser.add_argument("--seed", type=argument(NATURAL), default=0)
    asked = parser.parse_args(arguments)
    with told_by(parser):
        voices = load_folder(asked.speech, RATE, asked.talkers) if asked.speech else synthetic_voices(RATE)
        model = model_folder.ModelFolder.default().in_use(asked.model)
        if asked.built_in:
            model = read_model(model_folder.read_model(asked.built_in), asked.built_in.name)
    pointed = asked.enrol == "pointed"
    found = [
        trial for room in asked.rooms for trial in trials(voices, model, room, asked.draws, asked.seed, pointed=pointed)
    ]
    sys.stdout.write("\n".join([", ".join(voice.name for voice in voices), *summary(found)]) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
