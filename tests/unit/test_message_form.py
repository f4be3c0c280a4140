"""How the product words what a user reads: a wrong value is `expected Y, got X`, in standard terms."""

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PRODUCT = ("ross_payload", "protocols", "sim")
GENERATED = {"ross_dialect.py"}  # pymavlink's code around our descriptions, which are in ross.xml
WORDS = re.compile(r"\bwanted\b", re.IGNORECASE)
TERMS = re.compile(
    r"\b(nobody else|somebody|everybody|nobody (answers|gives|listens|is sought)|looks for nobody|"
    r"says who it is|told from outside|well again|still not well|no word of|to and fro|(ended|stopped) by hand)\b"
)
SEAM = re.compile(r"""["']\s*[frb]*["']""")  # between parts of one text
KEYS = {  # names of arrays and parameters in files, not words for a user: (file, text)
    ("sim/ross_sim/study/training/noise_pieces.py", "wanted"),
    ("sim/ross_sim/study/training/refiner_clips.py", "wanted"),
}
PROSE = {"sim/ross_sim/talkers/texts.py"}  # what synthetic voices read aloud


@cache
def product() -> tuple[tuple[str, str, str], ...]:
    """Every Python file of the product that is written by hand: name, source, and the same with its texts joined."""
    paths = sorted(path for room in PRODUCT for path in (ROOT / room).rglob("*.py") if path.name not in GENERATED)
    sources = [(path.relative_to(ROOT).as_posix(), path.read_text(encoding="utf-8")) for path in paths]
    return tuple((name, source, SEAM.sub("", source)) for name, source in sources)


@cache
def read(source: str) -> tuple[tuple[int, str], ...]:
    """Every string literal of a source, with its line."""
    return tuple(texts(ast.parse(source)))


def texts(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Yield line and text of every string literal that is no docstring; a formatted one as a whole, {} for a value."""
    silent = set()
    for node in ast.walk(tree):  # a node comes before its parts
        if isinstance(node, ast.Expr):
            silent.add(id(node.value))
        elif isinstance(node, ast.JoinedStr):
            silent |= {id(part) for part in node.values}
            yield (
                node.lineno,
                "".join(str(part.value) if isinstance(part, ast.Constant) else "{}" for part in node.values),
            )
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in silent:
            yield node.lineno, node.value


def found(pattern: re.Pattern[str], source: str, name: str) -> list[str]:
    """The lines of a source whose texts match, but for the named exceptions."""
    if name in PROSE:
        return []
    return [
        f"{name}:{line}: {text}" for line, text in read(source) if pattern.search(text) and (name, text) not in KEYS
    ]


def everywhere(pattern: re.Pattern[str]) -> list[str]:
    """The lines of the product that match; a source in which nothing does is not parsed."""
    return [
        line for name, source, joined in product() if pattern.search(joined) for line in found(pattern, source, name)
    ]


def test_no_message_says_found_and_wanted():
    assert everywhere(WORDS) == []


@pytest.mark.soak
def test_messages_use_the_terms_of_the_field():
    assert everywhere(TERMS) == []


@pytest.mark.parametrize("path", ["protocols/mavlink/ross.xml", "protocols/dronecan/ross/20854.Status.uavcan"])
def test_descriptions_of_messages_use_the_terms_of_the_field(path):
    text = (ROOT / path).read_text(encoding="utf-8")
    assert not WORDS.search(text)
    assert not TERMS.search(text)


@pytest.mark.parametrize(
    "source",
    [
        'raise ValueError(f"found {x}, wanted {y}")',
        'say("2 found, 3 wanted")',
        'x = f"port: {n:g} found" f", wanted 1"',
    ],
)
def test_the_old_form_would_be_noticed(source):
    assert found(WORDS, source, "any.py")


@pytest.mark.parametrize("source", ['"""The wanted rate."""', "wanted = found = 1", 'x = "target found"'])
def test_names_docstrings_and_other_words_are_free(source):
    assert found(WORDS, source, "any.py") == []
