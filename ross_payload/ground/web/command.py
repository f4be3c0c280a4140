"""``ross ground``: the ground station's page."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import click

DEFAULT_URL = "udpin:127.0.0.1:14550"
PORT = 8765
SYSTEM_ID = click.IntRange(1, 255)
EPILOG = "Exit codes: 0 ended by the user, 2 bad input."


@click.command("ground", short_help="Serve a web page to watch and command payloads.", epilog=EPILOG)
@click.argument("urls", metavar="[URL]...", nargs=-1)
@click.option("--port", type=click.IntRange(0, 65535), default=PORT, show_default=True, help="TCP port; 0: any.")
@click.option("--host", default="127.0.0.1", show_default=True, help="Any but the loopback needs a token.")
@click.option("--token-file", type=click.Path(path_type=Path), help="File with the token, mode 0600; else a new one.")
@click.option("--certificate", type=click.Path(path_type=Path), help="Certificate for TLS (PEM file).")
@click.option("--key", type=click.Path(path_type=Path), help="PEM file with the certificate's private key.")
@click.option("--mavlink-key", type=click.Path(path_type=Path), help="File with the signing key of the payload.")
@click.option("--system-id", type=SYSTEM_ID, default=254, show_default=True, help="MAVLink id of this program.")
@click.option("--log", type=click.Path(path_type=Path), help="Folder for a tlog of everything received and sent.")
@click.option("--flights", type=click.Path(path_type=Path), help="Folder of recorded flights (default: that of --log).")
@click.option("--map", "map_file", type=click.Path(path_type=Path), help="MBTiles file with PNG or JPEG tiles.")
@click.option("--audio-address", default="", help="IPv4 address of this computer for the sound of payloads.")
@click.option("--open", "open_page", is_flag=True, help="Open the page in a browser.")
def command(
    *,
    urls: tuple[str, ...],
    port: int,
    host: str,
    token_file: Path | None,
    certificate: Path | None,
    key: Path | None,
    mavlink_key: Path | None,
    system_id: int,
    log: Path | None,
    flights: Path | None,
    map_file: Path | None,
    audio_address: str,
    open_page: bool,
) -> None:
    """Serve the page with the telemetry received on each URL (default: udpin:127.0.0.1:14550), until Ctrl-C."""
    from ross_payload.ground.web.app import Options, run

    folder, listened = flights or log, urls or (DEFAULT_URL,)
    options = Options(
        listened, port, host, token_file, certificate, key, mavlink_key, system_id, log, folder, open_page
    )
    run(replace(options, map=map_file, audio_address=audio_address))
