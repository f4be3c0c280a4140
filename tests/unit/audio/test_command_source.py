"""The example of an audio source that is a program: what the program has started ends with it."""

import runpy
import time
from contextlib import suppress
from pathlib import Path

import pytest

EXAMPLE = Path(__file__).parents[3] / "docs/examples/plugins/command_source/command_source.py"
Program = runpy.run_path(str(EXAMPLE))["Program"]


@pytest.mark.parametrize("script", ["cat /dev/zero | cat; true", "sleep 60; true", "trap '' TERM; sleep 60; true"])
def test_closing_ends_also_what_the_program_has_started(script):
    heard = []
    program = Program(["sh", "-c", f"head -c 400 /dev/zero; {script}"], 2, heard.append)
    while not heard:
        time.sleep(0.01)
    begun = time.monotonic()
    program.close()
    assert time.monotonic() - begun < 10.0
    assert not program.alive


@pytest.mark.parametrize(
    "script",
    [
        "(trap '' TERM; exec sleep 60 >/dev/null) & exec cat /dev/zero",
        "setsid cat /dev/zero & exec cat /dev/zero",
    ],
)
def test_closing_ends_what_ignores_it_and_hears_no_more(script, tmp_path):
    heard, pids = [], tmp_path / "pids"
    program = Program(["sh", "-c", script.replace("& ", f"& echo $! > {pids};")], 2, heard.append)
    while not heard or not pids.exists() or not pids.read_text().strip():
        time.sleep(0.01)
    time.sleep(0.2)
    program.close()
    count, child = len(heard), int(pids.read_text())
    time.sleep(0.2)
    assert (program.alive, len(heard)) == (False, count)
    assert not alive(child)


def alive(pid):
    """Whether a process runs; one that nobody has waited for does not."""
    with suppress(FileNotFoundError):
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    return False
