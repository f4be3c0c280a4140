"""``ross health``: how the payload is that runs on this computer."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click

EPILOG = "Exit codes: 0 it runs and makes progress, 1 it makes none, or no payload answers, 2 bad input."


@click.command("health", short_help="Show how the payload on this computer is.", epilog=EPILOG)
@click.argument("config", metavar="[CONFIG]", type=click.Path(path_type=Path), required=False)
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(config: Path | None, as_json: bool) -> int:
    """Show how the payload on this computer is: progress, state of its mission, microphones, links, recorder.

    It asks through a socket in the state folder: that of the TOML file CONFIG, else $STATE_DIRECTORY, else
    ~/.local/state/ross. Run it as the user of the payload. It also shows a mission in its fault state, a microphone
    that is dead and a link that is down, but only missing progress is a reason to restart the payload.
    """
    from ross_payload.service.health_socket import NAME, asked
    from ross_payload.service.state_folder import named_folder

    folder = named_folder(_state_dir(config))
    try:
        values = asked(folder)
    except (OSError, ValueError) as error:
        why = error.strerror or "no answer in time" if isinstance(error, OSError) else str(error)
        click.echo(f"ross: no payload answers at {folder / NAME}: {why}", err=True)
        return 1
    click.echo(json.dumps(values) if as_json else in_words(values))
    return 1 if values.get("late") else 0


def in_words(values: dict[str, Any]) -> str:
    """Return one line.

    >>> in_words({"late": [], "state": "idle", "detail": "", "microphones": ["dead 2"], "links_down": []})
    'idle; microphones: dead 2'
    """
    from ross_payload.bounded_files import printable

    state = f"{values.get('state')}: {values['detail']}" if values.get("detail") else str(values.get("state"))
    parts = [f"no progress: {', '.join(values['late'])}"] if values.get("late") else []
    parts.append(state)
    if values.get("microphones"):
        parts.append(f"microphones: {', '.join(values['microphones'])}")
    parts += [f"link {url} is down" for url in values.get("links_down", ())]
    if values.get("recording") in ("full", "broken"):
        parts.append(f"recording is {values['recording']}")
    return printable("; ".join(parts))


def _state_dir(config: Path | None) -> str:
    """Return [service] state_dir of a file; "" where it says nothing."""
    from ross_payload.bounded_files import parsed_toml, read_bounded
    from ross_payload.errors import ConfigError

    if config is None:
        return ""
    try:
        service = parsed_toml(read_bounded(config)).get("service", {})
    except OSError as error:
        raise ConfigError(f"{config}: {error.strerror}") from error
    except ValueError as error:
        raise ConfigError(f"{config}: not TOML: {error}") from error
    named = service.get("state_dir", "") if isinstance(service, dict) else ""
    return named if isinstance(named, str) else ""
