"""``ross run`` and ``ross replay``: the payload, and a recorded mission again."""

from __future__ import annotations

from pathlib import Path

import click

from ross_payload.bounded_files import printable


@click.command("run", short_help="Run the payload that a TOML file describes.")
@click.argument("file", type=click.Path(path_type=Path))
def command(file: Path) -> int:
    """Run the payload that a TOML FILE describes until Ctrl-C or SIGTERM: it listens, accepts commands and reports.

    Nothing turns before a command, unless the file says so ([service] autostart).
    """
    from ross_payload.service.check import loaded
    from ross_payload.service.live import live

    return live(loaded(file))


REPLAY_EPILOG = """Exit codes: 0 replayed as far as the mission or the recording goes, 3 it ended early because the
recorded array is not where the mission needs it, 2 bad input, 1 the results could not be written."""


@click.command("replay", short_help="Run a recorded mission again.", epilog=REPLAY_EPILOG)
@click.argument("session", type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path), help="Folder for events, separated voices and replay.json.")
@click.option("--config", "file", type=click.Path(path_type=Path), help="TOML file instead of the recorded one.")
@click.option("--set", "settings", multiple=True, metavar="KEY=VALUE", help="Change one key; can be repeated.")
@click.option("--json", "as_json", is_flag=True, help="Print only the contents of replay.json.")
def replay(*, session: Path, out: Path | None, file: Path | None, settings: tuple[str, ...], as_json: bool) -> int:
    """Run the mission of the folder SESSION again: identically, or with another configuration.

    The mission processes the recorded audio and headings: the array does not turn differently. Where another
    configuration needs another heading, the replay reports it and continues as long as the recorded headings fit.
    """
    import json

    from ross_payload.plugin_calls import telling_late_calls
    from ross_payload.service.replay import in_words, perform

    with telling_late_calls():
        values = perform(session, out, file, settings)
    if as_json:
        click.echo(json.dumps(values, indent=2, allow_nan=False))
    else:
        for line in in_words(values):
            click.echo(printable(line))
    return 3 if values["ended_early"] else 0
