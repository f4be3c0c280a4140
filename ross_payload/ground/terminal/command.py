"""``ross monitor``: a payload in a terminal."""

from __future__ import annotations

from pathlib import Path

import click

from ross_payload.option_types import NumberRange

DEFAULT_URL = "udpin:127.0.0.1:14550"
SYSTEM_ID = click.IntRange(1, 255)
EPILOG = "Exit codes: 0 ended by the user, or --once printed the state; 2 bad input, or no telemetry."


@click.command("monitor", short_help="Watch and command a payload in a terminal.", epilog=EPILOG)
@click.argument("urls", metavar="[URL]...", nargs=-1)
@click.option("--payload", metavar="ID", help="Such as 1-191; default: the first one received.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object per change; with --once the whole state.")
@click.option("--once", is_flag=True, help="Print the state once and exit.")
@click.option(
    "--wait",
    type=NumberRange(0.1, infinite=True),
    default=10.0,
    show_default=True,
    help="How long --once waits for telemetry [s].",
)
@click.option("--mavlink-key", type=click.Path(path_type=Path), help="File with the signing key of the payload.")
@click.option(
    "--system-id",
    type=SYSTEM_ID,
    default=253,
    show_default=True,
    help="MAVLink system id of this program; must be unique.",
)
@click.option(
    "--hear-at",
    metavar="ADDRESS:PORT[/CODEC]",
    help="Where the keys h and m have the payload stream to, by RTP as opus (default) or L16.",
)
def command(
    *,
    urls: tuple[str, ...],
    payload: str | None,
    as_json: bool,
    once: bool,
    wait: float,
    mavlink_key: Path | None,
    system_id: int,
    hear_at: str | None,
) -> None:
    """Watch payloads on each URL (default: udpin:127.0.0.1:14550), until Ctrl-C.

    On a terminal it shows the state and accepts keys; elsewhere it prints one line per change.
    """
    from ross_payload.ground.terminal.app import Options, run
    from ross_protocols.mavlink.component_id import ComponentId
    from ross_protocols.mavlink.stream_command import place_of

    try:
        place = None if hear_at is None else place_of(hear_at)
    except ValueError as error:
        raise click.UsageError(f"--hear-at: {error}") from error
    try:
        who = None if payload is None else ComponentId.parse(payload)
    except ValueError as error:
        raise click.UsageError(f"--payload: {error}") from error
    run(Options(urls or (DEFAULT_URL,), who, as_json, once, wait, mavlink_key, system_id, place))
