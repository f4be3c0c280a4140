"""Files for other people's CI: a script that flies a program beside a simulated payload, and an action around it."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from processes import ROSS
from short_mission import CHEAP, SOON, brief

ROOT = Path(__file__).parents[2]
CI = ROOT / "docs" / "examples" / "ci"
WAITING = """
import os
import time
from pathlib import Path

def lives(pid):
    stat = Path(f"/proc/{pid}/stat")
    return stat.exists() and stat.read_text().rpartition(")")[2].split()[0] != "Z"

shell = os.getppid()
while True:
    others = Path(f"/proc/{shell}/task/{shell}/children").read_text().split()
    if not any(lives(pid) for pid in others if int(pid) != os.getpid()):
        break
    time.sleep(0.05)
"""
REFUSING = "import sys\nprint(*sys.argv[1:])\nsys.exit(7)\n"


@pytest.fixture
def environment(tmp_path):
    command = tmp_path / "ross"
    command.write_text(f'#!/bin/sh\nexec {" ".join(map(str, ROSS))} "$@"\n')
    command.chmod(0o755)
    return os.environ | {"ROSS": str(command), "PYTHON": sys.executable, "SPEED": "4", "OUT": "flight"}


def fly(folder, environment, *arguments):
    command = ["sh", CI / "fly.sh", *arguments]
    return subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, timeout=250, check=False
    )


def test_the_example_finds_everybody_and_the_target(tmp_path, environment):
    asked = brief("one-talker", tmp_path, explore=SOON, check_s=1.0, run_s=2.0, **CHEAP)
    flown = fly(tmp_path, environment, asked, CI / "flight.py", "3")
    assert flown.returncode == 0, flown.stdout + flown.stderr
    assert re.search(r"talkers at \S+\nlargest error [0-2]\.\d\d deg\ntarget recognised\n", flown.stdout)
    assert (tmp_path / "flight" / "payload.log").exists()


def test_the_exit_code_is_the_program_s(tmp_path, environment):
    program = tmp_path / "program.py"
    program.write_text(REFUSING)
    flown = fly(tmp_path, environment, "one-talker", program, "one", "two")
    assert flown.returncode == 7
    assert re.fullmatch(r"udpin:127\.0\.0\.1:\d+ one-talker one two\n", flown.stdout)


@pytest.mark.parametrize(
    ("arguments", "changed", "words"),
    [
        (["demo"], {}, "expected SCENARIO PROGRAM, got: demo"),
        (["demo", "nowhere.py"], {}, "expected a program, got 'nowhere.py', which is no file"),
        (["demo", "nowhere.py"], {"ROSS": "no-such-ross"}, "expected RoSS as 'no-such-ross', found nothing"),
    ],
)
def test_a_mistake_is_one_line(tmp_path, environment, arguments, changed, words):
    flown = fly(tmp_path, environment | changed, *arguments)
    assert (flown.returncode, flown.stdout) == (2, "")
    assert flown.stderr.startswith(words)
    assert flown.stderr.count("\n") == 1


def test_a_scenario_that_is_not_there_is_told_in_the_payload_s_words(tmp_path, environment):
    program = tmp_path / "program.py"
    program.write_text(WAITING)
    flown = fly(tmp_path, environment, "nowhere", program)
    assert flown.returncode == 1
    assert "the payload ended by itself, with exit code 2" in flown.stderr
    assert "nowhere" in flown.stderr


def test_the_action_hands_every_input_on():
    text = (CI / "action.yml").read_text()
    inputs = re.findall(r"^  (\w+):$", text.partition("runs:")[0], re.M)
    assert inputs
    assert all(f"inputs.{name} " in text for name in inputs)
    assert "${{" not in "".join(re.findall(r"run: \|\n((?: {8}.*\n)+)", text))  # inputs are no shell text
