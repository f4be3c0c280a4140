"""The manual says what the code says, and builds without a warning."""

import importlib.util
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize(("script", "page"), [("tables", "configuration"), ("faults", "actuator-faults")])
def test_a_generated_page_says_what_the_code_says(script, page):
    spec = importlib.util.spec_from_file_location(script, ROOT / "docs" / f"{script}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert module.tables() in (ROOT / "docs" / "reference" / f"{page}.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def manual(tmp_path_factory):
    """The folder of the built manual, and what the build said."""
    folder = tmp_path_factory.mktemp("html")
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-b", "html", ROOT / "docs", folder]
    return folder, subprocess.run(command, capture_output=True, text=True, check=False)


def test_the_manual_builds_with_warnings_as_errors(manual):
    folder, built = manual
    assert built.returncode == 0, built.stderr
    assert (folder / "index.html").exists()


def test_formulas_are_drawn_without_a_script_and_without_a_network(manual):
    folder, _ = manual
    formulas = 0
    for page in folder.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        formulas += text.count("<math ")
        assert not re.search(r'<script[^>]+(mathjax|katex|src="https?:)|\\[\[(]|<merror', text), page
    assert formulas > 60
