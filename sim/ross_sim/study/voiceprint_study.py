"""How well the voice print tells separated talkers apart: ``python -m ross_sim.study.voiceprint_study``.

Three talkers stand around the array in each room of `--rooms`, white noise 15 dB below the mixture, azimuths known.
The array turns to each talker's best heading, the separator `auto` separates what it hears for T_check or T_run, and
the group that holds this talker is scored against the print of everybody in the folder, enrolled from a clean clip, or
with ``--enrol pointed`` from what is separated of another such mixture, as the order to enrol does.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ross_payload.alignment.predicted_gain import best_headings
from ross_payload.dsp.stft import Stft
from ross_payload.errors import AudioError
from ross_payload.interfaces import Clip, Real
from ross_payload.separation.auto_separator import separator
from ross_payload.voiceprint import EmbeddingPrint, VoiceModel, enrol, model_folder
from ross_payload.voiceprint.built_in import read_model
from ross_payload.voiceprint.dominance import dominant
from ross_payload.voiceprint.features import RATE as VOICE_RATE
from ross_payload.voiceprint.features import at_rate
from ross_sim.study.option_types import NATURAL, POSITIVE, argument
from ross_sim.study.rows.row_files import as_csv
from ross_sim.study.rows.voice_print_rows import VoicePrintRow, split, voice_prints
from ross_sim.study.scenes.mixtures import FRAME, HOP, RATE, excerpt, layouts, record, scene_of
from ross_sim.study.scenes.room_settings import SETTINGS, Setting
from ross_sim.study.script_errors import expect_writable, told_by, write_result
from ross_sim.talkers.speech import TalkerVoice, load_folder
from ross_sim.talkers.synthetic_voices import synthetic_voices

DURATIONS = (3.0, 10.0)  # T_check, T_run [s]
TALKERS = 3
ROOMS = ("S1", "S2", "S3", "A0.45")
OUTSIDE = ("ls3005", "ls3331", "ls2414", "ls3080", "ls533")  # whom no model was trained or chosen on


def measured(
    voices: Sequence[TalkerVoice],
    models: Mapping[str, VoiceModel],
    room: str,
    draws: int,
    seed: int,
    *,
    pointed: bool = False,
) -> Iterator[VoicePrintRow]:
    """Draw mixtures of three talkers in a room; compare every separated voice with every print of every model."""
    rng = np.random.default_rng(seed)
    prints = {name: _prints(voices, model, room, seed, pointed=pointed) for name, model in models.items()}
    for mixture in range(draws):
        heard = [each for each in scenes(voices, room, rng) if each[1]]  # not the clean ones
        for seconds in DURATIONS:
            clips = [(talker, clip) for duration, _, _, talker, clip in heard if duration == seconds]
            for name, model in models.items():
                found = split(*_compared(clips, model, prints[name]))
                yield VoicePrintRow(name, room, seed, mixture, seconds, *found)


def _prints(
    voices: Sequence[TalkerVoice], model: VoiceModel, room: str, seed: int, *, pointed: bool
) -> dict[str, EmbeddingPrint]:
    """Prints by talker; who says too little to be enrolled has none, and is heard all the same."""
    if pointed:
        own = np.random.default_rng([seed, 1])  # the mixtures to be scored are those of clean prints
        return {voice.name: pointed_print(voices, voice, room, model, own) for voice in voices}
    prints = {}
    for voice in voices:
        with suppress(AudioError):
            prints[voice.name] = enrol(voice.enrolment, voice.rate, model)
    return prints


def _compared(
    clips: Sequence[tuple[str, Clip]], model: VoiceModel, prints: Mapping[str, EmbeddingPrint]
) -> tuple[Real, NDArray[np.bool_]]:
    """What every print says of every voice [nat], and whether it is the talker's own, (n,) each."""
    values, same = [], []
    for talker, clip in clips:
        heard = at_rate(clip.samples, RATE)
        embedding = model.embed(heard)
        for name, one in prints.items():
            values.append(one.compared(embedding, len(heard) / VOICE_RATE, clip.poorness).value)
            same.append(name == talker)
    return np.array(values), np.array(same, bool)


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
    parser.add_argument("--models", nargs="+", default=["built-in"], help="built-in, or what `ross voice-model` keeps")
    parser.add_argument("--rooms", nargs="+", choices=SETTINGS, default=["S1"], help=f"such as {' '.join(ROOMS)}")
    parser.add_argument("--enrol", choices=("clean", "pointed"), default="clean", help="what prints are made from")
    parser.add_argument("--draws", type=argument(POSITIVE), default=20, help="mixtures in every room")
    parser.add_argument("--seeds", nargs="+", type=argument(NATURAL), default=[0])
    parser.add_argument("--out", type=Path, help="file for the rows (.csv), for `ross study table`")
    asked = parser.parse_args(arguments)
    with told_by(parser):
        if asked.out:
            expect_writable(asked.out)
        voices = load_folder(asked.speech, RATE, asked.talkers) if asked.speech else synthetic_voices(RATE)
        models = {name: model_folder.ModelFolder.default().in_use(name) for name in asked.models}
        if asked.built_in:
            models = {asked.built_in.name: read_model(model_folder.read_model(asked.built_in), asked.built_in.name)}
    pointed = asked.enrol == "pointed"
    found = [
        row
        for seed in asked.seeds
        for room in asked.rooms
        for row in measured(voices, models, room, asked.draws, seed, pointed=pointed)
    ]
    if asked.out:
        with told_by(parser):
            write_result(asked.out, as_csv(found, VoicePrintRow))
    sys.stdout.write(f"{', '.join(voice.name for voice in voices)}\n\n{voice_prints(found).markdown()}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
