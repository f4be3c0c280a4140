"""`ross voice-model`: a network that compares voices, from the file to a mission."""

import json

import pytest
import soundfile

from ross_payload.voiceprint import VoiceStore
from ross_payload.voiceprint.built_in import built_in_model
from ross_payload.voiceprint.features import RATE
from ross_payload.voiceprint.model_folder import ModelFolder
from speaker_network import SIZE, speaker_network, vowel

ANOTHER = "made with another model of voices than the one in use: see ross voice-model list"

pytestmark = pytest.mark.usefixtures("undrawn")


@pytest.fixture
def file(tmp_path, monkeypatch):
    """A network's file; what is kept is kept for this test alone."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "own"))
    path = tmp_path / "small.onnx"
    path.write_bytes(speaker_network())
    return path


def test_the_command_adds_lists_enrols_and_removes(run, file, tmp_path):
    voice = tmp_path / "voice.wav"
    soundfile.write(voice, vowel(), RATE)
    assert run("voice-model", "list")[:2] == (0, "* built-in\n")
    code, out, _ = run("voice-model", "add", str(file))
    assert code == 0
    numbers = SIZE + built_in_model().size
    assert f"added small: 0.0 MB, {numbers} numbers for each voice\nlicence: CC0-1.0\n" in out
    assert run("voice-model", "list")[1] == "  built-in\n* small\n"
    assert run("enroll", "ann", str(voice))[0] == 0
    model = ModelFolder.default().in_use()
    assert VoiceStore.default().load("ann", model).fingerprint == model.fingerprint
    assert run("voice-model", "remove", "small")[0] == 0
    code, _, err = run("voice-model", "remove", "small")
    assert (code, err) == (2, "ross: no voice model 'small' was added\n")


def test_what_a_network_says_of_itself_is_a_line_and_not_a_command_to_the_terminal(run, file):
    file.write_bytes(speaker_network(licence="MIT\x1b[2J\nadded: all is well" + 1000 * "x"))
    code, out, _ = run("voice-model", "add", str(file))
    assert code == 0
    (line,) = [each for each in out.split("\n") if each.startswith("licence: ")]
    assert line.startswith("licence: MIT\\x1b[2J\\nadded: all is well")
    assert len(line) < 300
    assert "\x1b" not in out


def test_a_mission_recognises_by_the_network_and_is_replayed_from_its_recorded_answers(run, file, tmp_path):
    scores = {}
    assert run("voice-model", "add", str(file))[0] == 0
    for model, folder in (("auto", "tape"), ("built-in", "other")):
        scenario = tmp_path / f"{model}.toml"
        scenario.write_text(SHORT + f'[payload.voice_print]\nmodel = "{model}"\n')
        told = ("--scenario", scenario, "--informed", "--out", tmp_path / model, "--record", tmp_path / folder)
        code, _, err = run("sitl", *told)
        assert code in (0, 3), err
        scores[model] = json.loads((tmp_path / model / "report.json").read_text())["groups"]
    assert scores["auto"] != scores["built-in"]

    (session,) = (tmp_path / "tape").iterdir()
    changed = ("replay", str(session), "--json", "--set", "exploit.separator=duet")
    code, out, err = run(*changed)
    assert (code, err) == (0, "")
    assert json.loads(out)["voice"].endswith("kept with the session")
    assert run("voice-model", "remove", "small")[0] == 0
    assert run(*changed)[::2] == (2, f"ross: voice.npz: {ANOTHER}\n")
    code, out, err = run("replay", str(session), "--json")
    assert (code, err) == (0, "")
    told = json.loads(out)
    assert (told["identical"], told["parted"]) == (True, "")
    assert told["voice"].startswith("recorded answers")


def test_what_was_recorded_with_a_model_that_is_not_here_is_replayed_from_its_recorded_answers(run, file, tmp_path):
    scenario = tmp_path / "scenario.toml"
    scenario.write_text(SHORT + '[payload.voice_print]\nmodel = "small"\n')
    assert run("voice-model", "add", str(file))[0] == 0
    assert run("sitl", "--scenario", scenario, "--informed", "--record", tmp_path / "tape")[0] in (0, 3)
    assert run("voice-model", "remove", "small")[0] == 0
    code, out, err = run("replay", tmp_path / "tape" / "0001", "--json")
    assert (code, err) == (0, "")
    told = json.loads(out)
    assert told["identical"]
    assert told["voice"].startswith("recorded answers")
    changed = run("replay", tmp_path / "tape" / "0001", "--json", "--set", "exploit.separator=duet")
    assert changed[::2] == (2, "ross: voice model 'small' is unknown; there are: auto, built-in\n")


def test_a_voice_that_is_enrolled_here_with_another_model_is_replayed_from_its_recorded_answers(run, file, tmp_path):
    scenario, voice = tmp_path / "scenario.toml", tmp_path / "voice.wav"
    scenario.write_text(SHORT)
    soundfile.write(voice, vowel(), RATE)
    assert run("enroll", "ann", str(voice))[0] == 0
    asked = ("sitl", "--scenario", scenario, "--informed", "--target", "ann", "--record", tmp_path / "tape")
    assert run(*asked)[0] in (0, 3)
    session = tmp_path / "tape" / "0001"
    assert json.loads(run("replay", session, "--json")[1])["voice"] == "the voice 'ann' as it is enrolled here"
    assert run("voice-model", "add", str(file))[0] == 0
    told = json.loads(run("replay", session, "--json")[1])
    assert told["identical"]
    assert told["voice"].startswith("recorded answers: ")
    assert told["voice"].endswith("made with another voice model: enrol this voice again")
    assert run("replay", session, "--set", "exploit.separator=duet")[0] == 2


def test_a_print_of_another_model_is_refused_before_anything_opens(run, file, tmp_path):
    voice, payload = tmp_path / "voice.wav", tmp_path / "payload.toml"
    soundfile.write(voice, vowel(), RATE)
    payload.write_text('service.target = "ann"\n[audio]\nsource = "device:none"\n')
    assert run("enroll", "ann", str(voice))[0] == 0
    assert run("config", "check", str(payload))[0] == 0
    assert run("voice-model", "add", str(file))[0] == 0
    code, _, err = run("config", "check", str(payload))
    assert code == 2
    assert "service.target: " in err
    assert err.endswith("made with another voice model: enrol this voice again\n")


def test_a_model_that_is_not_there_is_one_line(run, tmp_path):
    scenario = tmp_path / "scenario.toml"
    scenario.write_text(SHORT + '[payload.voice_print]\nmodel = "ecapa"\n')
    code, _, err = run("sitl", "--scenario", str(scenario))
    assert (code, err) == (2, "ross: voice model 'ecapa' is unknown; there are: auto, built-in\n")


SHORT = """
title = "one talker"
[payload.explore]
lead_in_s = 1.0
unit_s = 1.0
min_rotations = 2
max_rotations = 2
[payload.exploit]
separator = "gaussian"
track = false
check_s = 1.0
run_s = 1.0
max_restarts = 0
[[talkers]]
azimuth_deg = 40
"""
