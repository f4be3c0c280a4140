"""``ross sessions``: list, check and delete what was recorded."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ross_payload.bounded_files import printable

FOLDER = click.option(
    "--folder", type=click.Path(path_type=Path), help="Folder of the sessions; default: the one that `ross run` uses."
)


@click.group("sessions", short_help="List, check and delete recorded sessions.", invoke_without_command=True)
@FOLDER
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@click.pass_context
def command(context: click.Context, folder: Path | None, as_json: bool) -> None:
    """List recorded sessions, oldest first.

    Sessions are personal data. They stay on this computer, readable by you alone, until they exceed the limits of
    the configuration ([recording]) or are deleted.
    """
    import json
    import os

    from ross_payload.errors import ConfigError, refused_as
    from ross_payload.sessions.catalog import described
    from ross_payload.sessions.session_store import SessionStore, home

    if folder is not None:
        with refused_as(ConfigError, f"--folder {folder}: cannot be read"):
            os.scandir(folder).close()
    store = SessionStore(folder or home())
    context.obj = store
    if context.invoked_subcommand is not None:
        return
    rows = [described(kept) for kept in store.with_damaged()]
    if as_json:
        keys = "name", "seconds", "bytes", "state"
        click.echo(json.dumps([{key: getattr(row, key) for key in keys} for row in rows]))
        return
    for row in rows:
        click.echo(f"{row.name:<24} {row.seconds:9.1f} s {row.bytes / 1e6:9.1f} MB  {row.state}")
    if not rows:
        click.echo(f"no sessions in {store.folder}")


@command.command("delete")
@click.argument("names", metavar="NAME...", nargs=-1, required=True)
@click.pass_obj
def delete(store: Any, names: tuple[str, ...]) -> None:
    """Delete sessions by NAME, as listed."""
    for kept in [store.find(name) for name in names]:
        store.delete(kept)
        click.echo(f"deleted {kept.path.name}")


@command.command("check")
@click.argument("folder", metavar="SESSION", type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def check(folder: Path, as_json: bool) -> None:
    """Show what the folder SESSION contains, and whether it is complete."""
    import json
    from dataclasses import asdict

    from ross_payload.json_values import finite
    from ross_payload.sessions.catalog import ended
    from ross_payload.sessions.session_reader import RecordedSession
    from ross_payload.sessions.session_store import is_running

    session = RecordedSession.open(folder)
    known, found = session.manifest, session.contents()
    state = "being recorded" if known.end is None and is_running(folder) else ended(known.end)
    if as_json:
        click.echo(json.dumps(finite({"manifest": asdict(known), "contents": asdict(found)})))
        return
    click.echo(
        printable(f"{known.kind}, {f'target voice {known.voice}' if known.voice else 'no target voice'}, {state}")
    )
    click.echo(f"{found.inputs} Inputs, {found.seconds:.2f} s, {found.orders} orders, {found.events} events")
    holes = f"{found.missing:.2f} s of it with missing samples, {found.lost} samples left out"
    click.echo(f"{found.audio:.2f} s of audio at {session.rate()} Hz, {holes}")
    for note in found.notes:
        click.echo(f"note: {note}")
    if not found.notes:
        click.echo("complete")
