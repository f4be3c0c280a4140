"""Findings on a terminal, or for machines."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from typing import Any

import click

from ross_payload.doctor.finding import Finding, worst
from ross_payload.doctor.probe import Results
from ross_payload.terminal import listed

COLOURS = {"ok": "green", "warn": "yellow", "fail": "red"}


def shown(finding: Finding) -> None:
    """Print one finding, and what to do about it."""
    verdict = finding.verdict
    line = listed(f"{verdict:<5} {finding.check:<12} ", finding.found)
    click.echo(click.style(line[:5], fg=COLOURS[verdict]) + line[5:])
    if finding.todo:
        click.echo(listed(f"{'':<18} -> ", finding.todo))


def as_text(findings: list[Finding], results: Results) -> str:
    """Return findings and figures as JSON; what is not known is null."""
    figures = {"verdict": worst(findings), "checks": [asdict(finding) for finding in findings]}
    return json.dumps(figures | {"figures": _plain(asdict(results))}, indent=2)


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    return None if isinstance(value, float) and not math.isfinite(value) else value
