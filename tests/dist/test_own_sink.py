"""'Add your own sink', followed to the letter: built, installed, checked and listened with."""

import pytest

from manual import command
from own_plugin import install, made, run_line
from short_mission import ALONE

PAGE = "docs/how-to/add-your-own-sink.md"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The files of the page, and the package installed beside them."""
    folder = tmp_path_factory.mktemp("own")
    assert made(PAGE, folder) == {"pyproject.toml", "my_sink.py", "loud.toml"}
    install(folder)
    (folder / "my_sink.py").unlink()  # only what is installed counts
    return folder


def test_its_configuration_is_good(folder):
    done = run_line(folder, command(PAGE, "ross config check"))
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.soak
def test_it_takes_a_voice(folder):
    streams = (folder / "loud.toml").read_text().replace("[[listening", "[[payload.listening")
    (folder / "loud-scenario.toml").write_text(ALONE + streams)
    flown = run_line(folder, "ross sitl --scenario loud-scenario.toml")
    assert flown.returncode in {0, 3}, flown.stderr
    lines = (folder / "loudness.txt").read_text().splitlines()
    assert len(lines) > 5
    levels = [float(line.split()[2]) for line in lines]
    assert levels[0] < levels[3] - 10  # the lead-in is quiet


def test_a_mistake_in_its_options_is_one_line(folder):
    (folder / "wrong.toml").write_text((folder / "loud.toml").read_text().replace("path =", "paht = 1, path ="))
    done = run_line(folder, "ross config check wrong.toml")
    assert (done.returncode, done.stdout) == (2, "")
    expected = "ross: wrong.toml: listening.streams.0.options of 'loudness': unknown key 'paht'; did you mean 'path'?"
    assert done.stderr.startswith(expected)
