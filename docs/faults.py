"""Prints the tables of docs/reference/actuator-faults.md from what the tests demand; a test compares both.

Run it in a checkout: ``python docs/faults.py``.
"""

import inspect
import re
import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[1] / "tests" / "support"))

from detections import DETECTIONS
from monitor import tolerated
from rigs import KINDS
from ross_sim.devices.far_end import Fault

EXACTLY = """\
10,000 random sequences of goals, rates, halts, stops, homings and releases (`make soak`; a few per back end with
every test) exceed neither a limit nor a cap by more than this. "Speed" and "acceleration" are the far end's true ones,
means over 100 ms; reported ones are compared between two reports. After a release nothing is planned, so nothing is
compared until it stands still. The 220 % of steppers are the moment when their torque comes back and a rotor snaps to
its windings, at most two full steps; in planned moves the pulses themselves keep the cap. CANopen's 310 % are of what
is reported alone: its rate comes in a frame of its own.
"""
MEANING = re.compile(r'^ {4}(?P<name>[A-Z]+) = "\w+"  # (?P<about>.+)$', re.MULTILINE)


def plain(words: str) -> str:
    """A regular expression as people read it."""
    said = re.sub(r"\\(.)", r"\1", words.replace(".*", "…"))
    return " *or* ".join(f"`{part}`" for part in said.split("|"))


def faults() -> list[str]:
    """What every fault is."""
    meanings = {found["name"]: found["about"] for found in MEANING.finditer(inspect.getsource(Fault))}
    rows = [f"| `{fault.value}` | {meanings[fault.name]} |" for fault in Fault]
    return ["| fault | what happens to the device |", "| --- | --- |", *rows, ""]


def detections() -> list[str]:
    """Within which time every back end notices, and in which words."""
    lines = ["| back end | fault | noticed within [s] | in words with |", "| --- | --- | --- | --- |"]
    for kind in sorted({kind for kind, _ in DETECTIONS}):
        for fault in Fault:
            if (kind, fault) in DETECTIONS:
                row = DETECTIONS[kind, fault]
                seen = "- | only the mission notices" if row is None else f"{row.within:g} | {plain(row.words)}"
                lines.append(f"| `{kind}` | `{fault.value}` | {seen} |")
    return [*lines, ""]


def tolerances() -> list[str]:
    """By how much the truth may exceed what is allowed."""
    lines = [
        "| back end | beyond a limit [deg] | speed [deg/s] | acceleration | reported: speed [deg/s] | acceleration |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for kind in KINDS:
        most = tolerated(kind)
        true = f"{most.angle_deg:g} | {most.speed_deg_s:g} | {most.acceleration:.0%}"
        lines.append(f"| `{kind}` | {true} | {most.report_deg_s:g} | {most.report_acceleration:.0%} |")
    return [*lines, ""]


def tables() -> str:
    """All tables, each behind its heading."""
    parts = ["## The faults\n", *faults(), "## Which component detects which fault\n", *detections()]
    return "\n".join([*parts, "## Accuracy of limits and caps\n", EXACTLY, *tolerances()])


if __name__ == "__main__":
    sys.stdout.write(tables())
