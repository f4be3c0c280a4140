"""Folders of recordings for studies: synthetic voices, cut to a few seconds."""

from collections.abc import Iterable
from pathlib import Path

import soundfile

from ross_sim.talkers.synthetic_voices import synthetic_voice


def voice_folder(folder: Path, indices: Iterable[int], seconds: int, rate: int = 16000) -> Path:
    """Write the voices of the cast with these indices, so many seconds of each; return the folder."""
    for index in indices:
        voice = synthetic_voice(index, rate)
        soundfile.write(folder / f"{voice.name}.wav", voice.speech[: seconds * rate], rate)
    return folder
