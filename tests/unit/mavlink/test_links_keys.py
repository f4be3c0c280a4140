"""What a signed link keeps on disk: its key, and how far the signing time went."""

import os
import threading
from itertools import pairwise
from pathlib import Path

import pytest

from clocks import FakeClock
from full_disk import lose
from ross_payload.config import Link
from ross_payload.errors import ConfigError
from ross_payload.mavlink import Router
from ross_payload.transport.signing import SigningTime, read_key
from ross_protocols.mavlink.signing import timestamp_of
from signing_bench import KEY, TODAY


def test_a_key_is_32_bytes_or_64_digits(tmp_path: Path, key_file: Path) -> None:
    assert read_key(key_file) == KEY
    key_file.write_text(KEY.hex() + "\n")
    assert read_key(key_file) == KEY


@pytest.mark.parametrize("content", [b"", b"short", KEY + b"\n", b"g" * 64, KEY.hex().encode()[:-1]])
def test_what_is_no_key_says_what_was_found(key_file: Path, content: bytes) -> None:
    key_file.write_bytes(content)
    says = f"expected 32 bytes or 64 hexadecimal digits, got {len(content)} bytes"
    with pytest.raises(ConfigError, match=rf"^key_file .*: {says}"):
        read_key(key_file)


@pytest.mark.parametrize("mode", [0o644, 0o640, 0o604, 0o660])
def test_a_key_that_others_can_read_is_refused_with_what_to_do(key_file: Path, mode: int) -> None:
    key_file.chmod(mode)
    with pytest.raises(ConfigError, match=f"expected mode 0600, got {mode:04o}: chmod 600 {key_file}"):
        read_key(key_file)


def test_a_key_that_is_not_there_is_one_clear_line(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="cannot be read: No such file or directory"):
        Router.open([Link(url="udpin::1", key_file=str(tmp_path / "none"))], FakeClock(), state=tmp_path)


def test_a_signed_link_needs_a_folder_to_remember_the_time(key_file: Path) -> None:
    with pytest.raises(ConfigError, match="needs a folder"):
        Router.open([Link(url="udpin::1", key_file=str(key_file))], FakeClock())


def attempted(time: SigningTime) -> None:
    """Wait until the disk has taken or refused the time."""
    if time._saving is not None:
        time._saving.exception(timeout=20)


def test_a_disk_that_is_behind_holds_signing_up_and_nothing_else(tmp_path: Path) -> None:
    time = SigningTime(tmp_path / "state", lambda: TODAY, 0.0)
    assert time.stamp(0.0) is not None
    (tmp_path / "state").rename(tmp_path / "gone")
    (tmp_path / "state").write_text("in the way")
    assert time.stamp(49.0) is not None
    stamp = time.stamp(51.0)
    assert stamp is None or stamp < timestamp_of(TODAY + 50), "it waits, or has heard of the disk and stands still"
    (tmp_path / "state").unlink()
    stamp = None
    for now in (51.0, 52.5, 54.0):
        attempted(time)
        stamp = time.stamp(now) or stamp
    assert stamp is not None, "it goes on when the disk is back"
    assert stamp > timestamp_of(TODAY + 50)
    time.close()


def test_while_the_disk_takes_nothing_time_creeps_below_the_bound(tmp_path: Path) -> None:
    time = SigningTime(tmp_path / "state", lambda: TODAY, 0.0)
    bound = int((tmp_path / "state" / "signing-time").read_text())
    lose(tmp_path / "state" / "signing-time")
    time.stamp(45.0)
    attempted(time)
    stamps = [stamp for now in range(51, 3651) if (stamp := time.stamp(float(now))) is not None]
    assert len(stamps) == 3600
    assert all(after == before + 1 for before, after in pairwise(stamps))
    assert stamps[-1] < bound
    assert time.trouble.startswith(f"{tmp_path / 'state' / 'signing-time'}: ")
    time.close()


class HungDisk(SigningTime):
    """Takes a time only when it is released."""

    released = threading.Event()
    released.set()

    def _save(self, bound: int) -> int:
        assert self.released.wait(20)
        return super()._save(bound)


def test_a_disk_that_hangs_is_said(tmp_path: Path) -> None:
    time = HungDisk(tmp_path / "state", lambda: TODAY, 0.0)
    time.released = threading.Event()
    time.stamp(45.0)
    assert time.trouble == ""
    time.stamp(48.0)
    assert time.trouble.endswith("signing-time: the disk does not respond")
    time.released.set()
    attempted(time)
    time.stamp(48.1)
    assert time.trouble == ""


def test_the_time_is_for_its_owner_alone_also_where_it_was_not(tmp_path: Path) -> None:
    (tmp_path / "signing-time").write_text("5\n")
    (tmp_path / "signing-time").chmod(0o644)
    before = os.umask(0o022)
    try:
        SigningTime(tmp_path, lambda: TODAY, 0.0).close()
    finally:
        os.umask(before)
    assert (tmp_path / "signing-time").stat().st_mode & 0o777 == 0o600


@pytest.mark.parametrize("content", ["", "yesterday", "12.5", "-1", str(2**48)])
def test_a_broken_time_file_is_set_aside_and_nothing_from_before_is_believed(tmp_path: Path, content: str) -> None:
    (tmp_path / "signing-time").write_text(content)
    assert SigningTime(tmp_path, lambda: TODAY, 0.0).floor >= timestamp_of(TODAY)
    assert (tmp_path / "signing-time.unreadable").read_text() == content


def test_a_state_folder_that_takes_nothing_is_one_clear_line(tmp_path: Path) -> None:
    (tmp_path / "state").write_text("in the way")
    with pytest.raises(ConfigError, match=r"cannot be (read|saved)"):
        SigningTime(tmp_path / "state", lambda: TODAY, 0.0)
