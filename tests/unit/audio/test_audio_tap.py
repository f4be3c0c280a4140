"""The tap test tells swapped microphones; `ross devices` lists what there is."""

import json
import sys
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
import soundfile
from click.testing import CliRunner

from ross_payload import cli
from ross_payload.audio.command import command
from ross_payload.audio.sound_devices import devices, portaudio
from ross_payload.audio.tap_test import Tap, TapFinder, verdict, wait
from ross_payload.config import Config
from ross_payload.errors import AudioError, ConfigError
from ross_sim.clock import SimClock

RATE, HOP = 16000, 160


def tapped(*taps, seconds=5.0, noise=0.001, between_db=12.0):
    """Noise with taps at (time [s], microphone): a ringing click, weaker at the other one."""
    samples = noise * np.random.default_rng(1).standard_normal((2, round(seconds * RATE)))
    time = np.arange(800) / RATE
    click = 0.3 * np.exp(-time / 0.005) * np.sin(2 * np.pi * 2000 * time)
    for begin, microphone in taps:
        rows = slice(round(begin * RATE), round(begin * RATE) + len(click))
        samples[microphone - 1, rows] += click
        samples[2 - microphone, rows] += click * 10 ** (-between_db / 20)
    return samples.astype(np.float32)


def found(samples):
    finder = TapFinder()
    hops = [samples[:, begin : begin + HOP] for begin in range(0, samples.shape[1] - HOP + 1, HOP)]
    return [tap for tap in map(finder.listen, hops) if tap is not None]


def test_each_tap_is_heard_once_at_its_microphone():
    taps = found(tapped((1.0, 2), (2.5, 1), (4.0, 2)))
    assert [tap.microphone for tap in taps] == [2, 1, 2]
    assert [tap.margin_db for tap in taps] == pytest.approx([12] * 3, abs=1)
    assert all(tap.clear for tap in taps)


def test_noise_and_speech_like_swells_are_no_taps():
    swell = 0.2 * np.sin(np.pi * np.linspace(0, 1, 5 * RATE)) * np.sin(2 * np.pi * 200 * np.arange(5 * RATE) / RATE)
    assert found(tapped() + swell.astype(np.float32)) == []


def test_a_clap_in_the_room_is_not_clear():
    assert [tap.clear for tap in found(tapped((2.0, 1), between_db=1.0))] == [False]


def test_a_switch_on_pop_before_the_background_is_known_is_no_tap():
    assert found(tapped((0.05, 1), (2.0, 2)))[-1].microphone == 2
    assert len(found(tapped((0.05, 1), (2.0, 2)))) == 1


@pytest.mark.parametrize(
    ("order", "said"),
    [
        ((1, 2), "are as configured"),
        ((2, 1), r"swapped: write channels = \[1, 0\] in \[audio\]"),
        ((1, 1), "Both taps were heard at microphone 1"),
    ],
)
def test_the_verdict_says_what_to_write(order, said):
    taps = [Tap(microphone, 12.0) for microphone in order]
    with pytest.raises(AssertionError, match=said):
        raise AssertionError(verdict(Config(), *taps))


def test_the_tap_test_runs_on_a_configuration(tmp_path):
    soundfile.write(tmp_path / "taps.wav", tapped((1.0, 2), (2.0, 1), seconds=3.0).T, RATE, subtype="PCM_24")
    (tmp_path / "payload.toml").write_text(f'[audio]\nsource = "file:{tmp_path}/taps.wav"\n')
    said = CliRunner().invoke(command, ["--tap", str(tmp_path / "payload.toml")], catch_exceptions=False)
    assert "Tap microphone 1" in said.output
    assert "The microphones are swapped: write channels = [1, 0] in [audio]." in said.output


CARDS = SimpleNamespace(
    query_hostapis=lambda: [{"name": "ALSA"}],
    query_devices=lambda: [
        {"name": "HDMI", "hostapi": 0, "max_input_channels": 0, "default_samplerate": 44100.0},
        {"name": "ReSpeaker 4 Mic Array", "hostapi": 0, "max_input_channels": 6, "default_samplerate": 16000.0},
    ],
)


def test_devices_that_cannot_record_are_not_listed():
    only = devices(CARDS)
    assert [(device.number, device.preset, device.channels) for device in only] == [(1, "respeaker-usb", 6)]


def test_json_is_a_list_of_devices_and_nothing_else(monkeypatch):
    module = ModuleType("sounddevice")
    module.__dict__.update(vars(CARDS))
    monkeypatch.setitem(sys.modules, "sounddevice", module)
    said = CliRunner().invoke(command, ["--json"], catch_exceptions=False)
    [device] = json.loads(said.output)
    assert (device["name"], device["default_rate"]) == ("ReSpeaker 4 Mic Array", 16000.0)
    assert "respeaker-usb" in CliRunner().invoke(command, [], catch_exceptions=False).output


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("raise OSError('PortAudio library not found')", "apt install libportaudio2"),
        ("raise ModuleNotFoundError(\"No module named 'sounddevice'\")", "pip install 'sounddevice>="),
    ],
)
def test_what_the_system_lacks_is_named_and_the_command_ends_with_2(tmp_path, monkeypatch, capsys, text, said):
    (tmp_path / "sounddevice.py").write_text(text)
    monkeypatch.delitem(sys.modules, "sounddevice", raising=False)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "argv", ["ross", "devices"])
    with pytest.raises(SystemExit) as end:
        cli.main()
    assert end.value.code == 2
    error = capsys.readouterr().err.strip()
    assert said in error
    assert "\n" not in error


def test_no_clear_tap_is_an_error_and_not_a_guess(tmp_path):
    soundfile.write(tmp_path / "quiet.wav", tapped(seconds=0.5).T, RATE, subtype="PCM_24")
    (tmp_path / "payload.toml").write_text(f'[audio]\nsource = "file:{tmp_path}/quiet.wav"\n')
    with pytest.raises(AudioError, match="end of file"):
        CliRunner().invoke(command, ["--tap", str(tmp_path / "payload.toml")], catch_exceptions=False)


def test_the_binding_is_imported_only_when_it_is_asked_for(monkeypatch):
    monkeypatch.setitem(sys.modules, "sounddevice", CARDS)
    assert portaudio() is CARDS


def test_a_source_that_comes_late_is_waited_for(tmp_path):
    clock = SimClock()
    file = tmp_path / "late.wav"
    clock.every(5.0, lambda: soundfile.write(file, np.zeros((1600, 2)), 16000))
    wait(Config.model_validate({"audio": {"source": f"file:{file}"}}), clock)
    assert 5.0 <= clock.now() <= 7.0


def test_a_source_is_waited_for_however_late_it_comes_and_why_is_said_once(tmp_path, capsys):
    clock = SimClock()
    file = tmp_path / "late.wav"
    clock.every(90.0, lambda: soundfile.write(file, np.zeros((1600, 2)), 16000))
    wait(Config.model_validate({"audio": {"source": f"file:{file}"}}), clock)
    assert 90.0 <= clock.now() <= 92.0
    assert capsys.readouterr().err.count("waiting for the microphones: ") == 1


def test_a_wrong_configuration_is_not_waited_for():
    clock = SimClock()
    with pytest.raises(ConfigError, match="nowhere"):
        wait(Config.model_validate({"audio": {"source": "nowhere:x"}}), clock)
    assert clock.now() == 0.0
