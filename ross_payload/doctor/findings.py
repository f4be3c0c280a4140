"""What a check says, and how it is printed for people or machines."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any

import click

from ross_payload.terminal_tables import listed

COLOURS = {"ok": "green", "warn": "yellow", "fail": "red"}


class Verdict(StrEnum):
    """How bad it is."""

    OK = "ok"
    WARN = "warn"  # it will run, and not as well as it could
    FAIL = "fail"  # it will not run, or not safely


@dataclass(frozen=True, slots=True)
class Finding:
    """One line: what was looked at, what was found, and what to do about it."""

    check: str
    verdict: Verdict
    found: str
    todo: str = ""


def ok(check: str, found: str) -> Finding:
    """Say that all is well."""
    return Finding(check, Verdict.OK, found)


def warn(check: str, found: str, todo: str) -> Finding:
    """Say what could be better."""
    return Finding(check, Verdict.WARN, found, todo)


def fail(check: str, found: str, todo: str) -> Finding:
    """Say what must be mended."""
    return Finding(check, Verdict.FAIL, found, todo)


def worst(findings: Iterable[Finding]) -> Verdict:
    """Return the worst verdict.

    >>> worst([ok("a", "fine"), warn("b", "hot", "cool it")]).value
    'warn'
    """
    return max((finding.verdict for finding in findings), key=list(Verdict).index, default=Verdict.OK)


def print_finding(finding: Finding) -> None:
    """Print one finding, and what to do about it."""
    verdict = finding.verdict
    line = listed(f"{verdict:<5} {finding.check:<12} ", finding.found)
    click.echo(click.style(line[:5], fg=COLOURS[verdict]) + line[5:])
    if finding.todo:
        click.echo(listed(f"{'':<18} -> ", finding.todo))


def as_json(findings: Sequence[Finding], **more: Any) -> str:
    """Return the worst verdict, all findings and what else there is as JSON."""
    return json.dumps(
        {"verdict": worst(findings), "checks": [asdict(finding) for finding in findings]} | more, indent=2
    )
