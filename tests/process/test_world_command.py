"""`ross world` as its user starts it: addresses, truth, mistakes."""

import json
import re
import signal
import subprocess

import pytest

from processes import ROSS

LATE = re.compile(r"ross: the world is [\d.]+ s late: this computer does not keep up\n")  # which a busy one is told


def test_a_world_that_nobody_listens_to_ends_cleanly_with_a_truth_of_nothing(tmp_path):
    out, voice = tmp_path / "out", tmp_path / "voice.wav"
    command = [*ROSS, "world", "one-talker", "--json"]
    command += ["--out", out, "--enrolment", voice]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as world:
        told = json.loads(world.stdout.readline())
        world.send_signal(signal.SIGINT)
        _, err = world.communicate(timeout=60)
    assert (world.returncode, LATE.sub("", err)) == (0, "")
    assert told["wire"].startswith("pulses:tcp:127.0.0.1:")
    truth = json.loads((out / "truth.json").read_text())
    assert (truth["samples"], truth["began_s"], len(truth["talkers"])) == (0, None, 1)
    assert voice.stat().st_size > 100_000


BAD = {
    "expected tcp:HOST:PORT": ["--pcm", "udp:127.0.0.1:1"],
    "--wire: expected pulses": ["--wire", "ideal:tcp:127.0.0.1:0"],
    "not a named pipe": ["--pipe", __file__],
    "unknown": ["party"],
    "expected a scenario without one": ["drone-yaw"],
    "cannot listen": ["--pcm", "tcp:192.0.2.1:0"],
}


@pytest.mark.parametrize("words", BAD)
def test_what_a_world_cannot_do_is_one_line_and_exit_code_2(run, words):
    code, out, err = run("world", *BAD[words])
    assert (code, out) == (2, "")
    assert words in err
    assert err.count("\n") == 1


def test_speech_to_enrol_from_takes_the_place_of_no_other_file(tmp_path):
    voice = tmp_path / "voice.wav"

    def world():
        command = [*ROSS, "world", "one-talker", "--json", "--enrolment", voice]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
            process.stdout.readline()
            process.send_signal(signal.SIGINT)
            _, err = process.communicate(timeout=60)
        return process.returncode, LATE.sub("", err)

    voice.write_bytes(b"mine")
    refusal = f"ross: --enrolment: {voice} is there already: delete it, or give another name\n"
    assert world() == (2, refusal)
    assert voice.read_bytes() == b"mine"
    voice.unlink()
    assert world() == (0, "")
    assert world() == (0, "")  # the same speech
    assert list(tmp_path.iterdir()) == [voice]
