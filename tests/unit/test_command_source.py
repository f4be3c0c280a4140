"""The example of an audio source that is a program: what the program has started ends with it."""

import runpy
import time
from pathlib import Path

import pytest

EXAMPLE = Path(__file__).parents[2] / "docs/examples/plugins/command_source/command_source.py"
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
