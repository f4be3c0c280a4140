"""Training the built-in model: who is heard with whom, what stays out, and that an interruption changes nothing."""

import numpy as np
import pytest

from ross_payload.errors import ConfigError
from ross_payload.separation.local_gaussian_model import separator as gaussian
from ross_payload.voiceprint.built_in import BuiltInModel, encode_model
from ross_payload.voiceprint.features import RATE
from ross_sim.study import train_voiceprint
from ross_sim.study.train_voiceprint import trained
from ross_sim.study.training import reader_mixtures, voice_pieces
from ross_sim.study.training.calibration_voices import N_FOLDS, SeparatedVoice, enrolments, folds_of
from ross_sim.study.training.reader_mixtures import groups_of, heard
from ross_sim.study.training.training_voices import readers
from ross_sim.study.training.voice_calibration import Corpus, trials
from ross_sim.study.training.voice_pieces import reader_of, training_pieces, with_speeds
from ross_sim.talkers.speech import TalkerVoice
from speaker_network import vowel

TALKERS = {"ann": (220.0, 900.0), "bob": (110.0, 500.0), "cleo": (180.0, 1500.0)}


@pytest.fixture(scope="module")
def voices():
    spoken = {name: vowel(*sound, seconds=3.0, seed=index) for index, (name, sound) in enumerate(TALKERS.items())}
    return spoken | {f"{name}2": vowel(*sound, seconds=3.0, seed=9) for name, sound in TALKERS.items()}


@pytest.fixture
def _small(monkeypatch):
    for name, size in {"N_GAUSSIANS": 3, "N_FACTORS": 5, "N_STEPS": 2}.items():
        monkeypatch.setattr(train_voiceprint, name, size)
    monkeypatch.setattr(voice_pieces, "N_ROUNDS", 1)
    monkeypatch.setattr(voice_pieces, "PIECES", (3.0, 2.0))
    monkeypatch.setattr(reader_mixtures, "SHORTEST", 1.0)
    monkeypatch.setattr(reader_mixtures, "separator", gaussian)


@pytest.mark.soak
@pytest.mark.usefixtures("_small")
def test_a_run_that_was_interrupted_goes_on_and_ends_with_the_same_numbers(voices, tmp_path, monkeypatch):
    voices = {name: voice[: 3 * RATE // 2] for name, voice in voices.items()}
    made, real = [], voice_pieces.heard

    def counted(clips, rng):
        if len(made) == 1 and not (tmp_path / "other").exists():
            raise KeyboardInterrupt
        made.append(real(clips, rng))
        return made[-1]

    monkeypatch.setattr(voice_pieces, "heard", counted)
    with pytest.raises(KeyboardInterrupt):
        trained(voices, {}, tmp_path / "work", 0)
    (tmp_path / "other").mkdir()
    resumed = trained(voices, {}, tmp_path / "work", 0)[None]
    assert len(made) == 2  # each of the two mixtures once
    found = trained(voices, {"ann": 0}, tmp_path / "other", 0)
    whole = found[None]
    assert encode_model(whole) == encode_model(resumed)
    assert np.linalg.norm(BuiltInModel(whole).embed(voices["ann"])) == pytest.approx(1.0)
    assert set(found) == {None, 0}
    assert not np.array_equal(found[0].loadings, whole.loadings)  # ann tells nothing of what is learnt without her


def test_pieces_of_other_readers_or_another_seed_are_made_again(voices, tmp_path, monkeypatch):
    monkeypatch.setattr(voice_pieces, "N_ROUNDS", 0)
    monkeypatch.setattr(voice_pieces, "disturbed", lambda voice, index: [])
    first, second = ({name: voices[name]} for name in ("ann", "bob"))

    def pieces(about, seed, work):
        return [(piece.talker, piece.features.cepstra.tolist()) for piece in training_pieces(about, work, seed)]

    asked = [(first, 0), (second, 0), (second, 1)]
    shared = [pieces(about, seed, tmp_path / "work") for about, seed in asked]
    assert shared == [pieces(about, seed, tmp_path / f"fresh{seed}{next(iter(about))}") for about, seed in asked]
    assert shared == [pieces(about, seed, tmp_path / "work") for about, seed in asked]
    assert [found[0][0] for found in shared] == ["ann", "bob", "bob"]


def test_enrolments_of_another_talker_of_that_name_are_made_again(voices, tmp_path):
    ann, bob = (TalkerVoice("ann", voices[name], voices[name], RATE) for name in ("ann", "bob"))
    found = [enrolments([voice], tmp_path)["ann"][0].cepstra for voice in (ann, bob)]
    assert not np.array_equal(*found)


def test_a_reader_at_other_speeds_is_two_other_talkers_of_the_same_fold(voices):
    found = with_speeds(voices, 0)
    assert len(found) == 3 * len(voices)
    assert all(reader_of(name) in voices for name in found)
    assert {len(found[name]) < len(voices[reader_of(name)]) for name in found if name not in voices} == {True, False}


def test_everybody_is_heard_once_in_a_round_with_others_of_that_length():
    lengths = {f"reader{index}": (3 + index % 5 * 4) * RATE for index in range(31)}
    groups = groups_of(lengths, 0, 1)
    names = [name for group in groups for name in group]
    assert len(names) == len(set(names)) == 30
    assert groups == groups_of(lengths, 0, 1) != groups_of(lengths, 0, 2)
    spans = [max(lengths[name] for name in group) / min(lengths[name] for name in group) for group in groups]
    assert np.median(spans) == 1.0


@pytest.mark.soak
def test_what_is_separated_is_the_talker_and_as_long(voices):
    clips = [voices["ann"], voices["bob"][: 2 * RATE], voices["cleo"]]
    found = heard(clips, np.random.default_rng(7))
    assert [len(one) for one in found if one is not None] == [len(clip) for clip in clips]
    spectra = [np.abs(np.fft.rfft(clip, 4 * RATE))[: 3 * RATE] for clip in (*clips, *found)]
    similarity = np.corrcoef(spectra)[3:, :3]
    assert similarity.argmax(axis=1).tolist() == [0, 1, 2]


def test_readers_are_dealt_to_folds_by_the_seed_those_who_speak_for_long_evenly():
    voices = {f"r{index:02d}": np.zeros((15 if index % 2 else 9) * RATE) for index in range(100)}
    folds = folds_of(voices, 0)
    assert folds == folds_of(voices, 0) != folds_of(voices, 1)
    long = [folds[name] for name in voices if len(voices[name]) > 14 * RATE]
    assert np.bincount(long).tolist() == [50 // N_FOLDS] * N_FOLDS
    assert len(folds) == 100
    with pytest.raises(ConfigError, match=r"expected at least 15 readers of more than 14.2 s, got 0"):
        folds_of({"r": np.zeros(9)}, 0)


def test_a_voice_is_compared_with_its_fold_by_what_was_learnt_without_it():
    """Two folds of two talkers; the model of a fold sees one axis, that of the other fold another."""

    class Model:
        def __init__(self, axis):
            self.axis = axis

        def embedding_of(self, features):
            return features[[self.axis]]

        def similarity(self, enrolled, heard):
            return float(enrolled @ heard)

    voices = {
        "a": np.array([1.0, 0.0]),
        "b": np.array([-1.0, 0.0]),
        "c": np.array([0.0, 1.0]),
        "d": np.array([0.0, -1.0]),
    }
    heard_of = [SeparatedVoice("readers", "S1 0", "ab".find(name) < 0, 3.0, name, voices[name]) for name in voices]
    enrolled = {0: {name: [voices[name]] for name in "ab"}, 1: {name: [voices[name]] for name in "cd"}}
    models = {0: Model(0), 1: Model(1)}
    found = trials(models, Corpus(heard_of, enrolled))[3.0]
    assert found.similarity.tolist() == [1.0, -1.0, -1.0, 1.0] * 2
    assert found.own.tolist() == [True, False, False, True] * 2


@pytest.mark.parametrize(
    ("text", "says"), [("set\tid\ntrain\ty\n", "columns set, id and file"), (None, "MANIFEST.tsv")]
)
def test_a_folder_without_a_list_is_refused(tmp_path, text, says):
    if text:
        (tmp_path / "MANIFEST.tsv").write_text(text)
    with pytest.raises(ConfigError, match=says):
        readers(tmp_path, "train")
