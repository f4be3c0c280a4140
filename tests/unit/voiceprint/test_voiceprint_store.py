"""Voice prints on disk: private, whole or absent, and refused when damaged."""

import errno
import fcntl
import json
import os
import stat
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from nobody import nobody
from ross_payload.bounded_files import set_aside
from ross_payload.config import Config
from ross_payload.errors import ConfigError
from ross_payload.service.state_folder import state_folder
from ross_payload.sessions.npz_memory import packed_voice, restored_voice
from ross_payload.sessions.session_store import SessionStore
from ross_payload.voiceprint import EmbeddingPrint, VoiceStore, built_in_model, load, save
from ross_payload.voiceprint.embedding_print import unit
from ross_payload.voiceprint.store import NameTaken

MODEL = built_in_model()


@pytest.fixture
def model():
    return EmbeddingPrint(unit(np.random.default_rng(0).standard_normal(MODEL.size)), 2.5, MODEL, criterion=0.75)


@pytest.fixture
def store(tmp_path):
    return VoiceStore.default({"XDG_DATA_HOME": str(tmp_path)})


def mode(path):
    return stat.S_IMODE(path.stat().st_mode)


def test_what_is_saved_is_loaded(model, store):
    back = load(store.save("ann", model))
    np.testing.assert_allclose(back.embedding, model.embedding, atol=1e-6)
    assert (back.seconds, back.criterion) == (model.seconds, model.criterion)


def test_only_the_owner_can_read_a_voice_print(model, store, tmp_path):
    path = store.save("ann", model)
    assert path == tmp_path / "ross" / "voices" / "ann.json"
    assert mode(path) == 0o600
    assert mode(path.parent) == 0o700


def test_a_print_in_a_folder_that_keeps_its_mode_is_kept_all_the_same(model, store, monkeypatch):
    """As on a FAT stick, or in a folder of somebody else."""

    def refused(path, mode):
        raise PermissionError(errno.EPERM, "Operation not permitted", str(path))

    monkeypatch.setattr(Path, "chmod", refused)
    path = store.save("ann", model)
    assert mode(path) == 0o600
    assert store.load("ann").seconds == model.seconds


def test_nobody_else_can_put_another_folder_in_the_place_of_one_that_is_made(model, tmp_path):
    before = os.umask(0)
    try:
        path = VoiceStore(tmp_path / "share" / "ross" / "voices").save("ann", model)
        state = state_folder(Config.model_validate({"service": {"state_dir": str(tmp_path / "var" / "ross")}}))
        session = SessionStore(state / "more" / "recordings").add("")
    finally:
        os.umask(before)
    made = [*path.parents, *session.parents]
    assert {mode(folder) for folder in made if folder.is_relative_to(tmp_path) and folder != tmp_path} == {0o700}


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


def test_a_folder_that_cannot_be_read_is_not_called_empty():
    with tempfile.TemporaryDirectory() as entered:  # by anybody, as those of pytest are not
        Path(entered).chmod(0o755)
        closed = Path(entered) / "closed"
        closed.mkdir(mode=0)
        with nobody(), pytest.raises(ConfigError, match=f"{closed}: cannot be read: Permission denied"):
            VoiceStore(closed).names()


KILLED = """
import os, sys
from pathlib import Path
from ross_payload import atomic_files

atomic_files.os.fsync = lambda handle: os._exit(9)  # as by a kill, or a power cut
atomic_files.write_whole(Path(sys.argv[1]), b"the whole print")
"""


@pytest.fixture
def leftover(store):
    """What a killed program has left of a print of ann."""
    assert subprocess.run([sys.executable, "-c", KILLED, store.path("ann")], check=False).returncode == 9
    (path,) = store.folder.iterdir()
    assert path.read_bytes() == b"the whole print"
    return path


def test_what_a_kill_has_left_of_a_print_is_forgotten(store, leftover):
    assert store.names() == ()
    with pytest.raises(ConfigError, match="no voice 'an' is enrolled"):
        store.forget("an")
    assert leftover.exists()
    store.forget("ann")
    assert not list(store.folder.iterdir())


def test_a_damaged_print_that_was_set_aside_is_forgotten_too(model, store):
    others = ["ann.json.unreadable", "bob"]
    for name in ("ann", *others):
        store.save(name, model)
    set_aside(store.path("ann"), "unreadable")
    store.forget("ann")
    assert store.names() == tuple(others)
    assert len(list(store.folder.iterdir())) == 2


def test_saving_removes_what_a_kill_has_left_but_not_what_is_being_written(model, store, leftover):
    part = store.folder / ".0a1b2c3d.part-cleo.json"
    with part.open("w") as written:
        fcntl.flock(written, fcntl.LOCK_EX)
        store.save("bob", model)
        assert part.exists()
        assert not leftover.exists()


def test_what_is_being_written_is_locked(model, store, monkeypatch):
    saved = []

    def fsync(handle):
        for path in store.folder.glob(".*part*"):
            with path.open() as other, pytest.raises(BlockingIOError):
                fcntl.flock(other, fcntl.LOCK_EX | fcntl.LOCK_NB)
            saved.append(path)

    monkeypatch.setattr("ross_payload.atomic_files.os.fsync", fsync)
    store.save("bob", model)
    assert len(saved) == 1


@pytest.mark.parametrize("taken", [False, True])
def test_a_new_print_needs_no_hard_links(model, store, monkeypatch, taken):
    """As on a memory card."""

    def link(*_):
        raise PermissionError(errno.EPERM, "Operation not permitted")

    monkeypatch.setattr("ross_payload.atomic_files.os.link", link)
    if taken:
        store.save("talker-1", model)
        with pytest.raises(NameTaken):
            store.save("talker-1", replace(model, seconds=9.0), new=True)
    else:
        store.save("talker-1", model, new=True)
    assert store.load("talker-1").seconds == model.seconds
    assert [path.name for path in store.folder.iterdir()] == ["talker-1.json"]


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
    broken = EmbeddingPrint(model.embedding, 1.0, MODEL, criterion=object())  # cannot be written as JSON
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
        (lambda text: text[:500], "expected JSON"),
        (lambda _: "[]", "expected a voice print"),
        (damaged(format="wav"), "expected a voice print"),
        (damaged(version=7), "version 1, got 7"),
        (damaged(background="0" * 16), "another voice model"),
        (damaged(embedding=[1.0]), "damaged"),
        (damaged(embedding=[["a"]]), "damaged"),
        (damaged(embedding=[0.0] * MODEL.size), "damaged"),
        (damaged(criterion=float("nan")), "damaged"),
        (damaged(seconds=float("nan")), "damaged"),
    ],
)
def test_a_damaged_voice_print_is_refused(damage, says, model, store):
    path = store.save("ann", model)
    path.write_text(damage(path.read_text()))
    with pytest.raises(ConfigError, match=says):
        store.load("ann")


def test_a_print_of_the_earlier_built_in_model_asks_to_enrol_again(store):
    """What the model before this one wrote: offsets of its Gaussians, weights of the pitch, and its fingerprint."""
    store.folder.mkdir(parents=True)
    old = {"format": "ross-voice-print", "version": 1, "background": "c9d07d368d832d11", "seconds": 2.9, "consent": ""}
    old |= {"criterion": 0.0, "offsets": [[0.25] * 48] * 64, "pitch_weights": [1 / 12] * 12}
    store.path("ann").write_text(json.dumps(old))
    with pytest.raises(ConfigError, match="made with another voice model: enrol this voice again"):
        store.load("ann")


def test_a_print_of_the_built_in_model_with_64_gaussians_asks_to_enrol_again(store):
    store.folder.mkdir(parents=True)
    old = {"format": "ross-voice-print", "version": 1, "background": "2a7b0fee3de35287", "seconds": 2.9, "consent": ""}
    store.path("ann").write_text(json.dumps(old | {"criterion": 0.0, "embedding": [0.1] * 100}))
    with pytest.raises(ConfigError, match="made with another voice model: enrol this voice again"):
        store.load("ann")


def test_the_print_that_an_earlier_session_kept_says_so(tmp_path):
    old = {"offsets": np.zeros((64, 48)), "pitch_weights": np.full(12, 1 / 12)}
    old |= {name: np.array(value) for name, value in (("seconds", "2.9"), ("criterion", "0.0"))}
    np.savez(tmp_path / "voice.npz", background=np.array('"c9d07d368d832d11"'), **old)
    with pytest.raises(ConfigError, match=r"voice\.npz: made with another model of voices than the one in use"):
        restored_voice(tmp_path / "voice.npz")


def test_the_print_that_a_session_keeps_is_read_again(model, tmp_path):
    (tmp_path / "voice.npz").write_bytes(packed_voice(model))
    again = restored_voice(tmp_path / "voice.npz")
    assert (again.seconds, again.criterion, again.fingerprint) == (2.5, 0.75, MODEL.fingerprint)
    np.testing.assert_array_equal(again.embedding, model.embedding)


@pytest.mark.parametrize("wrong", [{"criterion": "NaN"}, {"seconds": "Infinity"}], ids="-".join)
def test_the_print_of_a_session_has_finite_numbers(model, tmp_path, wrong):
    (tmp_path / "voice.npz").write_bytes(packed_voice(model))
    with np.load(tmp_path / "voice.npz") as arrays:
        np.savez(tmp_path / "voice.npz", **(dict(arrays) | {name: np.array(text) for name, text in wrong.items()}))
    with pytest.raises(ConfigError, match=r"voice\.npz: damaged"):
        restored_voice(tmp_path / "voice.npz")
