"""Who talks in a study: recordings of a folder or the synthetic voices, and who stands where in a layout."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from ross_payload.errors import ConfigError, unknown
from ross_payload.interfaces import Real, Samples
from ross_sim.study.runs.study_design import Study, Task
from ross_sim.study.scenes.mixtures import VOICES, is_silent, layouts
from ross_sim.study.scenes.room_settings import SETTINGS, Setting
from ross_sim.talkers.speech import TalkerVoice, load_folder
from ross_sim.talkers.synthetic_voices import voices_of as read_voices

FEW = 5  # voices: up to so many stand in the order in which they are named
EXPLORED = 5.0  # least speech beside T_run [s]: what is explored with is never what is separated


@dataclass(frozen=True, slots=True)
class Source:
    """Where voices come from: a small value that any process can read them with."""

    folder: Path | None  # None: the synthetic voices
    talkers: tuple[str, ...]  # in this order; none: all of the folder
    rate: int  # [Hz]


@dataclass(frozen=True, slots=True, eq=False)
class TalkerPlacement:
    """One layout in one room."""

    setting: Setting
    azimuths: Real  # [rad], (k,)
    names: tuple[str, ...]
    clips: tuple[Samples, ...]  # T_run of every talker, to separate, (n,)
    speech: tuple[Samples, ...]  # the rest of every talker, to explore with


@lru_cache(maxsize=2)
def voices_of(source: Source) -> tuple[TalkerVoice, ...]:
    """Read the voices, once in every process.

    Raises
    ------
    ConfigError
        When the folder cannot be used or lacks one of the talkers.
    """
    found = read_voices(source.folder, source.rate)
    by_name = {voice.name: voice for voice in found}
    for name in source.talkers:
        if name not in by_name:
            where = source.folder or "the synthetic voices"
            raise ConfigError(f"{where}: {unknown('talker', name, by_name)}")
    return tuple(by_name[name] for name in source.talkers or by_name)


def standard_voices(folder: Path, rate: int, least: int) -> tuple[TalkerVoice, ...]:
    """Load the talkers of `VOICES`, in this order, from a folder that has all of them; else all that it has, by name.

    Raises
    ------
    ConfigError
        When the folder cannot be used or has fewer than ``least`` talkers.
    """
    found = load_folder(folder, rate)
    by_name = {voice.name: voice for voice in found}
    if len(found) < least:
        raise ConfigError(f"{folder}: expected {least} talkers or more, got {len(found)}: {', '.join(by_name)}")
    return tuple(by_name[name] for name in VOICES) if set(VOICES) <= set(by_name) else found


def check_voices(voices: Sequence[TalkerVoice], study: Study) -> None:
    """Check that there are enough talkers, that each speaks long enough and is not silent where he or she is used.

    Raises
    ------
    ConfigError
        Says how many or how long it must be, and is, or who is silent.
    """
    if len(voices) < max(study.k):
        raise ConfigError(f"expected {max(study.k)} talkers for K = {max(study.k)}, got {len(voices)}")
    needed = study.run_s + EXPLORED
    for voice in voices:
        if voice.speech.size < needed * study.rate_hz:
            seconds = voice.speech.size / study.rate_hz
            raise ConfigError(f"talker '{voice.name}': expected at least {needed:g} s of speech, got {seconds:.1f} s")
        cut = round(study.run_s * study.rate_hz)
        used = ((study.separators, voice.speech[:cut], "in"), (study.explorers, voice.speech[cut:], "after"))
        for by, part, where in used:
            if by and is_silent(part):
                raise ConfigError(f"talker '{voice.name}': silent {where} the first {study.run_s:g} s")


def heard_as(voices: Sequence[TalkerVoice]) -> dict[str, str]:
    """Fingerprints of the speech of every talker: the same voices, the same fingerprints, wherever they come from."""
    return {voice.name: hashlib.sha256(voice.speech.tobytes()).hexdigest()[:16] for voice in voices}


def placed(study: Study, source: Source, task: Task) -> TalkerPlacement:
    """Place the talkers of a task; layouts do not depend on the room, nor who speaks where.

    With more than five voices every layout draws its own talkers.
    """
    azimuths = layouts(task.k, task.layout, np.random.default_rng(study.seed))[task.layout]
    voices = voices_of(source)
    if len(voices) > FEW:
        drawn = np.random.default_rng([study.seed, task.layout]).permutation(len(voices))
        voices = tuple(voices[i] for i in drawn)
    chosen, n = voices[: task.k], round(study.run_s * study.rate_hz)
    return TalkerPlacement(
        SETTINGS[task.setting],
        azimuths,
        tuple(voice.name for voice in chosen),
        tuple(voice.speech[:n] for voice in chosen),
        tuple(voice.speech[n:] for voice in chosen),
    )
