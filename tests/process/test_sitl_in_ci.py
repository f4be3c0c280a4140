"""Files for other people's CI: a script that flies a program beside a simulated payload, and an action around it."""

import os
import re
import runpy
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from command_syntax import complaint
from ports import free_port
from processes import ROSS, program
from ross_sim.scenario import load
from short_mission import CHEAP, LATER, SOON, brief
from waiting import wait_for

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
REFUSING = """
import sys, time
from pathlib import Path

while not (Path("told").exists() and Path("told").read_text()):
    time.sleep(0.05)
print(*sys.argv[1:])
sys.exit(7)
"""


@pytest.fixture
def environment(tmp_path):
    command = tmp_path / "ross"
    command.write_text(f'#!/bin/sh\nexec {" ".join(map(str, ROSS))} "$@"\n')
    command.chmod(0o755)
    return os.environ | {"ROSS": str(command), "PYTHON": sys.executable, "SPEED": "4", "OUT": "flight"}


def fly(folder, environment, *arguments, given=None):
    command = ["sh", CI / "fly.sh", *arguments]
    return subprocess.run(
        command, cwd=folder, env=environment, input=given, capture_output=True, text=True, timeout=250, check=False
    )


SAYS = re.compile(r"talkers at \S+\nlargest error [0-2]\.\d\d deg\ntarget recognised\n")


@pytest.fixture
def asked(tmp_path):
    return brief("one-talker", tmp_path, explore=SOON, check_s=1.0, run_s=2.0, **CHEAP)


@pytest.mark.soak
def test_the_example_finds_everybody_and_the_target(tmp_path, asked):
    """The program of the example beside a payload, both without the shell between them."""
    port = free_port()
    options = ["--serve", "--scenario", asked, "--speed", "4", "--telemetry", f"udpout:127.0.0.1:{port}"]
    with program([*ROSS, "sitl", *options], tmp_path, end=signal.SIGINT):
        example = [sys.executable, "-c", (CI / "flight.py").read_text(), f"udpin:127.0.0.1:{port}", asked, "3"]
        flown = subprocess.run(example, capture_output=True, text=True, timeout=250, check=False)
    assert flown.returncode == 0, flown.stdout + flown.stderr
    assert SAYS.search(flown.stdout)


@pytest.mark.soak
def test_the_script_flies_the_example(tmp_path, environment, asked):
    flown = fly(tmp_path, environment, asked, CI / "flight.py", "3")
    assert flown.returncode == 0, flown.stdout + flown.stderr
    assert SAYS.search(flown.stdout)
    assert (tmp_path / "flight" / "payload.log").exists()


@pytest.mark.soak
def test_the_example_fails_when_somebody_else_is_taken_for_the_target(tmp_path, environment):
    """The payload accepts the first voice that it listens to."""
    scenario = brief("demo", tmp_path, explore=LATER, criterion=-100.0, check_s=1.0, run_s=2.0, **CHEAP)
    scenario.write_text(scenario.read_text().replace("target = 0", "target = 1"))
    flown = fly(tmp_path, environment, scenario, CI / "flight.py")
    assert flown.returncode == 1
    assert re.fullmatch(r"expected the target at 205\.0 deg, got (80|320)\.\d\n", flown.stderr), flown.stderr


@pytest.mark.parametrize(
    ("scenario", "azimuth"), [("demo", -40.0), ("drone-yaw", -10.0), ("silence", None), ("no-target", None)]
)
def test_the_example_knows_where_the_target_is(scenario, azimuth):
    wanted = runpy.run_path(str(CI / "flight.py"))["azimuth_of_target"](load(scenario))
    assert wanted == (None if azimuth is None else pytest.approx(azimuth))


def test_a_mistake_in_the_arguments_of_the_example_is_no_traceback():
    def flown(*arguments):
        command = [sys.executable, CI / "flight.py", "udpin:127.0.0.1:0", *arguments]
        return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)

    unknown, wrong = flown("no-such-room"), flown("demo", "five")
    assert unknown.returncode == 1
    assert unknown.stderr.startswith("scenario 'no-such-room' is unknown")
    assert unknown.stderr.count("\n") == 1
    assert wrong.returncode == 2
    assert wrong.stderr.endswith("argument degrees: invalid float value: 'five'\n")


@pytest.mark.parametrize(
    ("name", "clockwise"),
    [("demo", [-40, -155, 80]), ("drone-yaw", [-10, -125, 110]), ("vehicle-yaw", [-40, -155, 80])],
)
def test_the_example_expects_azimuths_in_the_frame_of_the_payload(name, clockwise):
    """The nose of drone-yaw points 30 degrees clockwise of north: azimuths of talkers count from there."""
    assert runpy.run_path(str(CI / "flight.py"))["azimuths"](load(name)) == pytest.approx(clockwise)


@pytest.fixture
def noted(tmp_path, environment):
    """What the payload that the script starts is told, in the place of flying."""
    (tmp_path / "ross").write_text('#!/bin/sh\necho "$@" > told\necho says this\nexit 2\n')
    return lambda: (tmp_path / "told").read_text().split()


def test_the_exit_code_is_the_program_s_and_the_payload_is_told_what_it_understands(tmp_path, environment, noted):
    (tmp_path / "program.py").write_text(REFUSING)
    flown = fly(tmp_path, environment | {"SEED": "5"}, "one-talker", tmp_path / "program.py", "one", "two")
    assert flown.returncode == 7
    assert re.fullmatch(r"udpin:127\.0\.0\.1:\d+ one-talker one two\n", flown.stdout)
    assert complaint(noted()) == ""
    port = flown.stdout.split()[0].rpartition(":")[2]
    assert noted()[:4] == ["sitl", "--serve", "--scenario", "one-talker"]
    assert {"4", "5", f"udpout:127.0.0.1:{port}", "flight"} <= set(noted())


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


def test_what_a_payload_says_that_ends_by_itself_is_told(tmp_path, environment, noted):
    program = tmp_path / "program.py"
    program.write_text(WAITING)
    flown = fly(tmp_path, environment, "nowhere", program)
    assert flown.returncode == 1
    assert flown.stderr.splitlines() == ["the payload ended by itself, with exit code 2; its log says:", "says this"]


def test_a_program_reads_the_standard_input_of_the_script(tmp_path, environment):
    (tmp_path / "ross").write_text("#!/bin/sh\nexec sleep 60\n")
    (tmp_path / "program.py").write_text("print(input())")
    flown = fly(tmp_path, environment, "demo", tmp_path / "program.py", given="these words\n")
    assert (flown.returncode, flown.stdout, flown.stderr) == (0, "these words\n", "")


def test_a_payload_that_somebody_else_has_killed_was_not_too_slow(tmp_path, environment, noted):
    """As a computer that runs out of memory does."""
    (tmp_path / "ross").write_text("#!/bin/sh\necho says this\nkill -KILL $$\n")
    program = tmp_path / "program.py"
    program.write_text(WAITING)
    flown = fly(tmp_path, environment, "demo", program)
    assert flown.returncode == 1
    assert flown.stderr.splitlines() == ["the payload ended by itself, with exit code 137; its log says:", "says this"]


def test_a_payload_that_the_script_ends_while_it_starts_has_not_ended_by_itself(tmp_path, environment):
    """A program that fails at once: the payload has no handler for SIGTERM yet."""
    (tmp_path / "ross").write_text("#!/bin/sh\nexec sleep 60\n")
    program = tmp_path / "program.py"
    program.write_text("import sys\nsys.exit('no such room')\n")
    flown = fly(tmp_path, environment, "demo", program)
    assert (flown.returncode, flown.stderr) == (1, "no such room\n")


def test_a_payload_that_does_not_end_is_killed(tmp_path, environment):
    """As one whose plug-in computes for ever."""
    (tmp_path / "ross").write_text("#!/bin/sh\ntrap '' TERM\ntouch started\nwhile true; do sleep 0.1; done\n")
    program = tmp_path / "program.py"
    program.write_text("import time\nfrom pathlib import Path\nwhile not Path('started').exists(): time.sleep(0.05)\n")
    flown = fly(tmp_path, environment | {"GRACE": "1"}, "demo", program)
    assert (flown.returncode, flown.stderr) == (1, "the payload did not end within 1 s and was killed\n")


def test_a_script_that_is_told_to_end_waits_no_longer_for_its_payload(tmp_path, environment):
    (tmp_path / "ross").write_text("#!/bin/sh\ntrap '' TERM\ntouch started\nwhile true; do sleep 0.1; done\n")
    (tmp_path / "ross").chmod(0o755)
    program = tmp_path / "program.py"
    program.write_text(
        "import os, signal, time\ntime.sleep(1)\nos.kill(os.getppid(), signal.SIGTERM)\ntime.sleep(0.5)\n"
    )
    flown = fly(tmp_path, environment | {"GRACE": "1"}, "demo", program)
    assert (flown.returncode, flown.stderr) == (130, "")


IDLE = """
import os, time
from pathlib import Path
while not Path("started").exists(): time.sleep(0.05)
Path("flying").write_text(str(os.getpid()))
time.sleep(60)
"""


@pytest.fixture
def idle(tmp_path, environment):
    """The script with a payload and a program that end by themselves after a minute: its process and their ids."""
    (tmp_path / "ross").write_text("#!/bin/sh\necho $$ > started\nexec sleep 60\n")
    (tmp_path / "program.py").write_text(IDLE)
    command = ["sh", CI / "fly.sh", "demo", tmp_path / "program.py"]
    with subprocess.Popen(command, cwd=tmp_path, env=environment) as script:
        wait_for(lambda: (tmp_path / "flying").exists() and (tmp_path / "flying").read_text(), 20.0)
        yield script, [int((tmp_path / name).read_text()) for name in ("started", "flying")]
        script.kill()


def ended(pids):
    """Whether all of them have ended, and are no zombies that were forgotten."""
    stats = [Path(f"/proc/{pid}/stat") for pid in pids]
    return not any(stat.exists() and stat.read_text().rpartition(")")[2].split()[0] != "Z" for stat in stats)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGHUP])
def test_a_script_that_is_told_to_end_ends_its_program_and_its_payload(idle, number):
    """A CI that cancels a job tells the shell alone."""
    script, others = idle
    script.send_signal(number)
    assert script.wait(10) == 130
    assert ended(others)


@pytest.mark.skipif(
    subprocess.run(["setpriv", "--pdeathsig", "TERM", "true"], capture_output=True, check=False).returncode != 0,
    reason="needs setpriv of util-linux 2.33",
)
def test_nobody_outlives_a_script_that_is_killed(idle):
    script, others = idle
    script.kill()
    wait_for(lambda: ended(others), 10.0)


def test_the_action_hands_every_input_on():
    text = (CI / "action.yml").read_text()
    inputs = re.findall(r"^  (\w+):$", text.partition("runs:")[0], re.M)
    assert inputs
    assert all(f"inputs.{name} " in text for name in inputs)
    assert "${{" not in "".join(re.findall(r"run: \|\n((?: {8}.*\n)+)", text))  # inputs are no shell text
