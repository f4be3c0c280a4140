"""Telemetry logs: whole records or none, on a disk that misbehaves too."""

import errno
import resource
import signal
import struct
from pathlib import Path

import pytest

from ross_payload.errors import ConfigError, OutputError
from ross_payload.transport.tlog import TlogRecorder
from ross_protocols.mavlink.codec import Encoder
from ross_protocols.mavlink.values import Health, Heartbeat

FRAME = Encoder(1, 191).encode(Heartbeat(Health.ACTIVE, 6))


def test_a_record_is_the_time_and_the_frame(tmp_path: Path) -> None:
    with TlogRecorder(tmp_path / "a.tlog") as log:
        log.write(1_000_000, FRAME)
        log.write(2_500_003, FRAME)
    record = struct.Struct(f">Q{len(FRAME)}s")
    assert list(record.iter_unpack((tmp_path / "a.tlog").read_bytes())) == [(1_000_000, FRAME), (2_500_000, FRAME)]


def test_a_record_is_on_its_way_to_the_disk_at_once(tmp_path: Path) -> None:
    log = TlogRecorder(tmp_path / "a.tlog")
    log.write(0, FRAME)
    assert len((tmp_path / "a.tlog").read_bytes()) == 8 + len(FRAME)  # whatever happens to this process next
    log.close()


def test_a_log_that_cannot_be_made_is_one_clear_line(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="cannot be written: No such file or directory"):
        TlogRecorder(tmp_path / "missing" / "a.tlog")


def test_a_full_disk_leaves_whole_records(tmp_path: Path) -> None:
    """A limit on the size of files stands for the disk: the third record fits in part only."""
    size = 8 + len(FRAME)
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    log = TlogRecorder(tmp_path / "a.tlog")
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (2 * size + 5, before[1]))
        log.write(0, FRAME)
        log.write(4, FRAME)
        with pytest.raises(OutputError, match=r"a\.tlog: cannot be written: "):
            log.write(8, FRAME)
        with pytest.raises(OutputError):
            log.write(12, FRAME)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, handler)
    log.close()
    assert len((tmp_path / "a.tlog").read_bytes()) == 2 * size


def test_a_device_that_is_full_is_one_clear_line() -> None:
    full = Path("/dev/full")
    if not full.exists():
        pytest.skip("this system has no /dev/full")
    with TlogRecorder(full) as log, pytest.raises(OutputError) as error:
        log.write(0, FRAME)
    assert getattr(error.value.__cause__, "errno", None) == errno.ENOSPC
