"""The lowest versions of packages that `pyproject.toml` admits are enough."""

import re
import subprocess
import sys
import tomllib
import venv
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
pytestmark = [
    pytest.mark.soak,  # gets some 150 MB of packages
    pytest.mark.skipif(sys.version_info >= (3, 13), reason="the oldest packages have no wheels for it"),
]
EXAMPLE = ROOT / "docs" / "examples" / "paper-bench.toml"
EVERY_MODULE = """
import importlib, pkgutil, sys
for name in ("ross_protocols", "ross_payload", "ross_sim"):
    for module in pkgutil.walk_packages(importlib.import_module(name).__path__, f"{name}."):
        try:
            importlib.import_module(module.name)
        except ModuleNotFoundError as error:
            assert not error.name.startswith("ross"), error
"""


def output(command, **options):
    return subprocess.run(command, capture_output=True, text=True, check=False, **options)


@pytest.fixture(scope="module")
def lowest(tmp_path_factory):
    """The Python of an environment with the code of this folder, and the lowest versions of what it needs."""
    folder = tmp_path_factory.mktemp("lowest")
    venv.create(folder, with_pip=True)
    python = folder / "bin" / "python"
    needed = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["dependencies"]
    pinned = [need.replace(">=", "==") for need in needed]
    got = output([python, "-m", "pip", "install", "--quiet", ROOT, *pinned])
    if re.search(r"No matching distribution|Max retries|Temporary failure|Connection", got.stderr):
        pytest.skip(f"no packages here: {got.stderr.strip().splitlines()[-1]}")
    assert got.returncode == 0, got.stderr
    return python


def test_every_module_can_be_imported(lowest):
    done = output([lowest, "-W", "ignore", "-c", EVERY_MODULE])
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        (["config", "check", EXAMPLE], 0, f"{EXAMPLE}: good\n"),
        (["config", "check", "missing.toml"], 2, "ross: missing.toml: cannot be read: No such file or directory\n"),
        (["party"], 2, "ross: No such command 'party'\n"),
    ],
)
def test_commands_say_what_they_say_with_the_newest(lowest, tmp_path, arguments, code, said):
    done = output([lowest, "-m", "ross_payload.cli", *arguments], cwd=tmp_path)
    assert (done.returncode, done.stdout + done.stderr) == (code, said)
