"""``ross devices``: what can be heard with, and which microphone is which."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

import click


@click.command("devices", short_help="List microphones, or identify them by tapping.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON only.")
@click.option(
    "--tap",
    "config",
    type=click.Path(path_type=Path),
    metavar="CONFIG",
    help="Check by tapping whether the microphones of a configuration are swapped.",
)
@click.option(
    "--wait",
    "awaited",
    type=click.Path(path_type=Path),
    metavar="CONFIG",
    help="Wait up to a minute until the microphones of a configuration can be opened.",
)
def command(*, as_json: bool, config: Path | None, awaited: Path | None) -> None:
    """List the devices that can record, and the preset ([audio] preset) that fits the name of each.

    Write a part of the name that no other device has as [audio] source = "device:NAME".
    """
    from rich.console import Console

    from ross_payload.audio.devices import devices, portaudio
    from ross_payload.audio.show import table, tap, wait
    from ross_payload.clock import SystemClock
    from ross_payload.config import load

    if config is not None:
        tap(load(config))
        return
    if awaited is not None:
        wait(load(awaited), SystemClock())
        return
    found = devices(portaudio())
    if as_json:
        click.echo(json.dumps([asdict(device) for device in found], indent=2))
    elif found:
        Console().print(table(found))
    else:
        click.echo("No device can record. Is it plugged in, and is this user in the group 'audio'?")
