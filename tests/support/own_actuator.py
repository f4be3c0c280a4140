"""The plug-in of 'Add your own actuator': made from the page, installed into a folder, and run there."""

import re
from pathlib import Path

import pytest

from own_plugin import install

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
    install(folder, pip=True)  # as the page has it
    return folder
