"""A computer that is a folder and a table of what its programs print."""

from ross_payload.config import Config, validated
from ross_payload.doctor.findings import worst
from ross_payload.doctor.machine import Machine

DEVICE = "serial:/dev/ttyUSB0:115200"
FAST = {"explore": {"unit_s": 0.5, "min_rotations": 1}, "exploit": {"separator": "duet", "run_s": 1}}


def config(**tables):
    return validated(Config, tables, "test")


def machine(root, programs=None, **other):
    """A computer with nothing but a root folder; programs that are not named are not installed."""
    answers = {} if programs is None else programs
    return Machine(root=root, environment={"HOME": str(root)}, run=lambda words: answers.get(words[0]), **other)


def put(root, where, text=""):
    path = root / where.lstrip("/")
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


def said(findings):
    """The worst verdict and everything that was found, in one text."""
    findings = list(findings)
    return worst(findings), "\n".join(f"{each.found} -> {each.todo}" for each in findings)
