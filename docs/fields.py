"""Fields of dataclasses and members of enumerations, on pages made from the code, with the comments beside them."""

from __future__ import annotations

import dataclasses
import inspect
import re
from enum import EnumMeta
from typing import Any

from sphinx.application import Sphinx

FIELD = re.compile(r"    (\w+)(?:: ([^#=]+?))?(?: = .+?)?  # (.+)")  # name, type, comment
BEFORE_NUMPYDOC = 400  # the priority of napoleon is 500


def add_fields(_app: Sphinx, what: str, _name: str, thing: Any, _options: Any, lines: list[str]) -> None:
    """Append the fields that have a comment to what a class says of itself."""
    if what != "class" or not (dataclasses.is_dataclass(thing) or isinstance(thing, EnumMeta)):
        return
    known = set(thing.__members__ if isinstance(thing, EnumMeta) else thing.__dataclass_fields__)
    told = [match.groups() for line in inspect.getsource(thing).splitlines() if (match := FIELD.fullmatch(line))]
    rows = [row for row in told if row[0] in known]
    if rows:
        lines += ["", "Attributes", "----------"]
        for name, kind, comment in rows:
            lines += [f"{name} : {kind}" if kind else name, f"    {comment}"]


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the extension."""
    app.connect("autodoc-process-docstring", add_fields, priority=BEFORE_NUMPYDOC)
    return {"parallel_read_safe": True}
