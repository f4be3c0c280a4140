"""The folder of sessions: bounded, and nothing in it is touched that is not a session of ours."""

import os

import pytest

from ross_payload.config import Config
from ross_payload.errors import ConfigError
from ross_payload.sessions.manifest import Beginning
from ross_payload.sessions.session_store import DAY, SessionStore
from ross_payload.sessions.session_writer import SessionWriter

BEGINNING = Beginning("mission", Config(), -1.0, 1.0)


def limits(**changes):
    return Config.model_validate({"recording": {"min_free_gb": 0} | changes}).recording


def fill(shelf, size=0, age=0.0):
    """A session of about ``size`` bytes that ended ``age`` days ago."""
    path = shelf.add("")
    SessionWriter(path, BEGINNING, "").finish("done")
    os.truncate(path / "audio.wav", size)
    now = (path / "session.json").stat().st_mtime
    for file in path.iterdir():
        os.utime(file, (now - age * DAY,) * 2)
    return path


@pytest.fixture
def shelf(tmp_path):
    return SessionStore(tmp_path / "recordings")


def names(shelf):
    return [kept.path.name for kept in shelf.all()]


def test_sessions_are_numbered_and_never_share_a_folder(shelf):
    fill(shelf)
    shelf.add("20261121T145421Z")
    (shelf.folder / "0007").mkdir()
    assert fill(shelf).name == "0008"


def test_the_oldest_sessions_go_first(shelf):
    for _ in range(4):
        fill(shelf, size=400_000_000)
    shelf.tidy(limits(max_gb=1.0))
    assert names(shelf) == ["0003", "0004"]


def test_sessions_that_are_too_old_go(shelf):
    for age in (40, 29, 31, 0):
        fill(shelf, age=age)
    shelf.tidy(limits(max_days=30))
    assert names(shelf) == ["0002", "0004"]


def test_a_session_from_a_clock_that_was_not_set_is_not_too_old(shelf):
    path = fill(shelf)
    for file in path.iterdir():
        os.utime(file, (1000.0, 1000.0))
    shelf.tidy(limits(max_days=30))
    assert names(shelf) == ["0001"]


def test_the_running_session_is_never_deleted(shelf):
    path = shelf.add("")
    writer = SessionWriter(path, BEGINNING, "")
    os.truncate(path / "telemetry.tlog", 2_000_000_000)
    fill(shelf)
    try:
        assert "max_gb" in shelf.tidy(limits(max_gb=1.0), path)
        assert names(shelf) == ["0001"]
        for file in path.iterdir():
            os.utime(file, (1.6e9, 1.6e9))
        shelf.tidy(limits(max_days=1))
        with pytest.raises(ConfigError, match="being recorded"):
            shelf.delete(shelf.find("0001"))
    finally:
        writer.close()
    shelf.delete(shelf.find("0001"))
    assert names(shelf) == []


def test_what_is_not_ours_stays(shelf):
    fill(shelf, size=2_000_000_000, age=1)
    foreign = [shelf.folder / "holidays", shelf.folder / "0042"]
    for folder in foreign:
        folder.mkdir()
        (folder / "session.json").write_text("{}")
        os.utime(folder / "session.json", (1.6e9, 1.6e9))
    (shelf.folder / "elsewhere").mkdir()
    outside = shelf.folder.parent / "outside"
    fill(SessionStore(outside))
    (shelf.folder / "0099").symlink_to(outside / "0001")
    shelf.tidy(limits(max_gb=0.001, max_days=0.001))
    assert names(shelf) == []
    assert all((folder / "session.json").exists() for folder in foreign)
    assert (outside / "0001" / "session.json").exists()


def test_a_note_that_somebody_has_put_into_a_session_stays(shelf):
    path = fill(shelf)
    (path / "notes.txt").write_text("keep me")
    shelf.delete(shelf.find("0001"))
    assert [file.name for file in path.iterdir()] == ["notes.txt"]
    assert names(shelf) == []


def test_a_session_that_does_not_exist_cannot_be_deleted(shelf):
    with pytest.raises(ConfigError, match="no session '0003'"):
        shelf.find("0003")
