"""The plug-in of 'Add your own actuator': made from the page, installed into a folder, and run there."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "how-to" / "add-your-own-actuator.md"
FILE = re.compile(r"```(?:python|toml)\n# (?P<name>\S+)\n(?P<text>.*?)```", re.DOTALL)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The files of the page, and the package installed beside them."""
    folder = tmp_path_factory.mktemp("own")
    files = dict(FILE.findall(PAGE.read_text()))
    assert set(files) == {"pyproject.toml", "my_turntable/driver.py", "my_turntable/device.py", "bench.toml"}
    for name, text in files.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text)
    (folder / "my_turntable" / "__init__.py").touch()
    options = ["--quiet", "--no-deps", "--no-index", "--no-build-isolation", "--target", folder / "site"]
    subprocess.run([sys.executable, "-m", "pip", "install", *options, folder], check=True, capture_output=True)
    return folder


def run(folder, *command, cwd=None, timeout=250):
    environment = os.environ | {"PYTHONPATH": str(folder / "site"), "OMP_NUM_THREADS": "1"}
    return subprocess.run(
        [sys.executable, "-m", *map(str, command)],
        cwd=cwd or folder, env=environment, capture_output=True, text=True, timeout=timeout, check=False,
    )  # fmt: skip
