"""What a payload finds wrong: one line and exit code 2 at its start; while it lives it says so and turns nothing."""

import json
import os
import pty
import shutil
import subprocess
import time
import tty
from contextlib import contextmanager

import numpy as np
import pytest
import soundfile
from pymavlink import mavutil

from processes import ROSS
from ross_protocols.mavlink.codec import Encoder
from ross_protocols.mavlink.values import DIALECT_VERSION, Information

RATE = 16000


@pytest.fixture(scope="module")
def noise(tmp_path_factory):
    path = tmp_path_factory.mktemp("noise") / "noise.wav"
    samples = np.random.default_rng(0).normal(0, 0.01, (RATE * 120, 2))
    soundfile.write(path, samples, RATE, subtype="PCM_24")
    return path


@pytest.fixture
def payload(tmp_path, noise):
    """Write a payload's file: keys of [audio], and tables behind it."""

    def write(audio="", tables="", folder=tmp_path):
        folder.mkdir(exist_ok=True)
        source = "" if "source" in audio else f'source = "file:{noise}"'
        text = f'[audio]\n{source}\n{audio}\n[actuator]\nkind = "tb6600"\n[service]\nstate_dir = "state"\n'
        (folder / "ross.toml").write_text(f'{text}log_format = "json"\n{tables}')
        return folder

    return write


def ended(folder):
    """A ``ross run`` that ends by itself."""
    command = [*ROSS, "run", "ross.toml"]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120, check=False)


class Living:
    """A ``ross run`` and what it has logged."""

    def __init__(self, process, log):
        self.process, self._log = process, log

    def lines(self):
        said = self._log.read_text().splitlines()
        return [json.loads(line)["message"] for line in said if line.startswith("{")]

    def says(self, words, seconds=60):
        """Wait for a line of the log with these words."""
        end = time.monotonic() + seconds
        while not (found := [line for line in self.lines() if words in line]):
            assert time.monotonic() < end, self._log.read_text()
            time.sleep(0.05)
        return found[0]


@contextmanager
def running(folder):
    """Live until it is told to go; it must have turned nothing, and go in good order."""
    log = folder / "log"
    with log.open("w") as file, subprocess.Popen([*ROSS, "run", "ross.toml"], cwd=folder, stderr=file) as process:
        living = Living(process, log)
        try:
            living.says("idle")
            yield living
            assert process.poll() is None, log.read_text()
        finally:
            process.terminate()
            process.wait(60)
    assert process.returncode == 0, log.read_text()
    assert "turning" not in log.read_text()


@pytest.fixture
def ground():
    link = mavutil.mavudp("127.0.0.1:0", input=True, source_system=255)
    link.url = f"udpout:127.0.0.1:{link.port.getsockname()[1]}"
    yield link
    link.close()


def texts_until(ground, words):
    """Listen until a text has these words; long texts come in parts."""
    heard, end = "", time.monotonic() + 30
    while words not in heard:
        assert time.monotonic() < end, heard
        message = ground.recv_match(type="STATUSTEXT", blocking=True, timeout=1)
        heard += "" if message is None else message.text


# --------------------------------------------------------------------------------------------- at the start

MISTAKES = {
    "a missing rate": ("rate_hz = 44100", "", ["16000 Hz", "44100"]),
    "a missing channel": ("channels = [0, 5]", "", ["at least 6 channels", "got 2"]),
    "a server that is not there": ('source = "tcp:127.0.0.1:9"', "", ["127.0.0.1:9", "refused"]),
    "nobody to be sought at start": ("", 'autostart = "seek"', ["autostart", "target"]),
    "a mount that there is not": ("", '[guard]\n[mount]\nsource = "north"', ["north", "fixed"]),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_one_line_that_says_what_was_found(payload, mistake):
    audio, tables, words = MISTAKES[mistake]
    folder = payload(audio, tables)
    done = ended(folder)
    assert done.returncode == 2, done.stderr
    *before, last = done.stderr.splitlines()
    assert last.startswith("ross: ")
    assert all(json.loads(line)["level"] == "info" for line in before)  # that it waits for a server
    assert all(word in last for word in words), done.stderr
    assert not (folder / "state" / "params.toml").exists()


def test_a_key_that_others_can_read_starts_nothing(payload):
    folder = payload(tables='[[links]]\nurl = "udpout:127.0.0.1:9"\nkey_file = "key"\n')
    (folder / "key").write_bytes(bytes(32))
    (folder / "key").chmod(0o644)
    done = ended(folder)
    assert done.returncode == 2
    assert done.stderr.startswith("ross: ")
    assert done.stderr.endswith("links.0: key_file key: expected mode 0600, got 0644: chmod 600 key\n")


# --------------------------------------------------------------------------------------------- while it lives

HALF = "version = 1\n\n[parameters]\nEXP_UNIT = { value = 2."
NEWER = "version = 7\n\n[parameters]\n"


@pytest.mark.parametrize(("content", "word"), [(HALF, "unreadable"), (NEWER, "newer")])
def test_a_file_of_parameters_that_is_half_or_newer_is_kept_aside_and_told(payload, ground, content, word):
    folder = payload(tables=f'[[links]]\nurl = "{ground.url}"\n')
    (folder / "state").mkdir()
    (folder / "state" / "params.toml").write_text(content)
    with running(folder) as living:
        assert f"kept as params.toml.{word}" in living.says("params.toml")
        texts_until(ground, f"params.toml.{word}")
    assert (folder / "state" / f"params.toml.{word}").read_text() == content


def test_a_value_out_of_range_or_not_a_number_changes_nothing(payload, ground):
    folder = payload(tables=f'[[links]]\nurl = "{ground.url}"\n')
    with running(folder):
        ground.recv_match(type="HEARTBEAT", blocking=True, timeout=30)
        for value in (1e9, float("nan"), float("inf"), -1.0):
            ground.mav.param_set_send(1, 191, b"EXP_UNIT", value, 9)
        texts_until(ground, "expected a number from 0.5 to 60 s, got -1")
    assert not (folder / "state" / "params.toml").exists()


def test_another_version_of_the_dialect_at_the_other_end_is_named(payload, ground):
    folder = payload(tables=f'[[links]]\nurl = "{ground.url}"\n')
    stranger = Encoder(system_id=9, component_id=191)
    told = Information(
        0, 0.05, 343.0, 0.0, None, None, None, 3.0, RATE, 8, "9", "x", dialect_version=DIALECT_VERSION + 1
    )
    with running(folder):
        ground.recv_match(type="HEARTBEAT", blocking=True, timeout=30)
        ground.write(stranger.encode(told))
        texts_until(ground, f"payload 9/191: dialect {DIALECT_VERSION + 1}, expected {DIALECT_VERSION}")


@pytest.mark.soak  # behind a switch: test_neighbours
def test_two_payloads_with_one_component_id_say_so_and_both_go_on(payload, ground, tmp_path):
    port = ground.port.getsockname()[1]
    ground.close()
    first = payload(tables=f'[[links]]\nurl = "udpin:127.0.0.1:{port}"\n', folder=tmp_path / "first")
    second = payload(tables=f'[[links]]\nurl = "udpout:127.0.0.1:{port}"\n', folder=tmp_path / "second")
    with running(first) as one, running(second) as other:
        for living in (one, other):
            living.says("another sender uses our system and component id")


def test_a_serial_line_that_is_pulled_out_and_put_back_is_used_again(payload):
    pytest.importorskip("serial")
    folder = payload(tables='[[links]]\nurl = "serial:tty:57600"\n')
    ends = plugged(folder / "tty")
    try:
        with running(folder) as living:
            living.says("link serial:tty:57600 is up")
            while ends:
                os.close(ends.pop())
            (folder / "tty").unlink()
            living.says("link serial:tty:57600 is down")
            ends = plugged(folder / "tty")
            end = time.monotonic() + 30
            while not os.read(ends[0], 300):
                assert time.monotonic() < end
    finally:
        for number in ends:
            os.close(number)


def plugged(path):
    """Make a serial line of this name; return its far end and its near end."""
    far, near = pty.openpty()
    tty.setraw(near)
    path.symlink_to(os.ttyname(near))
    return [far, near]


# --------------------------------------------------------------------------------------------- a session folder


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    """A short recording of a payload that idles."""
    folder = tmp_path_factory.mktemp("taped")
    samples = np.random.default_rng(0).normal(0, 0.01, (RATE * 3, 2))
    soundfile.write(folder / "noise.wav", samples, RATE, subtype="PCM_24")
    (folder / "ross.toml").write_text(
        '[audio]\nsource = "file:noise.wav"\n[actuator]\nkind = "tb6600"\n[service]\nstate_dir = "state"\n'
        "[recording]\nalways = true\nmin_free_gb = 0.0\n"
    )
    done = ended(folder)
    assert done.returncode == 0, done.stderr
    (recorded,) = (folder / "state" / "recordings").iterdir()
    return recorded


def half(path):
    os.truncate(path, path.stat().st_size // 2)


def other_version(path):
    path.write_text(json.dumps(json.loads(path.read_text()) | {"version": 9}))


DAMAGES = {
    "are not read": ("inputs.jsonl", half),
    "shorter than the Inputs": ("audio.wav", half),
    "expected version 1, got 9": ("session.json", other_version),
}


@pytest.mark.parametrize("words", DAMAGES)
def test_a_session_that_is_cut_or_of_another_version_is_replayed_as_far_as_it_goes(run, session, tmp_path, words):
    copied = tmp_path / "0001"
    shutil.copytree(session, copied)
    name, damage = DAMAGES[words]
    damage(copied / name)
    code, said, error = run("replay", copied)
    assert (code, error) == (0, "")
    assert words in said


def test_a_session_without_its_head_is_refused_in_one_line(run, session, tmp_path):
    copied = tmp_path / "0001"
    shutil.copytree(session, copied)
    half(copied / "session.json")
    code, _, error = run("replay", copied)
    assert code == 2
    assert "session.json" in error
    assert error.count("\n") == 1
