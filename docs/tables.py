"""Prints the tables of docs/reference/configuration.md from the models; a test compares the page with them."""

import json
import sys
import tokenize
from pathlib import Path
from typing import Literal, get_args, get_origin

from ross_payload import config
from ross_payload.actuators.canopen_drive import options as canopen_drive
from ross_payload.actuators.dronecan_servo import options as dronecan_servo
from ross_payload.actuators.grbl import options as grbl
from ross_payload.actuators.mavlink_gimbal import options as mavlink_gimbal
from ross_payload.actuators.tb6600 import options as tb6600
from ross_payload.audio.sinks import device_sink, file_sink, rtp_sink, tcp_sink
from ross_payload.localization import markov_explorer


def comments(path: Path) -> dict[tuple[str, str], str]:
    """The comment behind every field of every model of a file: {(class, field): text}."""
    found, model, field = {}, "", ""
    with path.open("rb") as source:
        for token in tokenize.tokenize(source.readline):
            if token.type == tokenize.NAME and token.line.startswith("class "):
                model = token.line.split()[1].split("(")[0]
            elif token.type == tokenize.NAME and token.start[1] == 4 and ":" in token.line:
                field = token.string
            elif token.type == tokenize.COMMENT and token.start[1] > 4:
                found[model, field] = token.string.lstrip("# ")
    return found


def default(value) -> str:
    """The default of a field as it would stand in a file; empty where there is none."""
    if value.is_required():
        return "*required*"
    shown = value.get_default(call_default_factory=True)
    return "" if shown in (None, {}, (), "") else f"`{json.dumps(shown)}`"


def options() -> list[str]:
    """The table of the options of Algorithm 1, with the defaults of both of its names."""
    about, plain = comments(Path(markov_explorer.__file__)), markov_explorer.PlainOptions.model_fields
    lines = [
        "## `[explore.options]` of `markov` and `markov-plain`\n",
        "Algorithm 1: its front end and the numbers that the paper leaves open. `joint` has no options.\n",
        "| key | `markov` | `markov-plain` | means |\n| --- | --- | --- | --- |",
    ]
    for key, value in markov_explorer.MarkovOptions.model_fields.items():
        lines.append(f"| `{key}` | {default(value)} | {default(plain[key])} | {about['MarkovOptions', key]} |")
    return [*lines, ""]


def rows(model, about) -> list[str]:
    """A table with one row for every field of a model."""
    lines = ["| key | default | means |\n| --- | --- | --- |"]
    for key, value in model.model_fields.items():
        means = about.get((model.__name__, key), "")
        lines.append(f"| `{key}` | {default(value)} | {means}{choices(value.annotation, means)} |")
    return [*lines, ""]


def choices(annotation, means: str) -> str:
    """The words or numbers that a field may have, in brackets, where what it means does not name them all."""
    kinds = (annotation, *get_args(annotation))
    words = next((get_args(kind) for kind in kinds if get_origin(kind) is Literal), ())
    shown = [str(word) for word in words if word != ""]
    told = len(shown) < 2 or all(word in means for word in shown)
    return "" if told else f" ({', '.join(f'`{word}`' for word in shown)})"


def actuators() -> list[str]:
    """The tables of the options of every back end but ``vehicle_yaw``, which has a page of its own."""
    lines = ["Those of `vehicle_yaw` are on [its page](vehicle-yaw.md); a plug-in has its own.\n"]
    for module in (tb6600, grbl, canopen_drive, dronecan_servo, mavlink_gimbal):
        name = module.__name__.split(".")[-2]
        lines += [f"## `[actuator.options]` of `{name}`\n", *rows(module.Options, comments(Path(module.__file__)))]
    return lines


def streams() -> list[str]:
    """The tables below [listening]: one for each stream, and the options of every sink."""
    stream = config.Stream
    about = comments(Path(sys.modules[stream.__module__].__file__))
    lines = ["## `[[listening.streams]]`\n", "One voice, or the mixture, to one sink, live.\n", *rows(stream, about)]
    for module in (file_sink, device_sink, tcp_sink, rtp_sink):
        name, model = module.__name__.rpartition(".")[2].removesuffix("_sink"), module.sink.Config
        lines += [f"## `[listening.streams.options]` of `{name}`\n", *rows(model, comments(Path(module.__file__)))]
    return lines


def tables() -> str:
    """Every table of the configuration as Markdown."""
    parts, about = [], {}
    for path in Path(config.__file__).parent.glob("*.py"):
        about |= comments(path)
    for name, field in config.Config.model_fields.items():
        parts_of = get_args(field.annotation)
        model = next((part for part in parts_of if part not in (type(None), Ellipsis)), field.annotation)
        heading = f"[[{name}]]" if Ellipsis in parts_of else f"[{name}]"
        if not isinstance(model, type) or not issubclass(model, config.Table):
            continue
        about_model = (model.__doc__ or "").split(": ", 1)[-1]
        parts.append(f"## `{heading}`\n\n{about_model[0].upper() + about_model[1:]}\n")
        parts += rows(model, about)
        parts += {"actuator": actuators, "explore": options, "listening": streams}.get(name, list)()
    return "\n".join(parts)


if __name__ == "__main__":
    sys.stdout.write(tables())
