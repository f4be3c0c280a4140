"""How the code is laid out: names tell rooms apart, imports form no circle, and a file is worth opening."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ARCHITECTURE = ROOT / "docs" / "explanation" / "architecture.md"
GLOSSARY = ROOT / "docs" / "explanation" / "glossary.md"
SOURCES = {
    ".".join(path.relative_to(top).with_suffix("").parts).removesuffix(".__init__"): path
    for top, package in ((".", "ross_payload"), ("protocols", "ross_protocols"), ("sim", "ross_sim"))
    for path in sorted((ROOT / top / package).rglob("*.py"))
    for top in (ROOT / top,)
}
PACKAGES = {name for name, path in SOURCES.items() if path.name == "__init__.py"}
SHORT_LINES, SHORT_SHARE = 60, 0.15


def statements(text):
    """The lines that import, each for itself: to parse those takes a tenth of the time that all of it takes."""
    found = re.findall(r"^ *((?:import|from [\w.]+ import) (?:\((?:[^)#]|#.*)*\)|.*))", text, re.MULTILINE)
    return [line for line in found if parses(line)]


def parses(line):
    """Whether it is code; prose may begin with these words."""
    try:
        return bool(ast.parse(line))
    except SyntaxError:
        return False


def imports(name):
    """The modules that a module imports anywhere, in functions and for types too."""
    for node in ast.walk(ast.parse("\n".join(statements(SOURCES[name].read_text(encoding="utf-8"))))):
        if isinstance(node, ast.Import):
            found = {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            inner = {f"{node.module}.{alias.name}" for alias in node.names} & SOURCES.keys()
            found = inner or {node.module}
        else:
            continue
        yield from found & SOURCES.keys() - {name}


def circles(graph):
    """Modules that reach themselves: what is left when whatever imports nothing that is left has been removed."""
    left = {name: set(targets) for name, targets in graph.items()}
    while ends := {name for name, targets in left.items() if not targets & left.keys()}:
        left = {name: targets for name, targets in left.items() if name not in ends}
    while starts := left.keys() - {each for targets in left.values() for each in targets}:
        left = {name: targets for name, targets in left.items() if name not in starts}
    return sorted(left)


def test_no_import_forms_a_circle():
    assert circles({name: set(imports(name)) for name in SOURCES}) == []


def test_a_circle_is_found():
    assert circles({"a": {"b"}, "b": {"c"}, "c": {"b"}, "d": set()}) == ["b", "c"]


def test_no_module_has_the_name_of_a_room():
    rooms = {name.rpartition(".")[2] for name in PACKAGES}
    assert [name for name in SOURCES.keys() - PACKAGES if name.rpartition(".")[2] in rooms] == []


def test_few_files_are_short():
    lengths = [len(path.read_text(encoding="utf-8").splitlines()) for path in SOURCES.values()]
    assert sum(length < SHORT_LINES for length in lengths) <= SHORT_SHARE * len(lengths)


def last_columns(page):
    """What stands in backquotes in the last column of the tables of a page."""
    rows = re.findall(r"^\|.*\|([^|]*)\|$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {name for row in rows for name in re.findall(r"`([^`]+)`", row)}


def code():
    """Every word of the product's code."""
    return {word for path in SOURCES.values() for word in re.findall(r"\w+", path.read_text(encoding="utf-8"))}


def test_a_type_that_crosses_in_a_walk_exists():
    types = {name for name in last_columns(ARCHITECTURE) if re.fullmatch(r"([A-Z][a-z]+)+", name)}
    defined = set()
    for path in SOURCES.values():
        defined |= set(re.findall(r"^(?:class )?(\w+)(?=[(:]| =)", path.read_text(encoding="utf-8"), re.MULTILINE))
    assert len(types) > 20
    assert types - defined == set()


def test_a_name_in_code_that_the_glossary_gives_exists():
    rooms, words = {part for name in SOURCES for part in name.split(".")}, code()
    names = {part for name in last_columns(GLOSSARY) for part in re.findall(r"\w+", name)} - {"py", "sim", "scenarios"}
    assert len(names) > 60
    assert names - words - rooms == set()


@pytest.mark.parametrize("name", sorted(set(re.findall(r"`([a-z_/0-9]+\.(?:py|js))`", ARCHITECTURE.read_text()))))
def test_a_file_that_the_architecture_names_exists(name):
    tops = (".", "ross_payload", "protocols", "protocols/ross_protocols/mavlink")
    assert any((ROOT / top / name).is_file() for top in tops)
