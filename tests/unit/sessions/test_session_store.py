"""The folder of sessions: bounded, and nothing in it is touched that is not a session of ours."""

import errno
import itertools
import os
import stat
from contextlib import suppress
from pathlib import Path

import pytest

from ross_payload.atomic_files import replacing
from ross_payload.config import Config
from ross_payload.errors import ConfigError
from ross_payload.sessions import session_store, session_writer
from ross_payload.sessions.manifest import Beginning
from ross_payload.sessions.session_store import DAY, FILES, SessionStore
from ross_payload.sessions.session_writer import SessionWriter

BEGINNING = Beginning("mission", Config(), -1.0, 1.0)


def limits(**changes):
    return Config.model_validate({"recording": {"min_free_gb": 0} | changes}).recording


def fill(store, size=0, age=0.0):
    """A session of about ``size`` bytes that ended ``age`` days ago."""
    path = store.add("")
    SessionWriter(path, BEGINNING, "").finish("done")
    os.truncate(path / "audio.wav", size)
    now = (path / "session.json").stat().st_mtime
    for file in path.iterdir():
        os.utime(file, (now - age * DAY,) * 2)
    return path


@pytest.fixture
def store(tmp_path):
    return SessionStore(tmp_path / "recordings")


def names(store):
    return [kept.path.name for kept in store.all()]


def test_sessions_are_numbered_and_never_share_a_folder(store):
    fill(store)
    store.add("20261121T145421Z")
    (store.folder / "0007").mkdir()
    assert fill(store).name == "0008"


def test_a_session_that_somebody_deletes_this_moment_is_none(store, monkeypatch):
    fill(store)
    monkeypatch.setattr("ross_payload.sessions.session_store._status", lambda path: None)
    assert names(store) == []
    store.tidy(limits(max_gb=1.0))


def test_the_oldest_sessions_go_first(store):
    for _ in range(4):
        fill(store, size=400_000_000)
    store.tidy(limits(max_gb=1.0))
    assert names(store) == ["0003", "0004"]


def test_sessions_that_are_too_old_go(store):
    for stamp in ("20261020T120000Z", "20261031T120000Z", "20261029T120000Z", "20261129T120000Z"):
        SessionWriter(store.add(stamp), BEGINNING, "").finish("done")
    store.tidy(limits(max_days=30), stamp="20261129T120000Z")
    assert names(store) == ["0002-20261031T120000Z", "0004-20261129T120000Z"]


def test_by_a_clock_that_nobody_confirms_sessions_look_old_and_stay(store):
    """That of a computer without a network may be years ahead: with it all recordings were deleted."""
    assert store.doubtful(limits(max_days=30)) == 0
    for age in (40, 29, 31, 0):
        fill(store, age=age)
    SessionWriter(store.add("20200101T120000Z"), BEGINNING, "").finish("done")
    store.tidy(limits(max_days=30))
    assert len(names(store)) == 5
    assert store.doubtful(limits(max_days=30)) == 3


def test_a_session_from_a_clock_that_was_not_set_is_not_too_old(store):
    path = fill(store)
    for file in path.iterdir():
        os.utime(file, (1000.0, 1000.0))
    store.tidy(limits(max_days=30))
    assert names(store) == ["0001"]


def test_a_session_of_a_clock_that_was_behind_has_its_days_from_when_that_is_known(store):
    """As on a computer without a clock of its own: recorded offline, it looks weeks old once the time is known."""
    path = fill(store, age=40)
    store.tidy(limits(max_days=30), stamp="20261129T120000Z")
    assert (path / "dated").read_text() == "20261129T120000Z"
    store.tidy(limits(max_days=30), stamp="20261229T110000Z")
    assert names(store) == ["0001"]
    (path / "dated").write_text("spoilt")
    store.tidy(limits(max_days=30), stamp="20261229T130000Z")
    assert names(store) == ["0001"]
    store.tidy(limits(max_days=30), stamp="20270128T140000Z")
    assert not path.exists()


def test_many_sessions_without_a_date_get_theirs_little_by_little(store, monkeypatch):
    """Thousands of dates would hold up a recording for longer than it can wait."""
    monkeypatch.setattr(session_store, "DATED_AT_ONCE", 2)
    paths = [fill(store) for _ in range(5)]
    for dated in (2, 4, 5, 5):
        store.tidy(limits(max_days=30), stamp="20261129T120000Z")
        assert [(path / "dated").exists() for path in paths] == dated * [True] + (5 - dated) * [False]


def test_hundreds_of_sessions_are_dated_within_hours_and_nobody_waits_for_the_disk(store, monkeypatch):
    """While nothing is recorded there is one look in an hour."""
    paths = [fill(store) for _ in range(50)]
    monkeypatch.setattr(os, "fsync", lambda handle: pytest.fail("waits for the disk"))
    store.tidy(limits(max_days=30), stamp="20261129T120000Z")
    assert [(path / "dated").read_text() for path in paths] == 50 * ["20261129T120000Z"]
    assert {stat.S_IMODE((path / "dated").stat().st_mode) for path in paths} == {0o600}


@pytest.mark.parametrize("left", [b"", bytes(16), b"2026112"])
def test_a_date_that_a_power_cut_has_spoilt_is_given_again(store, left):
    (path := fill(store)).joinpath("dated").write_bytes(left)
    store.tidy(limits(max_days=30), stamp="20261129T120000Z")
    assert (path / "dated").read_text() == "20261129T120000Z"


def test_by_a_trusted_clock_the_time_in_a_name_counts_whatever_files_say(store):
    paths = [store.add(stamp) for stamp in ("20261029T120000Z", "20261031T120000Z", "20269999T000000Z")]
    for path in paths:
        SessionWriter(path, BEGINNING, "").finish("done")
        for file in path.iterdir():
            os.utime(file, (1.7e9,) * 2)
    store.tidy(limits(max_days=30), stamp="20261129T120001Z")
    assert names(store) == [path.name for path in paths[1:]]
    assert [(path / "dated").exists() for path in paths[1:]] == [False, True]


def test_a_session_that_a_clock_far_ahead_has_named_has_its_days_from_when_that_is_known(store):
    """Else what people have said while an autopilot took the year for 2037 would be kept until 2037."""
    SessionWriter(path := store.add("20371129T120000Z"), BEGINNING, "").finish("done")
    store.tidy(limits(max_days=30), stamp="20371129T120005Z")
    store.tidy(limits(max_days=30), stamp="20261129T120000Z")
    store.tidy(limits(max_days=30), stamp="20261229T110000Z")
    assert names(store) == [path.name]
    store.tidy(limits(max_days=30), stamp="20261229T130000Z")
    assert not path.exists()


def test_what_is_too_old_goes_before_anything_is_written_to_a_disk_that_is_full(store, monkeypatch):
    undated = fill(store)
    SessionWriter(old := store.add("20261001T120000Z"), BEGINNING, "").finish("done")

    def full(path, mode):
        if old.exists():
            raise OSError(errno.ENOSPC, "No space left on device")
        return replacing(path, mode)

    monkeypatch.setattr("ross_payload.sessions.session_store.replacing", full)
    store.tidy(limits(max_days=30), stamp="20261129T120000Z")
    assert names(store) == ["0001"]
    assert (undated / "dated").exists()


def tidied_again(store, monkeypatch, after):
    """Delete what is older than thirty days: killed at a file, and the next time."""
    unlink, count = Path.unlink, itertools.count()

    def killed(file, missing_ok=False):
        if next(count) == after:
            raise KeyboardInterrupt
        unlink(file, missing_ok=missing_ok)

    with monkeypatch.context() as dying, suppress(KeyboardInterrupt):
        dying.setattr(Path, "unlink", killed)
        store.tidy(limits(max_days=30), stamp="20261129T120000Z")
    store.tidy(limits(max_days=30), stamp="20261129T120000Z")


@pytest.mark.parametrize("after", range(len(FILES)))
def test_what_a_kill_leaves_of_a_session_goes_the_next_time(store, monkeypatch, after):
    """Voices of people beyond `max_days`, in a folder that no longer said that it is a session, were nobody's."""
    SessionWriter(path := store.add("20261001T120000Z"), BEGINNING, "").finish("done")
    for name in ("target.flac", "source-0.flac"):
        (path / name).write_bytes(b"somebody")
    tidied_again(store, monkeypatch, after)
    assert not path.exists() or not list(path.iterdir())


@pytest.mark.parametrize("after", range(len(FILES)))
def test_what_a_kill_leaves_of_a_session_with_no_date_in_its_name_begins_no_new_days(store, monkeypatch, after):
    (path := fill(store)).joinpath("dated").write_text("20261001T120000Z")
    (path / "source-0.flac").write_bytes(b"somebody")
    tidied_again(store, monkeypatch, after)
    assert not (path / "source-0.flac").exists()


def test_the_running_session_is_never_deleted(store):
    path = store.add("")
    writer = SessionWriter(path, BEGINNING, "")
    os.truncate(path / "telemetry.tlog", 2_000_000_000)
    fill(store)
    try:
        assert "max_gb" in store.tidy(limits(max_gb=1.0), path)
        assert names(store) == ["0001"]
        for file in path.iterdir():
            os.utime(file, (1.6e9, 1.6e9))
        store.tidy(limits(max_days=1))
        store.tidy(limits(max_days=1), stamp="21001129T120001Z")
        with pytest.raises(ConfigError, match="being recorded"):
            store.delete(store.find("0001"))
    finally:
        writer.close()
    store.delete(store.find("0001"))
    assert names(store) == []


def test_a_session_that_begins_is_running_before_it_is_one(store, monkeypatch):
    """Another payload deleted it where the storage was full: what was recorded went into files without a name."""
    write = session_writer.manifest.write

    def slow(folder, begin, started):
        write(folder, begin, started)
        store.tidy(limits(max_gb=1e-9))

    monkeypatch.setattr(session_writer.manifest, "write", slow)
    writer = SessionWriter(store.add(""), BEGINNING, "")
    assert names(store) == ["0001"]
    writer.close()


def test_two_payloads_may_delete_the_same_session_at_once(store, monkeypatch):
    """The slower one stopped its recording: the session could not be deleted."""
    fill(store, size=1_500_000_000)
    unlink, count = Path.unlink, itertools.count()

    def raced(file, missing_ok=False):
        if next(count) == 0:
            store.tidy(limits(max_gb=1.0))
        unlink(file, missing_ok=missing_ok)

    monkeypatch.setattr(Path, "unlink", raced)
    store.tidy(limits(max_gb=1.0))
    assert names(store) == []


def test_a_session_may_go_while_it_is_looked_through(store, monkeypatch):
    fill(store, size=1_500_000_000)
    glob = Path.glob

    def raced(path, pattern):
        monkeypatch.undo()
        store.tidy(limits(max_gb=1.0))
        yield from glob(path, pattern)
        raise FileNotFoundError(path)  # as when it goes between two looks of glob

    monkeypatch.setattr(Path, "glob", raced)
    store.tidy(limits(max_gb=1.0))
    assert names(store) == []


def test_a_session_may_go_before_its_days_begin(store, monkeypatch):
    fill(store)

    def raced(path, mode):
        monkeypatch.undo()
        store.discard(path.parent)
        return replacing(path, mode)

    monkeypatch.setattr(session_store, "replacing", raced)
    store.tidy(limits(), stamp="20261129T120000Z")
    assert names(store) == []


def test_what_is_not_ours_stays(store):
    fill(store, size=2_000_000_000, age=1)
    foreign = [store.folder / "holidays", store.folder / "0042"]
    for folder in foreign:
        folder.mkdir()
        (folder / "session.json").write_text("{}")
        os.utime(folder / "session.json", (1.6e9, 1.6e9))
    (store.folder / "elsewhere").mkdir()
    outside = store.folder.parent / "outside"
    fill(SessionStore(outside))
    (store.folder / "0099").symlink_to(outside / "0001")
    store.tidy(limits(max_gb=0.001, max_days=0.001))
    assert names(store) == []
    assert all((folder / "session.json").exists() for folder in foreign)
    assert (outside / "0001" / "session.json").exists()


def test_a_note_that_somebody_has_put_into_a_session_stays(store):
    path = fill(store)
    (path / "notes.txt").write_text("keep me")
    store.delete(store.find("0001"))
    assert [file.name for file in path.iterdir()] == ["notes.txt"]
    assert names(store) == []


def test_a_session_that_does_not_exist_cannot_be_deleted(store):
    with pytest.raises(ConfigError, match="no session '0003'"):
        store.find("0003")


@pytest.mark.parametrize("how", ["damaged", "set aside", "gone"])
def test_what_is_left_of_a_session_is_listed_and_deleted_but_by_nobody_else(store, how):
    folder = fill(store, age=40)
    if how == "gone":
        (folder / "session.json").unlink()
    else:
        (folder / "session.json").write_text("{")
    if how == "set aside":
        assert len(store.set_damaged_aside()) == 1
    assert [each.path for each in store.with_damaged()] == [folder]
    store.tidy(limits(max_days=30))
    assert folder.exists()
    store.delete(store.find(folder.name))
    assert not folder.exists()
