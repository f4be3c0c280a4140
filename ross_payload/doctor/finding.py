"""What a check says."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum


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
