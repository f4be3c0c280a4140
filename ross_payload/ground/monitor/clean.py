"""What others say, made safe for a terminal."""

from __future__ import annotations

from typing import Any


def clean(section: Any) -> Any:
    r"""Return plain JSON in which no text can move a cursor or change a terminal.

    >>> clean({"text": "RoSS: \x1b[2J", "k": [3]})
    {'text': 'RoSS: ?[2J', 'k': [3]}
    """
    if isinstance(section, str):
        return section if section.isprintable() else "".join(c if c.isprintable() else "?" for c in section)
    if isinstance(section, dict):
        return {key: clean(value) for key, value in section.items()}
    return [clean(value) for value in section] if isinstance(section, list) else section
