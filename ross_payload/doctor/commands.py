"""``ross doctor`` examines this computer for a configuration; ``ross actuators`` lists and probes what can turn."""

from __future__ import annotations

from pathlib import Path

import click

DOCTOR_EPILOG = "Exit codes: 0 it will run, perhaps with warnings; 2 something must be fixed first, or bad input."
EXIT_CODES = {"ok": 0, "warn": 1, "fail": 2}
PROBE_EPILOG = """Ctrl-C stops it at any moment. Exit codes: 0 no problems, 1 with warnings, 2 something must be fixed
or bad input, 130 stopped by the user."""


@click.command("doctor", short_help="Check whether this computer can run a configuration.", epilog=DOCTOR_EPILOG)
@click.argument("config", type=click.Path(path_type=Path))
@click.option("--json", is_flag=True, help="Print JSON.")
def doctor_command(config: Path, json: bool) -> int:
    """Check devices, permissions, links, clock, disk and speed for a payload's TOML file CONFIG; nothing moves.

    Run it as the user of the service, while the service is stopped: ports in use are found, and so is a folder that
    this user may not write.
    """
    from ross_payload.clock import SystemClock
    from ross_payload.config import load
    from ross_payload.doctor.examination import examine
    from ross_payload.doctor.findings import Finding, Verdict, as_json, print_finding, worst
    from ross_payload.doctor.machine import Machine

    settings, findings = load(config), list[Finding]()
    for finding in examine(settings, Machine(), SystemClock()):
        findings.append(finding)
        if not json:
            print_finding(finding)
    if json:
        click.echo(as_json(findings))
    return 2 if worst(findings) is Verdict.FAIL else 0


@click.group("actuators", invoke_without_command=True, short_help="List the actuator back ends, or probe one.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@click.pass_context
def actuators_command(context: click.Context, as_json: bool) -> None:
    """List the actuator back ends and whether they can be used here."""
    if context.invoked_subcommand is not None:
        return
    import json

    from ross_payload.actuators.registry import describe
    from ross_payload.terminal_tables import listed

    rows = describe()
    if as_json:
        click.echo(json.dumps([{"name": row.name, "usable": row.usable, "about": row.about} for row in rows]))
        return
    for row in rows:
        click.echo(listed(f"{row.name:<16} {'usable' if row.usable else 'not usable':<11} ", row.about))


@actuators_command.command(
    "probe", short_help="Check the actuator: do this first with new hardware.", epilog=PROBE_EPILOG
)
@click.argument("config", type=click.Path(path_type=Path))
@click.option("--move", is_flag=True, help="Also turn it by 5 deg and back, slowly, after a confirmation.")
@click.option("--home", is_flag=True, help="Also have it find or declare its zero; it may turn.")
@click.option("--yes", is_flag=True, help="Do not ask for confirmation.")
@click.option("--json", is_flag=True, help="Print JSON.")
def probe_command(*, config: Path, move: bool, home: bool, yes: bool, json: bool) -> int:
    """Open the actuator of a payload's TOML file CONFIG and show what it is, what it reports, and how well it moves.

    Nothing moves without --move or --home. Everything passes the guard of the configuration. Run it while the payload
    is not running.
    """
    from contextlib import closing

    from ross_payload.config import load
    from ross_payload.doctor.findings import as_json, print_finding, worst
    from ross_payload.doctor.probe import Results, Wishes, open_services, probe

    settings, results, findings = load(config), Results(), []
    question = "It will turn by 5 deg and back, twice, slowly. Is the way free?"
    wishes = Wishes(home, (lambda: yes or click.confirm(question, err=True)) if move else None)
    with open_services(settings) as services, closing(probe(settings, services, wishes, results)) as steps:
        for finding in steps:
            findings.append(finding)
            if not json:
                print_finding(finding)
    if json:
        click.echo(as_json(findings, figures=results.as_values()))
    return EXIT_CODES[worst(findings)]
