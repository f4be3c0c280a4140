"""A plug-in of a page 'Add your own ...': its files as they stand there, installed into a folder, and run there."""

import hashlib
import os
import shlex
import shutil
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory

from manual import blocks


def made(page, folder):
    """Write the files of a page; return their names."""
    found = [block for block in (*blocks("toml"), *blocks("python")) if block.page == page]
    for block in found:
        (folder / block.text.split()[1]).write_text(block.text)
    return {path.name for path in folder.iterdir()}


BUILD = """
import importlib, tempfile, tomllib, zipfile
from pathlib import Path
import ross_payload  # imported already where this is forked

system = tomllib.loads(Path("pyproject.toml").read_text())["build-system"]
with tempfile.TemporaryDirectory() as wheels:
    name = importlib.import_module(system["build-backend"]).build_wheel(wheels)
    with zipfile.ZipFile(Path(wheels) / name) as wheel:
        wheel.extractall("site")
"""


def install(folder, *, pip=False):
    """Install the package in a folder into the folder ``site`` beside it; once for all tests of a run.

    By pip, which starts five interpreters, or by what pip does in the end: by the package's own build system.

    A run's worker (`forked_workers`) has a folder of its own beside those of the others.
    """
    own = folder.parent
    kept = (own.parent if own.name.startswith("worker") else own) / f"site-{_content(folder)}"
    if not kept.exists():
        options = ["--quiet", "--no-deps", "--no-index", "--no-build-isolation", "--target", folder / "site"]
        by_pip = [sys.executable, "-m", "pip", "install", *options, folder]
        command = by_pip if pip else [sys.executable, "-c", BUILD]
        subprocess.run(command, cwd=folder, check=True, capture_output=True)
        with suppress(OSError), TemporaryDirectory(dir=kept.parent) as half:
            shutil.copytree(folder / "site", Path(half) / "site")
            (Path(half) / "site").rename(kept)  # whole, or not at all; another worker may have been sooner
    else:
        shutil.copytree(kept, folder / "site")


def _content(folder):
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    parts = [part for path in files for part in (str(path.relative_to(folder)).encode(), path.read_bytes())]
    return hashlib.sha256(b"\0".join(parts)).hexdigest()[:16]


RUN_MODULE = "import ross_payload, runpy, sys; runpy.run_module(sys.argv.pop(1), run_name='__main__', alter_sys=True)"


def module(name, *arguments):
    """The command that runs a Python module of others in a fork of what has imported ours (`forked_programs`)."""
    return [sys.executable, "-c", RUN_MODULE, name, *map(str, arguments)]


def run(folder, name, *arguments, cwd=None, timeout=250):
    """Run a Python module beside what is installed in a folder."""
    environment = os.environ | {"PYTHONPATH": str(folder / "site"), "OMP_NUM_THREADS": "1"}
    ours = name.startswith("ross_payload.")
    return subprocess.run(
        [sys.executable, "-m", name, *map(str, arguments)] if ours else module(name, *arguments),
        cwd=cwd or folder, env=environment, capture_output=True, text=True, timeout=timeout, check=False,
    )  # fmt: skip


def run_line(folder, line):
    """Run a line of the page that begins with ``ross``."""
    return run(folder, "ross_payload.cli", *shlex.split(line)[1:])
