"""The manual says what the code says, and builds without a warning: the whole of it in `make soak` and `make docs`."""

import ast
import importlib.util
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from manual import every_block
from ross_payload import ground, interfaces
from ross_payload.actuators.vehicle_yaw.options import Options

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize(
    ("script", "page"),
    [
        ("tables", "reference/configuration"),
        ("faults", "reference/actuator-faults"),
        ("rest", "reference/rest"),
        ("constants", "explanation/where-to-turn"),
    ],
)
def test_a_generated_page_says_what_the_code_says(script, page):
    assert script_of(script).tables() in (ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8")


def test_levels_above_talkers_are_those_that_are_calculated():
    text = (ROOT / "docs" / "explanation" / "how-loud-may-the-drone-be.md").read_text(encoding="utf-8")
    tables = script_of("levels").tables()
    assert len(tables) == text.count("<!-- calculated by docs/levels.py") == 2
    assert all(table in text for table in tables)


def script_of(name):
    """A script of the manual."""
    spec = importlib.util.spec_from_file_location(name, ROOT / "docs" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_every_option_of_a_vehicle_that_yaws_is_told_with_its_default():
    page = (ROOT / "docs" / "reference" / "vehicle-yaw.md").read_text(encoding="utf-8")
    rows = {}
    for keys, default in re.findall(r"^\| (`\w+`(?:, `\w+`)*) \| ([^|]+) \|", page, re.MULTILINE):
        rows |= dict(zip(re.findall(r"`(\w+)`", keys), re.findall(r"`([^`]+)`", default), strict=True))
    assert rows == {name: json.dumps(field.default).removesuffix(".0") for name, field in Options.model_fields.items()}


@pytest.mark.parametrize("page", ["safety", "links", "actuator-faults", "stability", "ground-page"])
def test_a_promise_names_tests_that_exist(page):
    tests = list((ROOT / "tests").rglob("test_*.py"))
    known = {path.stem for path in tests}
    known |= {name for path in tests for name in re.findall(r"def (test_\w+)", path.read_text(encoding="utf-8"))}
    text = (ROOT / "docs" / "reference" / f"{page}.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`(?:tests/(?:\w+/)+)?(test_\w+)(?:\.py)?`", text))
    assert named
    assert named <= known, sorted(named - known)


def test_every_row_of_the_tables_of_promises_names_its_test():
    text = (ROOT / "docs" / "reference" / "safety.md").read_text(encoding="utf-8")
    tables = [table.splitlines() for table in re.findall(r"(?:^\|.*\n)+", text, re.MULTILINE)]
    assert len(tables) == 5
    rows = [row for table in tables for row in table[2:]]
    assert all(table[0].endswith("| held by the test |") for table in tables)
    bare = [row for row in rows if "test_" not in row]
    assert [row.split("|")[1].strip() for row in bare] == ["`ideal`", "your own"]  # no motor; not ours


def test_every_page_is_in_a_table_of_contents():
    docs, named = ROOT / "docs", set()
    for name in ("index.md", "explanation/decisions.md"):
        path = docs / name
        for tree in re.findall(r"```\{toctree\}\n(.*?)```", path.read_text(encoding="utf-8"), re.DOTALL):
            for entry in re.findall(r"(?m)^(?!:)\S+$", tree):
                folder, _, pattern = entry.rpartition("/")
                found = list((path.parent / folder).glob(f"{pattern}.md"))
                assert found, f"{name}: {entry}"
                named |= {page.resolve() for page in found}
    assert set(docs.rglob("*.md")) - {docs / "index.md"} - set((docs / "_build").rglob("*.md")) == named


def test_the_page_of_the_client_asks_for_every_public_name():
    text = (ROOT / "docs" / "reference" / "client-api.md").read_text(encoding="utf-8")
    asked = set(re.findall(r"^\.\. auto\w+:: ([\w.]+)$", text, re.MULTILINE))
    places = {name: {f"ross_payload.ground.{name}", getattr(ground, name).__module__} for name in ground.__all__}
    assert [name for name, where in places.items() if not where & asked] == []


@pytest.mark.parametrize(
    "block", [each for each in every_block() if each.language in ("{include}", "{literalinclude}")]
)
def test_what_a_page_includes_is_there(block):
    """A file, an object of Python in it by its name, and the words at which a piece of it begins and ends."""
    first = (ROOT / block.page).read_text(encoding="utf-8").splitlines()[block.line - 1]
    text = ((ROOT / block.page).parent / first.rpartition(" ")[2]).read_text(encoding="utf-8")
    options = dict(re.findall(r"(?m)^:([\w-]+): (.+)$", block.text))
    if name := options.get("pyobject"):
        text = piece(text, name)
    for option in ("start-at", "start-after", "end-at", "end-before"):
        words = options.get(option, "")
        assert words in text, f"{block.page}: {first}: {option}: {words}"
        text = text[text.index(words) :] if option.startswith("start") else text


def piece(text, name):
    """The source of a class, a function or a method."""
    node = ast.parse(text)
    for part in name.split("."):
        node = next(one for one in node.body if getattr(one, "name", None) == part)
    return ast.get_source_segment(text, node)


THEMED = ("index", "explanation/decisions", "explanation/where-to-turn")
BUILDS = """
import gc
import sys
from sphinx.builders.html import StandaloneHTMLBuilder
from sphinx.cmd.build import main

docs, pages, doctrees, *themed = sys.argv[1:]
command = ["-W", "--keep-going", "-q", "-b", "html", "-d", doctrees, "-D", "smartquotes=0"]  # as quotes are typed
StandaloneHTMLBuilder.search = False  # Sphinx's own, and a quarter of the time
gc.disable()  # what pages are made of is needed to the end
plain = main([*command, "-D", "html_theme=basic", docs, pages])
sys.exit(plain or main([*command, docs, pages, *themed]))
"""


@pytest.fixture(scope="module")
def manual(tmp_path_factory):
    """The folder of the built manual, and what the builds said.

    Only some pages are built with the manual's theme: it takes as long as all the rest.
    """
    folder = tmp_path_factory.mktemp("html")
    paths = [ROOT / "docs", folder / "pages", folder / "doctrees"]
    command = [sys.executable, "-c", BUILDS, *paths, *(ROOT / "docs" / f"{name}.md" for name in THEMED)]
    return paths[1], subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.mark.soak
def test_the_manual_builds_with_warnings_as_errors(manual):
    folder, built = manual
    assert built.returncode == 0, built.stderr
    assert len(list(folder.rglob("*.html"))) > len(list((ROOT / "docs").rglob("*.md")))
    for name in THEMED:
        assert "furo" in (folder / f"{name}.html").read_text(encoding="utf-8")


@pytest.mark.soak
def test_formulas_are_drawn_without_a_script_and_without_a_network(manual):
    folder, _ = manual
    formulas = 0
    for page in folder.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        formulas += text.count("<math ")
        assert not re.search(r'<script[^>]+(mathjax|katex|src="https?:)|\\[\[(]|<merror', text), page
    assert formulas > 60


def test_how_tos_stand_in_at_most_seven_groups_and_each_page_in_one():
    trees = re.findall(r"```\{toctree\}\n(.*?)```", (ROOT / "docs" / "index.md").read_text(encoding="utf-8"), re.DOTALL)
    groups = [pages for tree in trees if (pages := re.findall(r"(?m)^how-to/(\S+)$", tree))]
    assert len(groups) <= 7
    assert max(map(len, groups)) <= 8
    named = [page for group in groups for page in group]
    assert sorted(named) == sorted(path.stem for path in (ROOT / "docs" / "how-to").glob("*.md"))


@pytest.mark.soak
def test_decisions_are_on_a_page_of_their_own(manual):
    folder, _ = manual
    index, page = ((folder / name).read_text(encoding="utf-8") for name in ("index.html", "explanation/decisions.html"))
    assert "0044-a-stop" not in re.search(r'<div class="toctree-wrapper.*', index, re.DOTALL)[0]
    assert "0044-a-stop" in re.search(r'<div class="toctree-wrapper.*', page, re.DOTALL)[0]


@pytest.mark.soak
def test_every_public_name_is_on_its_page(manual):
    folder, _ = manual
    client = (folder / "reference" / "client-api.html").read_text(encoding="utf-8")
    assert [name for name in ground.__all__ if f'.{name}"' not in client] == []
    seams = (folder / "reference" / "plugin-api.html").read_text(encoding="utf-8")
    own = [name for name, kind in vars(interfaces).items() if getattr(kind, "__module__", "") == interfaces.__name__]
    assert [name for name in own if f'id="ross_payload.interfaces.{name}"' not in seams] == []
    assert "smallest step [rad]" in seams  # comments of fields tell their units
