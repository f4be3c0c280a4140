"""``ross actuators``: what can turn the array, and a first look at it."""

from __future__ import annotations

from pathlib import Path

import click

CODES = {"ok": 0, "warn": 1, "fail": 2}
EPILOG = """Ctrl-C stops it at any moment. Exit codes: 0 no problems, 1 with warnings, 2 something must be fixed or bad
input, 130 stopped by the user."""


@click.group("actuators", invoke_without_command=True, short_help="List the actuator back ends, or probe one.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@click.pass_context
def command(context: click.Context, as_json: bool) -> None:
    """List the actuator back ends and whether they can be used here."""
    if context.invoked_subcommand is not None:
        return
    import json

    from ross_payload.actuators.registry import describe
    from ross_payload.terminal import listed

    rows = describe()
    if as_json:
        click.echo(json.dumps([{"name": row.name, "usable": row.usable, "about": row.about} for row in rows]))
        return
    for row in rows:
        click.echo(listed(f"{row.name:<16} {'usable' if row.usable else 'not usable':<11} ", row.about))


@command.command("probe", short_help="Check the actuator: do this first with new hardware.", epilog=EPILOG)
@click.argument("config", type=click.Path(path_type=Path))
@click.option("--move", is_flag=True, help="Also turn it by 5 deg and back, slowly, after a confirmation.")
@click.option("--home", is_flag=True, help="Also have it find or declare its zero; it may turn.")
@click.option("--yes", is_flag=True, help="Do not ask for confirmation.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def probe_command(*, config: Path, move: bool, home: bool, yes: bool, as_json: bool) -> int:
    """Open the actuator of a payload's TOML file CONFIG and tell what it is, what it reports, and how well it moves.

    Nothing moves without --move or --home. Everything passes the guard of the configuration. Run it while the payload
    is not running.
    """
    from contextlib import closing

    from ross_payload.config import load
    from ross_payload.doctor.finding import worst
    from ross_payload.doctor.probe import Results, Wishes, probe
    from ross_payload.doctor.show import as_text, shown
    from ross_payload.doctor.wired import wired

    settings, results, findings = load(config), Results(), []
    wishes = Wishes(home, lambda: move and (yes or _agreed()))
    with wired(settings) as services, closing(probe(settings, services, wishes, results)) as said:
        for finding in said:
            findings.append(finding)
            if not as_json:
                shown(finding)
    if as_json:
        click.echo(as_text(findings, results))
    return CODES[worst(findings)]


def _agreed() -> bool:
    return click.confirm("It will turn by 5 deg and back, twice, slowly. Is the way free?", err=True)
