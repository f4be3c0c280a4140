"""Voice prints on disk: private, whole or absent, and refused when damaged."""

import json
import stat
from pathlib import Path

import numpy as np
import pytest

from ross_payload.errors import ConfigError
from ross_payload.voiceprint import VoicePrintModel, VoiceStore, load, save, shipped_background
from ross_payload.voiceprint.background import Adapted

BACKGROUND = shipped_background()


@pytest.fixture
def model():
    rng = np.random.default_rng(0)
    weights = rng.random(len(BACKGROUND.pitch_weights))
    voice = Adapted(rng.standard_normal(BACKGROUND.means.shape), weights / weights.sum())
    return VoicePrintModel(voice, 2.5, BACKGROUND, criterion=0.75)


@pytest.fixture
def store(tmp_path):
    return VoiceStore.default({"XDG_DATA_HOME": str(tmp_path)})


def mode(path):
    return stat.S_IMODE(path.stat().st_mode)


def test_what_is_saved_is_loaded(model, store):
    back = load(store.save("ann", model))
    np.testing.assert_allclose(back.voice.offsets, model.voice.offsets, atol=5e-5)
    np.testing.assert_allclose(back.voice.pitch_weights, model.voice.pitch_weights, atol=5e-7)
    assert (back.seconds, back.criterion) == (model.seconds, model.criterion)


def test_only_the_owner_can_read_a_voice_print(model, store, tmp_path):
    path = store.save("ann", model)
    assert path == tmp_path / "ross" / "voices" / "ann.json"
    assert mode(path) == 0o600
    assert mode(path.parent) == 0o700


def test_a_folder_of_the_user_keeps_its_mode(model, tmp_path):
    tmp_path.chmod(0o755)
    save(model, tmp_path / "ann.json")
    assert mode(tmp_path) == 0o755


def test_a_relative_data_home_is_ignored_as_the_standard_asks():
    assert VoiceStore.default({"XDG_DATA_HOME": "here"}).folder == Path.home() / ".local/share/ross/voices"


def test_names_are_listed_and_forgotten(model, store):
    assert store.names() == ()
    for name in ("bob", "ann"):
        store.save(name, model)
    assert store.names() == ("ann", "bob")
    store.forget("ann")
    assert store.names() == ("bob",)
    assert not store.path("ann").exists()


def test_nobody_of_that_name(model, store):
    store.save("bob", model)
    with pytest.raises(ConfigError, match="no voice 'ann' is enrolled; enrolled: bob"):
        store.load("ann")
    with pytest.raises(ConfigError, match="no voice 'ann' is enrolled"):
        store.forget("ann")


@pytest.mark.parametrize("name", ["", "../ann", "a/b", ".hidden", "a b", "x" * 65])
def test_a_name_cannot_leave_the_store(name, model, store):
    with pytest.raises(ConfigError, match="as the name of a voice"):
        store.save(name, model)


def test_a_failed_write_leaves_the_old_file_and_nothing_else(model, store):
    path = store.save("ann", model)
    before = path.read_bytes()
    broken = VoicePrintModel(model.voice, 1.0, BACKGROUND, criterion=object())  # cannot be written as JSON
    with pytest.raises(TypeError):
        store.save("ann", broken)
    assert path.read_bytes() == before
    assert [entry.name for entry in store.folder.iterdir()] == ["ann.json"]


def test_a_place_that_cannot_be_written_is_one_clear_line(model, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(ConfigError, match="cannot be written"):
        save(model, tmp_path / "file" / "ann.json")


def damaged(**changes):
    def damage(text):
        return json.dumps(json.loads(text) | changes)

    return damage


@pytest.mark.parametrize(
    ("damage", "says"),
    [
        (lambda text: text[:1000], "expected JSON"),
        (lambda _: "[]", "expected a voice print"),
        (damaged(format="wav"), "expected a voice print"),
        (damaged(version=7), "version 1, got 7"),
        (damaged(background="0" * 16), "another voice model"),
        (damaged(offsets=[1.0]), "damaged"),
        (damaged(offsets=[["a"]]), "damaged"),
        (damaged(seconds=float("nan")), "damaged"),
        (damaged(pitch_weights=[-1.0] * len(BACKGROUND.pitch_weights)), "damaged"),
    ],
)
def test_a_damaged_voice_print_is_refused(damage, says, model, store):
    path = store.save("ann", model)
    path.write_text(damage(path.read_text()))
    with pytest.raises(ConfigError, match=says):
        store.load("ann")
