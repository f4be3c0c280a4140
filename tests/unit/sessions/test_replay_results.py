"""What a replay has in common with what was recorded."""

from dataclasses import replace

import numpy as np
import pytest
import soundfile

from ross_payload.events import ArrayContradicted, Event, Separated
from ross_payload.sessions.divergence import Replayed
from ross_payload.sessions.event_json import line
from ross_payload.sessions.replay_results import difference, identical, softer_by, write

NOW = ArrayContradicted(2.0, None, 0.05, -4.0, inverted=False)
BEFORE = line(NOW).replace(', "delay": null, "fixed": false', "")  # as versions wrote it that knew of neither


def test_a_field_that_the_recording_is_too_old_for_makes_no_difference_where_it_tells_nothing():
    ours, recorded = [line(Event(1.0)), line(NOW)], [line(Event(1.0)), BEFORE]
    assert "fixed" not in BEFORE
    assert identical(ours, recorded, cut_off=False)
    assert difference(ours, recorded) is None


@pytest.mark.parametrize("other", [{"fixed": True}, {"delay": 6e-5}, {"gain_db": -3.0}, {"time": 2.01}])
def test_what_it_tells_is_a_difference(other):
    ours = [line(Event(1.0)), line(replace(NOW, **other))]
    assert not identical(ours, [line(Event(1.0)), BEFORE], cut_off=False)
    assert difference(ours, [line(Event(1.0)), BEFORE])["line"] == 2


def test_a_log_that_ends_before_the_other_is_the_same_only_of_a_session_that_was_cut_off():
    for ours, recorded in ([line(Event(1.0))], [line(Event(1.0)), BEFORE]), ([line(Event(1.0)), BEFORE], []):
        assert identical(ours, recorded, cut_off=True)
        assert not identical(ours, recorded, cut_off=False)


def test_voices_louder_than_full_scale_are_softer_in_the_files_and_not_cut_off(tmp_path):
    voices = np.array([[0.1, -0.2, 0.3], [0.5, 2.0, -1.0]], np.float32)
    separated = Separated(0.0, 0, 0.0, voices, (), 1, "gaussian", "")
    write(tmp_path, {}, Replayed(latest={Separated: separated}), 16000)
    written = np.array([soundfile.read(tmp_path / name)[0] for name in ("group-0.wav", "target.wav")])
    np.testing.assert_allclose(written, voices / 2, atol=2**-23)
    assert softer_by(separated) == pytest.approx(6.02, abs=0.01)


def test_voices_within_full_scale_are_written_as_they_are(tmp_path):
    voices = np.array([[0.5, -1.0, 0.25]], np.float32)
    separated = Separated(0.0, 0, 0.0, voices, (), 0, "gaussian", "")
    write(tmp_path, {}, Replayed(latest={Separated: separated}), 16000)
    assert soundfile.read(tmp_path / "target.wav")[0].tolist() == voices[0].tolist()
    assert softer_by(separated) == softer_by(None) == 0
