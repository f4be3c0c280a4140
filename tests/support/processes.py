"""Programs that live beside a test: one way to start them, to read what they say, and to have them go in good order."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

PYTHON = (sys.executable,)
ROSS = (sys.executable, "-m", "ross_payload.cli")
LIMIT_S = 60.0  # to end in


@contextmanager
def program(
    command: Sequence[object],
    folder: Path,
    log: str = "log",
    *,
    end: signal.Signals = signal.SIGTERM,
    code: int | None = 0,
    lives: bool = True,
    **pipes: Any,
) -> Iterator[tuple[subprocess.Popen[str], Path]]:
    """Run a program in a folder until it is told to go; yield the process and its log.

    Standard error goes to the log, and standard output as well unless ``pipes`` say otherwise. The program must still
    live at the end (unless not ``lives``), end with this code (None: any), and log no traceback.
    """
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / log
    with path.open("w") as file:
        streams: dict[str, Any] = {"stdout": file, "stderr": file, "text": True} | pipes
        with subprocess.Popen([str(word) for word in command], cwd=folder, **streams) as process:
            try:
                yield process, path
                assert not lives or process.poll() is None, path.read_text()
            finally:
                if process.poll() is None:
                    process.send_signal(end)
                try:
                    process.wait(LIMIT_S)
                except subprocess.TimeoutExpired:
                    process.kill()
                    raise
    said = path.read_text()
    assert code is None or process.returncode == code, said
    assert "Traceback" not in said, said
