"""Damaged logs: good frames are found wherever they are, and no bytes keep the reader busy for long."""

import time
from contextlib import suppress

import numpy as np
import pytest

from command_line import called
from examples import in_soak
from flight_logs import frames, log_of, raw_frame, record
from ross_payload.ground.errors import GroundError
from ross_payload.ground.flights import tlog_index as scanning
from ross_payload.ground.flights.reading import open_flight
from ross_payload.ground.flights.resync import LONGEST, chained
from ross_protocols.mavlink.dialect import common

HEARTBEAT = raw_frame(common.MAVLINK_MSG_ID_HEARTBEAT, bytes(9))
SIZE = 20_000_000
HOSTILE = {
    "0xFD": b"\xfd",
    "0xFE": b"\xfe",
    "both markers": b"\xfd\xfe",
    "unsigned heads": b"\xfd\x00",
    "long heads": b"\x00\x00\xfe\xff\x00",
    "signed heads": b"\xfd\xff\x01",
    "wrong checksums": bytes(8) + b"\xfd\x09" + bytes(19),
}


def unknown(sequence):
    """A frame of a message that nobody here knows, MAVLink 1."""
    return bytes([0xFE, 3, sequence, 1, 1, 251 if 251 not in scanning.EXTRAS else 255]) + bytes(5)


def pieces(rng):
    """Good records, damaged ones, unknown ones, markers and noise in any order."""
    good = [record(10**15, frame) for frame in frames(2)]
    kinds = (
        lambda: good[rng.integers(len(good))],
        lambda: b"".join(record(10**15, unknown(count)) for count in range(rng.integers(1, 12))),
        lambda: bytes(rng.choice(np.array([0xFD, 0xFE, 0, 1], np.uint8), rng.integers(1, 60))),
        lambda: rng.bytes(rng.integers(1, 40)),
        lambda: good[rng.integers(len(good))][: rng.integers(1, 30)],
    )
    return b"".join(kinds[rng.integers(len(kinds))]() for _ in range(60))


@pytest.mark.parametrize("seed", [0, 1, *in_soak(*range(2, 8))])
def test_all_places_at_once_are_those_that_are_found_one_by_one(seed):
    data = pieces(np.random.default_rng(seed))
    whole = [place for place in range(len(data)) if scanning._chained(data, place)]
    assert chained(data, 0, len(data)).tolist() == whole
    assert whole, "the test needs places"
    middle = len(data) // 3
    assert chained(data, middle, middle + 500).tolist() == [p for p in whole if middle <= p < middle + 500]


def test_frames_behind_damage_are_all_found(tmp_path):
    here = log_of(frames(20))
    (tmp_path / "a.tlog").write_bytes(here + b"\xfe" * (1 << 19) + here + bytes(LONGEST) + here)
    flight = open_flight(tmp_path / "a.tlog")
    assert len(flight.index) == 3 * len(frames(20))


def computing(path):
    """Seconds of computing until a log is opened or refused."""
    began = time.process_time()
    with suppress(GroundError):
        open_flight(path)
    return time.process_time() - began


@pytest.mark.soak
@pytest.mark.parametrize("kind", HOSTILE)
@pytest.mark.parametrize("before", [b"", record(10**15, HEARTBEAT) * 2], ids=["alone", "behind frames"])
def test_20_mb_of_any_bytes_take_less_than_3_s_of_computing(tmp_path, kind, before):
    (tmp_path / "a.tlog").write_bytes(before + HOSTILE[kind] * (SIZE // len(HOSTILE[kind])))
    assert computing(tmp_path / "a.tlog") < 3


@pytest.mark.parametrize("kind", ["0xFD", *in_soak("0xFE")])
def test_8_mb_of_markers_behind_a_frame_take_less_than_3_s_of_computing(tmp_path, kind):
    (tmp_path / "a.tlog").write_bytes(record(10**15, HEARTBEAT) * 2 + HOSTILE[kind] * 8_000_000)
    assert computing(tmp_path / "a.tlog") < 3


@pytest.mark.parametrize("stamp", [2**64 - 1, 4_417_000_000_000_000, *in_soak(2**62, 10**18, 253_402_300_800_000_000)])
def test_a_stamp_past_what_calendars_hold_is_no_date(tmp_path, monkeypatch, capsys, stamp):
    (tmp_path / "a.tlog").write_bytes(b"".join(record(stamp, frame) for frame in frames(5)))
    for more in ([], ["--json"]):
        code, out, err = called(monkeypatch, capsys, "tlog", tmp_path / "a.tlog", *more)
        assert (code, err) == (0, "")
        assert "Traceback" not in out
    assert open_flight(tmp_path / "a.tlog").start is None
