"""``ross doctor``: examine this computer for a configuration."""

from __future__ import annotations

from pathlib import Path

import click

EPILOG = "Exit codes: 0 it will run, perhaps with warnings; 2 something must be fixed first, or bad input."


@click.command("doctor", short_help="Can this computer run a configuration? What to do if not.", epilog=EPILOG)
@click.argument("config", type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(config: Path, as_json: bool) -> int:
    """Check devices, permissions, links, clock, disk and speed for a payload's TOML file CONFIG; nothing moves.

    Run it as the user of the service, while the service is stopped: ports in use are found, and so is a folder that
    this user may not write.
    """
    import json
    from dataclasses import asdict

    from ross_payload.clock import SystemClock
    from ross_payload.config import load
    from ross_payload.doctor.examine import examine
    from ross_payload.doctor.finding import Finding, Verdict, worst
    from ross_payload.doctor.machine import Machine
    from ross_payload.doctor.show import shown

    settings, findings = load(config), list[Finding]()
    for finding in examine(settings, Machine(), SystemClock()):
        findings.append(finding)
        if not as_json:
            shown(finding)
    verdict = worst(findings)
    if as_json:
        click.echo(json.dumps({"verdict": verdict, "checks": [asdict(finding) for finding in findings]}, indent=2))
    return 2 if verdict is Verdict.FAIL else 0
