"""The command that an error message prints installs what is missing, wherever the package came from."""

import subprocess
import sys
import tomllib
from importlib.metadata import PackageNotFoundError
from pathlib import Path

import pytest

from ross_payload import plugins

ROOT = Path(__file__).parents[2]
DECLARED = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]


@pytest.mark.parametrize("extra", sorted(set(DECLARED) - {"all"}))
def test_an_extra_s_line_names_what_the_extra_needs_and_never_ourselves(monkeypatch, extra):
    monkeypatch.setattr(plugins, "version", lambda _: "")
    line = plugins.install_line(extra)
    for requirement in DECLARED[extra]:
        own = requirement.startswith("ross-payload")
        assert own or f"'{requirement.partition(';')[0]}'" in line
    assert "ross-payload" not in line


def test_what_is_installed_is_not_named_beside_what_is_missing(monkeypatch):
    def version(name):
        if name == "scikit-learn":
            raise PackageNotFoundError
        return "1"

    monkeypatch.setattr(plugins, "version", version)
    assert plugins.install_line("study").endswith(" install 'scikit-learn>=1.4'")


def test_it_is_for_the_python_that_runs_this(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    assert plugins.install_line("serial").startswith(f"{sys.executable} -m pip install")
    monkeypatch.setenv("PATH", str(Path(sys.executable).parent))
    assert plugins.install_line("serial").startswith("pip install")


@pytest.mark.soak
def test_pip_accepts_the_line_without_an_index():
    line = plugins.install_line("serial").replace("install", "install --no-index --dry-run --quiet")
    done = subprocess.run(line, shell=True, capture_output=True, text=True, check=False)  # noqa: S602
    assert done.returncode == 0, done.stderr


def test_every_module_that_is_missed_by_name_belongs_to_an_extra():
    assert set(plugins.EXTRA_OF.values()) <= set(DECLARED)
