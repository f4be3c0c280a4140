"""'Add your own audio source', followed to the letter: installed, checked, heard with, and held to the contract."""

import re
import shlex
import shutil
import sys
from pathlib import Path

import pytest

from manual import command
from own_plugin import install, run, run_line
from ross_payload.clock import SystemClock
from ross_payload.config import Config, validated
from ross_payload.doctor.examination import measured

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "docs" / "examples" / "plugins" / "command_source"
PAGE = "docs/how-to/add-your-own-audio-source.md"
PROGRAM = """
import sys, time
import numpy as np
rate, channels = 16000, int(sys.argv[1])
generator, begin, sent = np.random.default_rng(3), time.monotonic(), 0
while True:
    due = int((time.monotonic() - begin) * rate)
    noise = generator.normal(0, 1000, (due - sent, channels)) * 2.0 ** np.arange(channels)
    sys.stdout.buffer.write(noise.astype("<i2").tobytes())
    sys.stdout.buffer.flush()
    sent = due
    time.sleep(0.01)
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The example, installed beside its files."""
    folder = tmp_path_factory.mktemp("own") / "command_source"
    shutil.copytree(EXAMPLE, folder)
    install(folder)
    (folder / "command_source.py").unlink()  # only what is installed counts
    (folder / "noise.py").write_text(PROGRAM)
    return folder


def source(folder, channels=2):
    return f"command:{shlex.join([sys.executable, str(folder / 'noise.py'), str(channels)])}"


def test_its_configuration_is_good(folder):
    done = run_line(folder, command(PAGE, "ross config check"))
    assert (done.returncode, done.stderr) == (0, "")


def test_the_configured_channels_are_heard(folder, monkeypatch):
    monkeypatch.syspath_prepend(folder / "site")
    config = validated(Config, {"audio": {"source": source(folder, channels=3), "channels": (2, 0)}}, "three")
    health, _ = measured(config, SystemClock())
    assert health.level_db == pytest.approx((-18.3, -30.3), abs=0.5)  # each channel has 6 dB more than the one before


@pytest.mark.parametrize(
    ("address", "said"),
    [
        ("no-such-program", "command 'no-such-program': cannot be started: No such file or directory"),
        ("'open", "command: expected a program and its arguments, got ''open': No closing quotation"),
        ("true", "the microphones were opened, but gave no audio within 5 s"),
    ],
)
def test_a_command_that_cannot_be_heard_is_one_line(folder, address, said):
    (folder / "wrong.toml").write_text(f'audio.source = "command:{address}"\n')
    done = run_line(folder, "ross devices --tap wrong.toml")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr
    assert said in done.stderr


def held_to_the_contract(folder, source, *options):
    contract = ["pytest", "-q", "-p", "no:cacheprovider", "tests/contract/test_audio_source.py"]
    return run(folder, *contract, "--audio-source", source, *options, cwd=ROOT)


@pytest.mark.soak
def test_it_keeps_the_contract(folder):
    held = held_to_the_contract(folder, source(folder), "-k", "command")
    assert held.returncode == 0, held.stdout
    assert int(re.search(r"(\d+) passed", held.stdout)[1]) > 10


def test_a_source_that_breaks_a_rule_does_not_keep_it(folder, tmp_path):
    shutil.copytree(folder / "site", tmp_path / "site")
    module = tmp_path / "site" / "command_source.py"
    module.write_text(
        module.read_text().replace(
            "    return services.live(", "    Program(command, 2, len)\n    return services.live("
        )
    )
    held = held_to_the_contract(tmp_path, source(folder), "-k", "making_one")
    assert held.returncode == 1, held.stdout
