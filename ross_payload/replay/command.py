"""``ross replay``: a recorded mission again."""

from __future__ import annotations

from pathlib import Path

import click

EPILOG = """Exit codes: 0 replayed as far as the mission or the recording goes, 3 it ended early because the recorded
array is not where the mission needs it, 2 bad input, 1 the results could not be written."""


@click.command("replay", short_help="Run a recorded mission again.", epilog=EPILOG)
@click.argument("session", type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path), help="Folder for events, separated voices and replay.json.")
@click.option("--config", "file", type=click.Path(path_type=Path), help="TOML file instead of the recorded one.")
@click.option("--set", "settings", multiple=True, metavar="KEY=VALUE", help="Change one key; can be repeated.")
@click.option("--json", "as_json", is_flag=True, help="Print only the contents of replay.json.")
def command(*, session: Path, out: Path | None, file: Path | None, settings: tuple[str, ...], as_json: bool) -> int:
    """Run the mission of the folder SESSION again: identically, or with another configuration.

    The mission processes the recorded audio and headings: the array does not turn differently. Where another
    configuration needs another heading, the replay reports it and continues as long as the recorded headings fit.
    """
    import json

    from ross_payload.replay.performance import in_words, perform

    values = perform(session, out, file, settings)
    if as_json:
        click.echo(json.dumps(values, indent=2, allow_nan=False))
    else:
        for line in in_words(values):
            click.echo(line)
    return 3 if values["ended_early"] else 0
