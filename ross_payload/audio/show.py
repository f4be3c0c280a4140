"""What ``ross devices`` prints: a table of what can record, and the tap test."""

from __future__ import annotations

import click
from rich.markup import escape
from rich.table import Table

from ross_payload.audio.devices import Device
from ross_payload.audio.sources import open_source
from ross_payload.audio.tap import Tap, TapFinder
from ross_payload.audio.wiring import Wiring
from ross_payload.clock import SystemClock
from ross_payload.config import Config
from ross_payload.errors import AudioError
from ross_payload.interfaces import AudioSource, Clock
from ross_payload.terminal import with_whole_words

PATIENCE = 20.0  # [s] for each tap
BOOT = 60.0  # [s] that a sound card may take to appear
RETRY = 1.0  # [s]


def table(found: list[Device]) -> Table:
    """Return a table of devices."""
    table = Table("name", "channels", "default rate", "host API", "preset")
    for device in found:
        rate = f"{device.default_rate:g} Hz"
        table.add_row(escape(device.name), str(device.channels), rate, device.host_api, device.preset)
    return with_whole_words(table)


def tap(config: Config) -> None:
    """Ask for a tap on each microphone, and say whether they are swapped.

    Raises
    ------
    AudioError
        When the microphones cannot be opened, or no clear tap is heard.
    """
    with open_source(config, SystemClock()) as source:
        heard = []
        for microphone in (1, 2):
            click.echo(f"Tap microphone {microphone} once with a fingernail.")
            heard.append(_wait(source, config.hop))
            click.echo(f"  heard at microphone {heard[-1].microphone}, {heard[-1].margin_db:.0f} dB louder there")
    click.echo(verdict(config, *heard))


def wait(config: Config, clock: Clock) -> None:
    """Wait until the source of a configuration can be opened: at boot a sound card may come late.

    Raises
    ------
    AudioError
        When it still cannot after `BOOT` seconds; why.
    """
    end = clock.now() + BOOT
    while True:
        try:
            with open_source(config, clock):
                return
        except AudioError:
            if clock.now() >= end:
                raise
        clock.sleep(RETRY)


def _wait(source: AudioSource, hop: int) -> Tap:
    finder = TapFinder()
    for _ in range(round(PATIENCE * source.rate / hop)):
        tap = finder.listen(source.read(hop).samples)
        if tap is None:
            continue
        if tap.clear:
            return tap
        click.echo(f"  equally loud at both ({tap.margin_db:.1f} dB apart): tap again, nearer to one of them")
    raise AudioError(f"no clear tap within {PATIENCE:g} s; check the levels with `ross doctor`")


def verdict(config: Config, first: Tap, second: Tap) -> str:
    """Say what taps on microphone 1 and then 2 mean, and what to write into the configuration."""
    order = (first.microphone, second.microphone)
    if order == (1, 2):
        return "Microphones 1 and 2 are as configured."
    if order == (2, 1):
        channels = Wiring.of(config.audio).channels
        return f"The microphones are swapped: write channels = [{channels[1]}, {channels[0]}] in [audio]."
    return f"Both taps were heard at microphone {order[0]}: is the other one connected? Try again."
