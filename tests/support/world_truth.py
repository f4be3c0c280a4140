"""What a world has written about itself, read again."""

import json
import math

import numpy as np
import soundfile

from ross_payload.angles import wrap
from ross_sim.sitl.report import Truth


def read_truth(folder):
    """Read what a world has written, azimuths from the zero of its mount."""
    values = json.loads((folder / "truth.json").read_text(encoding="utf-8"))
    talkers = values["talkers"]
    tracks = [soundfile.read(folder / f"image-{index}.wav", dtype="float32")[0].T for index in range(len(talkers))]
    mixture = soundfile.read(folder / "mixture.wav", dtype="float32")[0].T
    return Truth(
        names=tuple(talker["name"] for talker in talkers),
        azimuths=np.array([wrap(math.radians(talker["azimuth_deg"])) for talker in talkers]),
        elevations=np.radians([talker["elevation_deg"] for talker in talkers]),
        images=np.array([track[0] for track in tracks]).reshape(len(talkers), -1),
        mixture=mixture[0],
        target=values["target"],
    )
