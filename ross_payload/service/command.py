"""``ross run``: the payload as a service."""

from __future__ import annotations

from pathlib import Path

import click


@click.command("run", short_help="Run the payload that a TOML file describes.")
@click.argument("file", type=click.Path(path_type=Path))
def command(file: Path) -> int:
    """Run the payload that a TOML FILE describes until Ctrl-C or SIGTERM: it listens, accepts commands and reports.

    Nothing turns before a command, unless the file says so ([service] autostart).
    """
    from ross_payload.service.check import loaded
    from ross_payload.service.live import live

    return live(loaded(file))
