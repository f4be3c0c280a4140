"""Folders of recordings for studies: synthetic voices, cut to a few seconds."""

from collections.abc import Iterable
from pathlib import Path

import soundfile

from ross_sim.talkers.synthetic_voices import synthetic_voice

RATE = 16000


def voice_folder(folder: Path, indices: Iterable[int], seconds: int) -> Path:
    """Write the voices of the cast with these indices, so many seconds of each; return the folder."""
    for index in indices:
        voice = synthetic_voice(index, RATE)
        soundfile.write(folder / f"{voice.name}.wav", voice.speech[: seconds * RATE], RATE)
    return folder
