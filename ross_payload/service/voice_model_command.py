"""``ross voice-model``: add a network that tells voices apart better than the built-in model."""

from __future__ import annotations

from pathlib import Path

import click

from ross_payload.bounded_files import printable

LONGEST = 200  # of what a file says of itself [characters]


@click.group(short_help="Add or remove a network that compares voices.")
def command() -> None:
    """Networks that compare voices: ONNX files, as they are published for speaker verification.

    A network that was added is used by default; [voice_print] model chooses one of several. Voices that were
    enrolled with another model must be enrolled again.
    """


@command.command("add")
@click.argument("file", metavar="FILE.onnx", type=click.Path(path_type=Path))
@click.option("--calibration", type=click.Path(path_type=Path), help="How its scores are read; else as those of CAM++.")
def add(file: Path, calibration: Path | None) -> None:
    """Check FILE.onnx and keep a copy: from 80 Kaldi filter banks at 16 kHz to one embedding."""
    from ross_payload.voiceprint.model_folder import ModelFolder

    model = ModelFolder.default().add(file, calibration)
    click.echo(f"added {file.stem}: {file.stat().st_size / 1e6:.1f} MB, {model.size} numbers for each voice")
    click.echo(f"licence: {_line(model.licence) or 'the file names none: see where it was published'}")
    click.echo(f"calibration: {_line(model.calibration.source) or 'none of its own: as measured on CAM++'}")
    click.echo("voices that were enrolled with another model have to be enrolled again: ross enroll NAME FILE.wav")


@command.command("list")
def show() -> None:
    """List the models; a star marks the one that is used by default."""
    from ross_payload.voiceprint.model_folder import ModelFolder

    folder = ModelFolder.default()
    names = folder.names()
    for name in ("built-in", *names):
        used = name == names[0] if len(names) == 1 else name == "built-in" and not names
        click.echo(f"{'*' if used else ' '} {name}")


@command.command("remove")
@click.argument("name")
def remove(name: str) -> None:
    """Delete the copy of a network."""
    from ross_payload.voiceprint.model_folder import ModelFolder

    ModelFolder.default().remove(name)
    click.echo(f"removed {name}")


def _line(text: str) -> str:
    """Return what a file says of itself as one line."""
    return printable(text[:LONGEST])
