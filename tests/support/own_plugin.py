"""A plug-in of a page 'Add your own ...': its files as they stand there, installed into a folder, and run there."""

import os
import shlex
import subprocess
import sys

from manual import blocks


def made(page, folder):
    """Write the files of a page; return their names."""
    found = [block for block in (*blocks("toml"), *blocks("python")) if block.page == page]
    for block in found:
        (folder / block.text.split()[1]).write_text(block.text)
    return {path.name for path in folder.iterdir()}


def install(folder):
    """Install the package in a folder into the folder ``site`` beside it."""
    options = ["--quiet", "--no-deps", "--no-index", "--no-build-isolation", "--target", folder / "site"]
    subprocess.run([sys.executable, "-m", "pip", "install", *options, folder], check=True, capture_output=True)


def run(folder, *command, cwd=None, timeout=250):
    """Run a Python module beside what is installed in a folder."""
    environment = os.environ | {"PYTHONPATH": str(folder / "site"), "OMP_NUM_THREADS": "1"}
    return subprocess.run(
        [sys.executable, "-m", *map(str, command)],
        cwd=cwd or folder, env=environment, capture_output=True, text=True, timeout=timeout, check=False,
    )  # fmt: skip


def run_line(folder, line):
    """Run a line of the page that begins with ``ross``."""
    return run(folder, "ross_payload.cli", *shlex.split(line)[1:])
