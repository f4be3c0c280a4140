"""MAVProxy in a process of its own, without a terminal: what is typed, and what it prints."""

import importlib.util
import re
import subprocess
import sys
from contextlib import contextmanager

import pytest

from waiting import wait_for


def need_mavproxy():
    if importlib.util.find_spec("MAVProxy") is None:
        pytest.skip("needs the Python package MAVProxy")


class Prompt:
    """MAVProxy's command line, on pipes."""

    def __init__(self, process, log):
        self.process, self._log = process, log

    def type(self, line):
        """Type a line; return the place in what is printed, for `read`."""
        place = len(self.said())
        self.process.stdin.write(f"{line}\n")
        self.process.stdin.flush()
        return place

    def said(self):
        return self._log.read_text(errors="replace")

    def read(self, pattern, since=0):
        """Wait until it has printed what fits the pattern."""
        return wait_for(lambda: re.search(pattern, self.said()[since:]), 60, lambda: f"'{pattern}' in\n{self.said()}")

    def asks(self, line, pattern):
        """Type a line again and again until the answer fits: a payload may not be heard yet."""
        return wait_for(lambda: re.search(pattern, self._answer(line)), 60, lambda: f"'{pattern}' in\n{self.said()}")

    def _answer(self, line):
        place = self.type(line)
        self.read(r"\S", place)
        return self.said()[place:]


@contextmanager
def mavproxy(arguments, folder):
    """Run Python with these arguments, which become MAVProxy; it keeps its files in a folder."""
    need_mavproxy()
    log = folder / "mavproxy.log"
    command = [sys.executable, "-W", "ignore", "-u", *arguments, "--no-state"]
    pipes = {"stdin": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    with log.open("w") as out, subprocess.Popen(command, cwd=folder, stdout=out, **pipes) as process:
        try:
            yield Prompt(process, log)
        finally:
            process.kill()
