"""Training the built-in model: who is heard with whom, what stays out, and that an interruption changes nothing."""

import numpy as np
import pytest

from ross_payload.errors import ConfigError
from ross_payload.voiceprint.built_in import BuiltInModel, encode_model
from ross_payload.voiceprint.features import RATE
from ross_sim.study import train_voiceprint
from ross_sim.study.reader_mixtures import groups_of, heard
from ross_sim.study.train_voiceprint import kept_out, trained
from ross_sim.study.training_voices import readers
from speaker_network import vowel

TALKERS = {"ann": (220.0, 900.0), "bob": (110.0, 500.0), "cleo": (180.0, 1500.0)}


@pytest.fixture(scope="module")
def voices():
    spoken = {name: vowel(*sound, seconds=3.0, seed=index) for index, (name, sound) in enumerate(TALKERS.items())}
    return spoken | {f"{name}2": vowel(*sound, seconds=3.0, seed=9) for name, sound in TALKERS.items()}


@pytest.fixture
def _small(monkeypatch):
    sizes = {"N_GAUSSIANS": 3, "N_FACTORS": 5, "SIZE": 3, "N_STEPS": 2, "N_ROUNDS": 1, "PIECES": (3.0, 2.0)}
    for name, size in sizes.items():
        monkeypatch.setattr(train_voiceprint, name, size)


@pytest.mark.usefixtures("_small")
def test_a_run_that_was_interrupted_goes_on_and_ends_with_the_same_numbers(voices, tmp_path, monkeypatch):
    made, real = [], train_voiceprint.heard

    def counted(clips, rng):
        if len(made) == 1 and not (tmp_path / "other").exists():
            raise KeyboardInterrupt
        made.append(real(clips, rng))
        return made[-1]

    monkeypatch.setattr(train_voiceprint, "heard", counted)
    with pytest.raises(KeyboardInterrupt):
        trained(voices, tmp_path / "work", 0)
    (tmp_path / "other").mkdir()
    resumed = trained(voices, tmp_path / "work", 0)
    assert len(made) == 2  # each of the two mixtures once
    whole = trained(voices, tmp_path / "other", 0)
    assert encode_model(whole) == encode_model(resumed)
    assert np.linalg.norm(BuiltInModel(whole).embed(voices["ann"])) == pytest.approx(1.0)


def test_everybody_is_heard_once_in_a_round_with_others_of_that_length():
    lengths = {f"reader{index}": (3 + index % 5 * 4) * RATE for index in range(31)}
    groups = groups_of(lengths, 0, 1)
    names = [name for group in groups for name in group]
    assert len(names) == len(set(names)) == 30
    assert groups == groups_of(lengths, 0, 1) != groups_of(lengths, 0, 2)
    spans = [max(lengths[name] for name in group) / min(lengths[name] for name in group) for group in groups]
    assert np.median(spans) == 1.0


def test_what_is_separated_is_the_talker_and_as_long(voices):
    clips = [voices["ann"], voices["bob"][: 2 * RATE], voices["cleo"]]
    found = heard(clips, np.random.default_rng(7))
    assert [len(one) for one in found if one is not None] == [len(clip) for clip in clips]
    spectra = [np.abs(np.fft.rfft(clip, 4 * RATE))[: 3 * RATE] for clip in (*clips, *found)]
    likeness = np.corrcoef(spectra)[3:, :3]
    assert likeness.argmax(axis=1).tolist() == [0, 1, 2]


def test_readers_to_calibrate_with_are_long_enough_and_drawn_by_the_seed():
    voices = {f"r{index:02d}": np.zeros((15 if index % 2 else 9) * RATE) for index in range(100)}
    kept = kept_out(voices, 0)
    assert kept == kept_out(voices, 0) != kept_out(voices, 1)
    assert len(set(kept)) == 40
    assert all(len(voices[name]) == 15 * RATE for name in kept)
    with pytest.raises(ConfigError, match=r"expected at least 40 readers of more than 14.2 s, got 0"):
        kept_out({"r": np.zeros(9)}, 0)


@pytest.mark.parametrize(
    ("text", "says"), [("set\tid\ntrain\ty\n", "columns set, id and file"), (None, "MANIFEST.tsv")]
)
def test_a_folder_without_a_list_is_refused(tmp_path, text, says):
    if text:
        (tmp_path / "MANIFEST.tsv").write_text(text)
    with pytest.raises(ConfigError, match=says):
        readers(tmp_path, "train")
