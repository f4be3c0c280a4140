"""`ross calibrate` on a recording: what it prints, writes and refuses."""

import json
import math
import socket
import threading
import time
from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
import soundfile

from command_line import called
from ross_payload.calibration.estimate import Calibration
from ross_payload.config import Config, load
from ross_payload.doctor.calibration_report import changes
from ross_payload.service.state_folder import owned
from ross_protocols.audio.pcm import Header, encode_header
from turned_array import RATE, SECONDS, around, heard_at

TRUE = {"spacing": 0.064, "gain_db": 1.5, "inverted": True}


@pytest.fixture
def files(tmp_path):
    """A configuration, a recording of another array, and the table of its joint angles."""
    config, wav, table = tmp_path / "ross.toml", tmp_path / "turn.wav", tmp_path / "turn.csv"
    config.write_text("[array]\nspacing_m = 0.05  # guessed\n")
    record(wav, table, **TRUE)
    return config, wav, table


def record(wav, table, count=8, **like):
    headings = around(count)
    soundfile.write(wav, np.concatenate(list(heard_at(headings, **like)), axis=1).T, RATE, subtype="PCM_24")
    lines = [f"{i * SECONDS},{(i + 1) * SECONDS},{math.degrees(h):g}" for i, h in enumerate(headings)]
    table.write_text("from_s,to_s,joint_deg\n" + "\n".join(lines) + "\n")


def offline(files, *more):
    config, wav, table = files
    return ("calibrate", config, "--recording", wav, "--angles", table, *more)


def test_it_says_what_differs_and_writes_nothing_unasked(files, monkeypatch, capsys):
    before = files[0].read_text()
    code, out, err = called(monkeypatch, capsys, *offline(files))
    assert (code, err) == (0, "")
    assert "64.0" in out
    assert "opposite polarity" in out
    assert "no azimuth is known (--azimuth)" in out
    assert "--write would set array.spacing_m = 0.064, audio.gain_db = [0.0, -1.5], audio.invert = [false, true]" in out
    assert files[0].read_text() == before


def test_a_table_written_by_hand_may_have_spaces_and_blank_lines(files, monkeypatch, capsys):
    table = files[2]
    head, *lines = table.read_text().replace(",", " , ").splitlines()
    table.write_text("\n \n" + "\n\n".join([head, *(f"{line},," for line in lines), ",,\n"]))
    code, out, err = called(monkeypatch, capsys, *offline(files))
    assert (code, err) == (0, "")
    assert "64.0" in out


@pytest.mark.parametrize(
    ("head", "words"),
    [
        (
            "from;to;joint\n",
            "expected numbers in the columns from_s, to_s, joint_deg, got the columns 'from;to;joint'",
        ),
        ("from_s,to_s,joint_deg\n\n0,1,north\n", "turn.csv: line 3: expected numbers"),
        ("from_s,to_s,joint_deg\n0.1,2.5,7\n", "expected one angle at a time, got 0 and 7"),
        ("from_s,to_s,joint_deg,joint_deg\n0,2,1,7\n", "turn.csv: expected one column joint_deg, got 2"),
        ("from_s,to_s,joint_deg\n0,2,1,7\n", "turn.csv: line 2: expected 3 columns, got 4"),
    ],
)
def test_a_table_that_cannot_be_meant_is_one_line_with_its_place(files, monkeypatch, capsys, head, words):
    files[2].write_text(files[2].read_text().replace("from_s,to_s,joint_deg\n", head, 1))
    code, out, err = called(monkeypatch, capsys, *offline(files))
    assert (code, out) == (2, "")
    assert words in err
    assert err.count("\n") == 1


def test_what_it_writes_makes_the_array_agree(files, monkeypatch, capsys):
    azimuth = f"{math.degrees(-0.7) % 360:.3f}"  # of the sound, on a compass
    code, out, _ = called(monkeypatch, capsys, *offline(files, "--write", "--azimuth", azimuth))
    assert code == 0
    assert "the old file is ross.toml.before" in out
    assert "# guessed" in files[0].read_text()
    config = load(files[0])
    assert config.array.spacing_m == pytest.approx(0.064, abs=5e-4)
    assert (config.audio.gain_db, config.audio.invert) == ((0.0, pytest.approx(-1.5, abs=0.1)), (False, True))
    code, out, _ = called(monkeypatch, capsys, *offline(files, "--azimuth", azimuth))
    assert "the configuration agrees with what was heard" in out


@pytest.mark.parametrize("channels", [[0, 1], [1, 0]])
def test_a_difference_of_roll_off_is_written_and_then_agrees(files, monkeypatch, capsys, channels):
    config, wav, table = files
    config.write_text(f"[audio]\nchannels = {channels}\n")
    record(wav, table, roll_off=40.0)
    code, out, _ = called(monkeypatch, capsys, *offline(files, "--write"))
    assert code == 0
    assert "4.6 deg at 500 Hz, with roll_off_hz = [0, 0]" in out
    corners = load(config).audio.roll_off_hz
    assert corners[channels.index(1)] == pytest.approx(40.0, abs=2.0)
    assert corners[channels.index(0)] == 0.0
    code, out, _ = called(monkeypatch, capsys, *offline(files))
    assert "of microphone 2 +0 ± " in out
    assert "the configuration agrees with what was heard" in out


@pytest.mark.parametrize(("swapped", "wanted"), [(False, [0.0, 45.0]), (True, [45.0, 0.0])])
def test_corners_add_to_those_configured_and_change_places_with_the_microphones(swapped, wanted):
    config = Config.model_validate({"audio": {"roll_off_hz": [10.0, 35.0]}})
    found = Calibration(
        0.05, 0.001, 0.0, 0.01, 0.0, swapped, 0.0, 0.1, inverted=False, delay=None, delay_sigma=None,
        roll_off=20.0, roll_off_sigma=1.0, direct=1.0, headings=12, turn=6.0,
    )  # fmt: skip
    assert changes(config, found)["audio.roll_off_hz"] == wanted
    alike = replace(found, swapped=False, roll_off=1.9, roll_off_sigma=0.1)
    assert changes(config, alike) == {}


@pytest.mark.soak
def test_a_known_azimuth_gives_the_offset(files, monkeypatch, capsys):
    wrong = f"{math.degrees(-0.7) - 10:.3f}"  # 10 deg counter-clockwise of where it sounds by the configuration
    code, out, _ = called(monkeypatch, capsys, *offline(files, "--json", "--azimuth", wrong))
    values = json.loads(out)
    assert code == 0
    assert math.degrees(values["calibration"]["offset"]) == pytest.approx(10.0, abs=0.5)
    assert values["changes"]["array.offset_deg"] == pytest.approx(10.0, abs=0.5)


@pytest.mark.parametrize(
    ("more", "why"),
    [
        (("--session", "x"), "expected --session or --recording, got both"),
        (("--azimuth", "nan"), "Invalid value for '--azimuth': expected a finite number, got nan"),
        (("--turn", "30"), "30.0 is not in the range 90<=x<=360"),
    ],
)
def test_options_that_contradict_each_other_are_one_line(files, monkeypatch, capsys, more, why):
    code, out, err = called(monkeypatch, capsys, *offline(files, *more))
    assert (code, out) == (2, "")
    assert why in err
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("table", "why"),
    [
        ("from_s,to_s\n0,1\n", "line 2: expected numbers in the columns from_s, to_s, joint_deg"),
        ("from_s,to_s,joint_deg\n0,1,x\n", "line 2: expected numbers in the columns"),
        ("from_s,to_s,joint_deg\n0,1,nan\n", "line 2: expected finite numbers"),
        ("from_s,to_s,joint_deg\n0,1,0\n7,99,30\n", "line 3: expected 0 <= from_s < to_s <= 8, got 7, 99"),
        ("from_s,to_s,joint_deg\n0,1,0\n", "expected to listen at 6 headings at rest or more"),
        ("", "expected to listen at 6 headings"),
    ],
)
def test_a_table_that_does_not_serve_is_one_line(files, monkeypatch, capsys, table, why):
    files[2].write_text(table)
    code, out, err = called(monkeypatch, capsys, *offline(files, "--write"))
    assert (code, out) == (2, "")
    assert why in err
    assert err.count("\n") == 1
    assert "# guessed" in files[0].read_text()


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (("--recording", "x.wav"), "expected --recording and --angles together"),
        (("--session", "nowhere"), "not a session folder"),
        (("--recording", "no.wav", "--angles", "no.csv"), "no.wav: no such file"),
    ],
)
def test_files_that_are_missing_are_one_line(files, monkeypatch, capsys, arguments, why):
    code, _, err = called(monkeypatch, capsys, "calibrate", files[0], *arguments)
    assert code == 2
    assert why in err
    assert err.count("\n") == 1


def test_a_recording_in_the_place_of_microphones_is_refused_before_anything_turns(files, monkeypatch, capsys, tmp_path):
    files[0].write_text(f'[audio]\nsource = "file:{files[1]}"\n[service]\nstate_dir = "{tmp_path}"\n')
    code, _, err = called(monkeypatch, capsys, "calibrate", files[0], "--yes")
    assert code == 2
    assert "expected microphones, got a file: a recording is read with --recording" in err


def test_a_payload_that_was_stopped_is_not_calibrated(tmp_path, monkeypatch, capsys):
    (tmp_path / "stopped").touch()
    config = tmp_path / "ross.toml"
    config.write_text(f"[audio]\nsource = 'device:0'\n[service]\nstate_dir = '{tmp_path}'\n")
    code, _, err = called(monkeypatch, capsys, "calibrate", config, "--yes")
    assert (code, err) == (1, "ross: the payload was stopped by a command: re-arm it first\n")


def test_a_payload_that_runs_is_not_calibrated(tmp_path, monkeypatch, capsys):
    config = tmp_path / "ross.toml"
    config.write_text(f"[audio]\nsource = 'device:0'\n[service]\nstate_dir = '{tmp_path}'\n")
    with owned(tmp_path):
        code, _, err = called(monkeypatch, capsys, "calibrate", config, "--yes")
    assert code == 2
    assert f"expected a folder that no other payload uses, got {tmp_path}" in err
    assert err.count("\n") == 1


def silence(server):
    """For one who listens, as it passes, until he has gone."""
    with server.accept()[0] as client, suppress(OSError):
        client.sendall(encode_header(Header(RATE, 2)))
        while True:
            client.sendall(bytes(6 * RATE // 100))
            time.sleep(0.01)


def test_a_declared_zero_is_not_believed_after_a_payload_that_died_away_from_it(tmp_path, monkeypatch, capsys):
    (tmp_path / "away").touch()
    with socket.create_server(("127.0.0.1", 0)) as server:
        config = tmp_path / "ross.toml"
        source = f"tcp:127.0.0.1:{server.getsockname()[1]}"
        state = f"[service]\nstate_dir = '{tmp_path}'\n"
        config.write_text(f"[audio]\nsource = '{source}'\n[actuator]\nkind = 'tb6600'\n{state}")
        sound = threading.Thread(target=silence, args=(server,))
        sound.start()
        code, _, err = called(monkeypatch, capsys, "calibrate", config, "--yes")
        sound.join()
    assert code == 1
    assert "the zero of the joint is not known" in err
    assert (tmp_path / "away").exists()
