"""The code blocks and the shell commands of README and manual, as a reader sees them."""

import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
BLOCK = re.compile(r"^(?P<indent> *)```(?P<language>\S*)[^\n]*\n(?P<text>.*?)^ *```$", re.DOTALL | re.MULTILINE)
INDENTED = re.compile(r"(?<=\n\n)(?:    (?:ross|python) .*\n(?:    .*\n)*)+")  # commands without fences
COMMENT = re.compile(r"(^|\s+)#\s.*$")


@dataclass(frozen=True)
class Block:
    page: str  # relative to the repository
    line: int  # of the fence
    language: str
    text: str

    @property
    def commands(self):
        """The command lines of a shell block, without comments and continuations."""
        joined = self.text.replace("\\\n", " ").splitlines()
        return [command for line in joined if (command := COMMENT.sub("", line).strip())]


@cache
def pages():
    """What lies at the top, and every page of the manual."""
    top = ("README.md", "CONTRIBUTING.md", "SECURITY.md")
    return (*(ROOT / name for name in top), *sorted((ROOT / "docs").rglob("*.md")))


@cache
def every_block():
    """All fenced blocks in the order of the pages; the language of a directive is its name, such as `{include}`."""
    found = []
    for path in pages():
        text = path.read_text(encoding="utf-8")
        page = str(path.relative_to(ROOT))
        here = [(block.start(), block["language"], block["text"]) for block in BLOCK.finditer(text)]
        here += [(block.start(), "sh", block[0]) for block in INDENTED.finditer(text)]
        found += [Block(page, text.count("\n", 0, start) + 1, kind, words) for start, kind, words in sorted(here)]
    return tuple(found)


def blocks(language):
    """All code blocks of a language, in the order of the pages."""
    return tuple(block for block in every_block() if block.language == language)


def block(page, language, containing=""):
    """The first block of a page that contains a text."""
    return next(one for one in blocks(language) if one.page == page and containing in one.text)


def command(page, beginning):
    """The command line of a page that is this one, or the only one that begins so, but for a path before `ross`."""
    lines = {line.removeprefix(".venv/bin/") for one in blocks("sh") if one.page == page for line in one.commands}
    (found,) = lines & {beginning} or {line for line in lines if line.startswith(beginning)}
    return found


def executed(program):
    """Run a program that a page prints, in this process; return its names."""
    names = {"__name__": "__main__"}
    exec(compile(program, "<manual>", "exec"), names)  # noqa: S102  # to run what we print is the purpose
    return names
