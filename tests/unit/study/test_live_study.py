from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from ross_payload.errors import ConfigError
from ross_sim.study.live_separation import Listener, main, score
from ross_sim.study.rows.live_tables import Row, appended, read_rows, tables
from ross_sim.study.scenes.mixtures import Mixture

ROW = Row("S1", 3, 0, 0, 16000, 0, "auto", 100, 100.0, 12.0, 11.5, 9.0, 8.0, None, 0.05, 0.03)


def test_rows_survive_a_file(tmp_path: Path) -> None:
    path, other = tmp_path / "rows.csv", replace(ROW, setting="S2", batch_db=None)
    appended(path, [ROW])
    appended(path, [other])
    assert read_rows(path) == [ROW, other]


def test_a_file_of_something_else_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "rows.csv"
    path.write_text("a,b\n1,2\n")
    with pytest.raises(ConfigError, match="expected rows of the study of live separation"):
        read_rows(path)
    result = CliRunner().invoke(main, [str(path)])
    assert result.exit_code == 2
    assert result.output.count("\n") == 1


def test_a_talker_who_is_silent_does_not_count() -> None:
    lines = tables([ROW, replace(ROW, target=1, batch_db=None, live_db=None)]).splitlines()
    assert lines[2] == "| `auto` | 100.0 | 0.5 |"


def _recording() -> Mixture:
    """One talker straight ahead, as loud as the noise is not; the other one silent."""
    rng = np.random.default_rng(0)
    voice = rng.standard_normal(8000).astype(np.float32) * np.repeat(rng.random(80) > 0.3, 100)
    images = np.stack([np.stack([voice, voice]), np.zeros((2, 8000))])
    noise = 0.05 * rng.standard_normal((2, 16000)).astype(np.float32)
    mixture = (images.sum(axis=0) + noise[:, :8000]).astype(np.float32)
    return Mixture(mixture, noise[:, 8000:], images, np.array([0.0, 1e-4]), 0)


@pytest.mark.parametrize("latency", [0.045, 0.1])
def test_what_is_heard_live_lies_at_the_samples_of_the_recording(latency: float) -> None:
    recording = _recording()
    heard = Listener("gaussian", 16000, latency).listen(recording)
    aligned = score(heard.voices, heard.members, recording, 2000, 6000)
    late = score(np.roll(heard.voices, 1, axis=1), heard.members, recording, 2000, 6000)
    assert heard.latency <= latency
    assert aligned is not None and late is not None
    assert aligned > 8 > late


def test_a_silent_target_has_no_score() -> None:
    recording = _recording()
    voices, members = np.stack([recording.mixture[0], recording.mixture[1]]), ((0,), (1,))
    assert score(voices, members, recording, 0, 8000) is not None
    assert score(voices, members, replace(recording, target=1), 0, 8000) is None
    assert score(voices[:1], ((1,),), recording, 0, 8000) is None
