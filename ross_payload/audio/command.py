"""``ross devices``: what can be heard with, and which microphone is which."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from rich.table import Table

    from ross_payload.audio.sound_devices import Device


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
    help="Wait until the microphones of a configuration can be opened.",
)
def command(*, as_json: bool, config: Path | None, awaited: Path | None) -> None:
    """List the devices that can record, and the preset ([audio] preset) that fits the name of each.

    Write a part of the name that no other device has as [audio] source = "device:NAME".
    """
    from rich.console import Console

    from ross_payload import plugins
    from ross_payload.audio.open_source import GROUP
    from ross_payload.audio.sound_devices import devices, portaudio
    from ross_payload.audio.tap_test import tap, wait
    from ross_payload.clock import SystemClock
    from ross_payload.config import load

    if config is not None:
        tap(load(config))
        return
    if awaited is not None:
        wait(load(awaited), SystemClock())
        return
    found = devices(portaudio())
    others = [name for name in plugins.available(GROUP) if name != "device"]
    if as_json:
        click.echo(json.dumps([asdict(device) for device in found], indent=2))
    elif found:
        Console().print(table(found))
    else:
        click.echo("No device can record. Is it plugged in, and is this user in the group 'audio'?")
    if not as_json:
        click.echo(f"Other sources, as NAME:ADDRESS: {', '.join(others)}")


def table(found: Sequence[Device]) -> Table:
    """Return a table of devices."""
    from rich.markup import escape
    from rich.table import Table

    from ross_payload.terminal_tables import with_whole_words

    table = Table("name", "channels", "default rate", "host API", "preset")
    for device in found:
        rate = f"{device.default_rate:g} Hz"
        table.add_row(escape(device.name), str(device.channels), rate, device.host_api, device.preset)
    return with_whole_words(table)
