"""Prints the tables of docs/reference/configuration.md from the models; a test compares the page with them."""

import sys
import tokenize
from pathlib import Path
from typing import get_args

from ross_payload import config


def comments() -> dict[tuple[str, str], str]:
    """The comment behind every field of every model: {(class, field): text}."""
    found, model, field = {}, "", ""
    with Path(config.__file__).open("rb") as source:
        for token in tokenize.tokenize(source.readline):
            if token.type == tokenize.NAME and token.line.startswith("class "):
                model = token.line.split()[1].split("(")[0]
            elif token.type == tokenize.NAME and token.start[1] == 4 and ":" in token.line:
                field = token.string
            elif token.type == tokenize.COMMENT and token.start[1] > 4:
                found[model, field] = token.string.lstrip("# ")
    return found


def tables() -> str:
    """Every table of the configuration as Markdown."""
    about, parts = comments(), []
    for name, field in config.Config.model_fields.items():
        model = next((part for part in get_args(field.annotation) if part is not type(None)), field.annotation)
        if not isinstance(model, type) or not issubclass(model, config.Table):
            continue
        about_model = (model.__doc__ or "").split(": ", 1)[-1]
        parts.append(f"## `[{name}]`\n\n{about_model[0].upper() + about_model[1:]}\n")
        parts.append("| key | default | means |\n| --- | --- | --- |")
        for key, value in model.model_fields.items():
            default = None if value.is_required() else value.get_default(call_default_factory=True)
            default = str(default).lower() if isinstance(default, bool) else default
            shown = "" if default in (None, {}, ()) else f"`{default}`"
            parts.append(f"| `{key}` | {shown} | {about.get((model.__name__, key), '')} |")
        parts.append("")
    return "\n".join(parts)


if __name__ == "__main__":
    sys.stdout.write(tables())
