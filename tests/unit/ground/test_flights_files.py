"""Files that are no log of a flight, and folders of sessions: told in one line."""

import json
import os

import pytest

from flight_logs import frames, log_of
from nobody import nobody
from ross_payload.ground.errors import GroundError
from ross_payload.ground.flights.reading import open_flight


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "an empty file"),
        (b"hello\n" * 100, "a text"),
        (bytes(1000), "no frame of MAVLink"),
        (b"\xa3\x95\x80\x80" * 50, "an ArduPilot flight log (.bin)"),
        (b"ULog\x01\x12\x35" + bytes(100), "a PX4 flight log (.ulg)"),
        (b"".join(frames(2)), "MAVLink without times (a .raw file)"),
    ],
)
def test_what_is_no_log_is_named_in_one_line(opened, data, words):
    with pytest.raises(GroundError) as refused:
        opened(data)
    assert f"expected a telemetry log (.tlog) or a session folder, got {words}" in refused.value.message
    assert "\n" not in refused.value.message
    assert refused.value.exit_code == 2


def test_a_pipe_is_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(GroundError, match="got a named pipe"):
        open_flight(tmp_path / "pipe")


@pytest.mark.parametrize("name", ["missing.tlog", "dangling.tlog", "loop.tlog", "x" * 5000])
def test_what_is_not_there_is_told(tmp_path, name):
    (tmp_path / "dangling.tlog").symlink_to(tmp_path / "nowhere")
    (tmp_path / "loop.tlog").symlink_to(tmp_path / "loop.tlog")
    with pytest.raises(GroundError, match="cannot be read: "):
        open_flight(tmp_path / name)


def test_a_log_that_may_not_be_read_is_told(tmp_path):
    path = tmp_path / "secret.tlog"
    path.write_bytes(log_of(frames(1)))
    path.chmod(0)
    with nobody(), pytest.raises(GroundError, match="Permission denied"):
        open_flight(path)


def test_a_link_to_a_log_is_the_log(tmp_path):
    (tmp_path / "real").write_bytes(log_of(frames(1)))
    (tmp_path / "link.tlog").symlink_to(tmp_path / "real")
    assert len(open_flight(tmp_path / "link.tlog").index) == 11


@pytest.mark.parametrize("started", ["2026-11-21T14:54:21+00:00", "20261121T145421Z", "2026-11-21T14:54:21"])
def test_a_session_folder_tells_when_it_began(tmp_path, started):
    folder = tmp_path / "0007-20261121T145421Z"
    folder.mkdir()
    (folder / "telemetry.tlog").write_bytes(log_of(frames(1), start=0))
    (folder / "session.json").write_text(json.dumps({"started": started, "end": None}))
    flight = open_flight(folder)
    assert flight.name == folder.name
    assert flight.start == 1_795_272_861
    assert flight.notes == ("the session was cut off",)


@pytest.mark.parametrize("manifest", ["", "[" * 100_000, "3", '{"started": 9e999, "end": "done"}'])
def test_a_manifest_that_is_none_hurts_nobody(tmp_path, manifest):
    (tmp_path / "telemetry.tlog").write_bytes(log_of(frames(1), start=0))
    (tmp_path / "session.json").write_text(manifest)
    assert open_flight(tmp_path).start is None


def test_a_folder_without_a_log_is_told(tmp_path):
    with pytest.raises(GroundError, match=r"got a folder without telemetry\.tlog or mission\.tlog"):
        open_flight(tmp_path)
