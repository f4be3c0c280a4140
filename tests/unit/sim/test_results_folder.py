"""A folder of results: for its owner alone, and not there when there are none."""

import os

import numpy as np
import pytest

from ross_payload.audio.audio_files import write_wav
from ross_sim.sitl.results_folder import ResultsFolder


def mode(path):
    return path.stat().st_mode & 0o777


def test_voices_of_people_are_for_their_owner_alone(tmp_path):
    before = os.umask(0o022)
    try:
        with ResultsFolder(tmp_path / "out") as out:
            write_wav(out.staging / "target.wav", np.zeros(10), 16000)
    finally:
        os.umask(before)
    assert (mode(tmp_path / "out"), mode(tmp_path / "out" / "target.wav")) == (0o700, 0o600)


@pytest.mark.parametrize("there", [False, True])
def test_without_results_a_folder_is_as_before(tmp_path, there):
    path = tmp_path / "out"
    if there:
        path.mkdir()
    with pytest.raises(RuntimeError), ResultsFolder(path):
        raise RuntimeError
    assert path.exists() == there
