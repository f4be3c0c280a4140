"""Every mistake of a user is one clear line, exit code 2, and nothing is lost or moved."""

import sys

import numpy as np
import pytest
import soundfile

from ross_sim.sitl import mission_session


def test_an_out_that_is_a_file_is_refused_before_anything_moves(run, tmp_path):
    (tmp_path / "out").write_text("mine")
    code, out, err = run("sitl", "--out", tmp_path / "out")
    assert (code, out) == (2, "")
    assert err.count("\n") == 1
    assert (tmp_path / "out").read_text() == "mine"


def test_without_matplotlib_results_are_refused_before_anything_moves(run, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.delitem(sys.modules, "ross_sim.sitl.mission_figure", raising=False)
    monkeypatch.setattr(mission_session, "_staged", None)
    code, out, err = run("sitl", "--out", tmp_path / "out")
    assert (code, out) == (2, "")
    assert "needs the package matplotlib" in err
    assert not (tmp_path / "out").exists()


def voices(folder, *clips):
    folder.mkdir()
    for index, clip in enumerate(clips):
        soundfile.write(folder / f"talker{index}.wav", clip, 16000, subtype="FLOAT")
    return folder


def noise(seed, seconds=12.0):
    return 0.1 * np.random.default_rng(seed).standard_normal(int(16000 * seconds))


BAD_SPEECH = {
    "missing": lambda folder: folder,
    "few": lambda folder: voices(folder, noise(1), noise(2)),
    "silent": lambda folder: voices(folder, noise(1), noise(2), np.zeros(160000)),
    "empty": lambda folder: voices(folder, noise(1), noise(2), np.zeros(0)),
    "nan": lambda folder: voices(folder, noise(1), noise(2), np.full(160000, np.nan)),
}


@pytest.mark.parametrize("kind", BAD_SPEECH)
def test_bad_speech_is_one_line_and_exit_code_2(run, tmp_path, kind):
    code, out, err = run("sitl", "--speech", BAD_SPEECH[kind](tmp_path / "speech"))
    assert (code, out) == (2, "")
    assert err.count("\n") == 1, err


def test_a_file_that_is_not_audio_is_named(run, tmp_path):
    folder = voices(tmp_path / "speech", noise(1), noise(2), noise(3))
    (folder / "talker3.wav").write_text("not audio")
    code, _, err = run("sitl", "--speech", folder)
    assert code == 2
    assert "talker3.wav" in err


BAD_SCENARIOS = {
    "from the centre of the array": "title = 'x'\n[[talkers]]\nazimuth_deg = 0\ndistance_m = 0.05\n",
    "inside the room": "title = 'x'\n[[talkers]]\nazimuth_deg = 0\ndistance_m = 50\n",
    "spacing_m": "title = 'x'\ntalkers = []\n[payload.array]\nspacing_m = 0\n",
    "snr_db": "title = 'x'\ntalkers = []\n[noise]\nsnr_db = -1e6\n",
    "payload.listening.streams.0.sink: sink 'gramophone' is unknown": (
        "title = 'x'\ntalkers = []\n[[payload.listening.streams]]\nsink = 'gramophone'\n"
    ),
    "payload.listening.streams.0.options of 'file': unknown key 'pfad'": (
        "title = 'x'\ntalkers = []\n[[payload.listening.streams]]\nsink = 'file'\noptions = { pfad = 'x.wav' }\n"
    ),
    "unknown key 'colour'": "title = 'x'\ncolour = 'red'\ntalkers = []\n",
    "noise.sources.0.distance_m: expected a number less than or equal to 1000": (
        "title = 'x'\ntalkers = []\n[[noise.sources]]\nname = 'x'\nkind = 'babble'\nsnr_db = 10\ndistance_m = 1e6\n"
    ),
    "talkers.0.distance_m: expected a number less than or equal to 1000": (
        "title = 'x'\n[[talkers]]\nazimuth_deg = 0\ndistance_m = 1e6\n"
    ),
    "room.size_m: expected sides of at most 2000 m": "title = 'x'\ntalkers = []\n[room]\nsize_m = [4e6, 4e6]\n",
    "not TOML": "= = =",
}


@pytest.mark.parametrize("words", BAD_SCENARIOS)
def test_a_bad_scenario_is_one_line_and_exit_code_2(run, tmp_path, words):
    path = tmp_path / "bad.toml"
    path.write_text(BAD_SCENARIOS[words])
    code, out, err = run("sitl", "--scenario", path, "--out", tmp_path / "out")
    assert (code, out) == (2, "")
    assert words in err
    assert err.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_an_unknown_scenario_lists_what_exists(run):
    code, _, err = run("sitl", "--scenario", "party")
    assert code == 2
    assert "demo" in err


def test_an_unknown_target_lists_who_exists(run, short):
    code, _, err = run("sitl", "--scenario", short, "--target", "zaphod")
    assert code == 2
    assert "zaphod" in err


@pytest.mark.parametrize("url", ["tcp:127.0.0.1:9", "udp:127.0.0.1:14550", "udpout:127.0.0.1:99999", "serial:x"])
def test_telemetry_that_cannot_work_is_refused_before_anything_moves(run, short, tmp_path, url):
    code, out, err = run("sitl", "--scenario", short, "--telemetry", url, "--out", tmp_path / "out")
    assert (code, out) == (2, "")
    assert err.count("\n") == 1
