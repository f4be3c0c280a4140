"""The code blocks and the shell commands of README and manual, as a reader sees them."""

import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
BLOCK = re.compile(r"^(?P<indent> *)```(?P<language>\w*)\n(?P<text>.*?)^ *```$", re.DOTALL | re.MULTILINE)
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
    """README and every page of the manual."""
    return (ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")))


@cache
def blocks(language):
    """All code blocks of a language, in the order of the pages."""
    found = []
    for path in pages():
        text = path.read_text(encoding="utf-8")
        for block in BLOCK.finditer(text):
            if block["language"] == language:
                line = text.count("\n", 0, block.start()) + 1
                found.append(Block(str(path.relative_to(ROOT)), line, language, block["text"]))
    return tuple(found)


def block(page, language, containing=""):
    """The first block of a page that contains a text."""
    return next(one for one in blocks(language) if one.page == page and containing in one.text)


def command(page, beginning):
    """The command line of a page that is this one, or the only one that begins so, but for a path before `ross`."""
    lines = {line.removeprefix(".venv/bin/") for one in blocks("sh") if one.page == page for line in one.commands}
    (found,) = lines & {beginning} or {line for line in lines if line.startswith(beginning)}
    return found
