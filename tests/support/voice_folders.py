"""What small studies need: folders of synthetic voices, cut to a few seconds, and the axes of one."""

from collections.abc import Iterable
from pathlib import Path

import soundfile

from ross_sim.talkers.synthetic_voices import synthetic_voice

RATE = 16000
SMALL_STUDY = """
settings = ["S1"]
k = [2]
layouts = 0
starts = 2
separators = ["duet"]
rotations = [2]
unit_s = [0.5]
run_s = 1.0
rate_hz = 16000
"""


def voice_folder(folder: Path, indices: Iterable[int], seconds: int) -> Path:
    """Write the voices of the cast with these indices, so many seconds of each; return the folder."""
    for index in indices:
        voice = synthetic_voice(index, RATE)
        soundfile.write(folder / f"{voice.name}.wav", voice.speech[: seconds * RATE], RATE)
    return folder
