"""A Containerfile as values: its stages, and what each inherits."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass, field
from pathlib import Path


@dataclass
class Stage:
    """A stage: the instructions in their order, as pairs of a word and the rest."""

    name: str
    parent: str
    instructions: list[tuple[str, str]] = field(default_factory=list)


class Containerfile:
    """The stages of a file by name."""

    def __init__(self, path: Path) -> None:
        text = re.sub(r"(?m)^\s*#.*\n", "", path.read_text())
        text = re.sub(r"\\\n\s*", " ", text)
        self.stages: dict[str, Stage] = {}
        stage = Stage("", "")
        for line in filter(None, map(str.strip, text.splitlines())):
            word, _, rest = line.partition(" ")
            if word == "FROM":
                parent, _, name = rest.partition(" AS ")
                stage = self.stages[name] = Stage(name, parent)
            else:
                stage.instructions.append((word, rest.strip()))

    def inherited(self, name: str) -> list[tuple[str, str]]:
        """Return the instructions of a stage after those of the stages that it is made from."""
        stage = self.stages[name]
        return [*(self.inherited(stage.parent) if stage.parent in self.stages else []), *stage.instructions]

    def last(self, name: str, word: str) -> str:
        """Return the last instruction of a kind, which holds."""
        return [rest for each, rest in self.inherited(name) if each == word][-1]

    def labels(self, name: str) -> dict[str, str]:
        """Return the labels of a stage with the defaults of its arguments in their place."""
        found: dict[str, str] = {}
        arguments = dict(rest.split("=", 1) for word, rest in self.inherited(name) if word == "ARG" and "=" in rest)
        for word, rest in self.inherited(name):
            if word == "LABEL":
                for key, quote, value in re.findall(r"([\w.-]+)=(['\"])(.*?)\2(?=\s|$)", rest):
                    filled = re.sub(r"\$\{(\w+)\}", lambda match: arguments[match[1]], value)
                    found[key] = value if quote == "'" else filled
        return found

    def command(self, name: str, word: str) -> list[str]:
        """Return the words of an instruction in the form of a list."""
        listed: list[str] = json.loads(
            self.last(name, word).partition("[")[1] + self.last(name, word).partition("[")[2]
        )
        return listed
