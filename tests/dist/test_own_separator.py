"""'Add your own separator', followed to the letter: built, installed, scored and flown."""

import json
import re

import numpy as np
import pytest
import soundfile

from manual import command
from own_plugin import install, made, run_line
from short_mission import ALONE

PAGE = "docs/how-to/add-your-own-separator.md"
RATE, SPACING, SPEED = 16000, 0.05, 343.0


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The files of the page, and the package installed beside them."""
    folder = tmp_path_factory.mktemp("own")
    assert made(PAGE, folder) == {"pyproject.toml", "my_separator.py"}
    install(folder)
    (folder / "my_separator.py").unlink()  # only what is installed counts
    return folder


def test_it_is_scored_on_two_takes(folder):
    line = command(PAGE, "ross evaluate")
    azimuths = np.deg2rad([float(text) for text in re.findall(r"--azimuth (\S+)", line)])
    rng = np.random.default_rng(0)
    voices = rng.normal(scale=0.05, size=(2, 3 * RATE))
    delays = SPACING * np.cos(azimuths) / SPEED  # > 0: microphone 2 leads
    images = np.stack([[voice, advanced(voice, delay)] for voice, delay in zip(voices, delays, strict=True)])
    soundfile.write(folder / "a.wav", images.sum(axis=0).T, RATE)
    soundfile.write(folder / "b.wav", images[0].T, RATE)
    done = run_line(folder, line + " --json")
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert told["separator"] == "delay-and-sum"
    assert max(group["si_sdri_db"] for group in told["groups"]) > 0.5  # the beam is better than one microphone


def advanced(voice, seconds):
    """The voice as a microphone hears it that is nearer by so much time."""
    spectrum = np.fft.rfft(voice)
    return np.fft.irfft(spectrum * np.exp(2j * np.pi * np.fft.rfftfreq(voice.size, 1 / RATE) * seconds), voice.size)


@pytest.mark.soak
def test_a_mission_is_flown_with_it(folder):
    (folder / "short.toml").write_text(ALONE)
    flown = run_line(folder, command(PAGE, "ross sitl") + " --scenario short.toml --json")
    assert flown.returncode in {0, 3}, flown.stderr
    told = json.loads(flown.stdout)
    assert {check["separator"] for check in told["checks"]} == {"delay-and-sum"}
    assert told["outcome"] != "fault"


def test_a_mistake_in_it_is_one_line_with_its_name(folder, tmp_path):
    site = tmp_path / "site"
    site.mkdir()
    for path in (folder / "site").rglob("*"):
        target = site / path.relative_to(folder / "site")
        target.mkdir(exist_ok=True) if path.is_dir() else target.write_bytes(path.read_bytes())
    module = site / "my_separator.py"
    module.write_text(module.read_text().replace("separator = DelayAndSum()", "separator = DelayAndSum"))
    (tmp_path / "ross.toml").write_text('exploit.separator = "delay-and-sum"')
    done = run_line(tmp_path, "ross config check ross.toml")
    assert (done.returncode, done.stdout) == (2, "")
    said = "ross: ross.toml: separator 'delay-and-sum': expected an object, got the class DelayAndSum"
    assert done.stderr == f"{said}: write DelayAndSum()\n"
