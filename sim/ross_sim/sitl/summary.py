"""The end of a simulated mission, for a person: tables on the terminal, or JSON for machines."""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

import click
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from ross_payload.terminal_tables import with_whole_words
from ross_protocols.angle_text import frame, rounded
from ross_sim.sitl.mission_session import Finished


def taken_for_target(report: Mapping[str, Any], voices: Collection[str]) -> str:
    """Say whose voice the payload delivered as the target's in truth; empty when it is the target's, or nobody knows.

    Parameters
    ----------
    report
        Of the mission.
    voices
        The names of all voices of the simulation: an enrolled voice of another name may be anybody's.

    >>> group = {"target": True, "talkers": ["bella"]}
    >>> report = {"outcome": "target_found", "target": "arthur", "groups": [group]}
    >>> taken_for_target(report, ["arthur", "bella"]), taken_for_target(report, ["bella"])
    ('bella', '')
    """
    delivered = next((group["talkers"] for group in report["groups"] if group["target"]), None)
    known = report["outcome"] == "target_found" and report["target"] in voices
    if not known or delivered is None or report["target"] in delivered:
        return ""
    return " and ".join(delivered) or "nobody"


def show(
    finished: Finished, out: Path | None, as_json: bool, console: Console | None = None, mistaken: str = ""
) -> None:
    """Print what was found and what it gained, on standard output when no console is given.

    ``mistaken`` is who was taken for the target, as of `taken_for_target`.
    """
    if as_json:
        click.echo(json.dumps(finished.report | {"timing": finished.timing}, indent=2))
        return
    console = console or Console()
    values = finished.report
    console.print()
    console.print(_sources(values))
    _elevated(console, values)
    _missed(console, values)
    if values["alignment"] and values["alignment"]["used"]:
        _aligned(console, values["alignment"]["used"], _frame(values))
    if values["groups"]:
        console.print()
        console.print(_groups(values))
    for complaint in finished.complaints:
        console.print(f"hardware: {complaint}", style="red", markup=False)
    timing = finished.timing
    wrong = f" (wrong: it is {mistaken})" if mistaken else ""
    console.print(
        f"\n{values['outcome'].replace('_', ' ')}: {values['reason']}{wrong}. "
        f"{values['mission_s'] or 0:.1f} s simulated in "
        f"{timing['mission_s']:.1f} s, {times(timing['times_real_time'])} real time.",
        highlight=False,
        soft_wrap=True,
    )
    if out is not None:
        told = {"listen": ("mixture.wav", "target.wav"), "look": ("mission.png",)}
        there = {verb: ", ".join(name for name in names if (out / name).exists()) for verb, names in told.items()}
        what = "; ".join(f"{verb}: {names}" for verb, names in there.items() if names)
        console.print(f"Results: {out}/ ({what})", highlight=False, soft_wrap=True)


def _sources(values: dict[str, Any]) -> Table:
    how = "sources given" if values["informed"] else f"found after {values['rotations']} rotations"
    caption = f"azimuths in degrees, clockwise {_frame(values)}"
    table = Table(title=f"K = {values['k']} {how}, {values['k_true']} true", title_justify="left", caption=caption)
    for column in ("source", "talker", "true", "found", "error", "sigma", "confidence"):
        table.add_column(column, justify="left" if column == "talker" else "right")
    for index, row in enumerate(values["sources"]):
        table.add_row(
            str(index),
            _target(row["name"], values["target"]),
            _bearing(row["azimuth_true_deg"]),
            _bearing(row["azimuth_deg"]),
            _number(_clockwise(row["azimuth_error_deg"]), 2),
            _number(row["sigma_deg"], 2),
            _number(row["confidence"], 2),
        )
    return with_whole_words(table)


def _elevated(console: Console, values: dict[str, Any]) -> None:
    told = [
        f"source {index} {row['elevation_deg']:.1f} (true {_number(row['elevation_true_deg'], 1)})"
        for index, row in enumerate(values["sources"])
        if row["elevation_deg"] is not None
    ]
    if told:
        console.print(f"elevation [deg]: {', '.join(told)}", markup=False, highlight=False, soft_wrap=True)


def _missed(console: Console, values: dict[str, Any]) -> None:
    for row in values["missed"]:
        where = f"{_bearing(row['azimuth_true_deg'])} deg {_frame(values)}"
        console.print(f"missed: {row['name']} at {where}", style="yellow", markup=False)


def _aligned(console: Console, used: dict[str, Any], frame_text: str) -> None:
    aliased = " and ".join(str(index) for index in used["aliased"])
    where = f"{_bearing(used['heading_deg'])} deg {frame_text}"
    text = f"aligned at heading {where} for source {used['source']} ({used['rule']})"
    console.print(text + (f": sources {aliased} share one delay" if aliased else ""), highlight=False, soft_wrap=True)


def _groups(values: dict[str, Any]) -> Table:
    first = values["groups"][0]
    title = f"separated by {first['separator']}; SI-SDR in dB"
    table = Table(title=title, title_justify="left", caption=first["why"] or None)
    for column in ("group", "talkers", "voice score", "SI-SDR before", "after", "gain"):
        table.add_column(column, justify="left" if column == "talkers" else "right")
    for index, row in enumerate(values["groups"]):
        after, gain = row["si_sdr_db"], row["si_sdri_db"]
        before = None if after is None or gain is None else after - gain
        names = " + ".join(_target(name, values["target"]) for name in row["talkers"])
        style = "bold" if row["target"] else None
        table.add_row(
            str(index), names, _number(row["score"], 1), _number(before, 1), _number(after, 1), _number(gain, 1),
            style=style,
        )  # fmt: skip
    return with_whole_words(table)


def _target(name: str | None, target: str) -> str:
    return "-" if name is None else escape(f"{name} (target)" if name == target else name)


def _frame(values: dict[str, Any]) -> str:
    return frame(values["frame"] == "earth")


def _clockwise(degrees: float | None) -> float | None:
    """Turn an angle of the report, which is counter-clockwise, around."""
    return None if degrees is None else 0.0 - degrees


def _bearing(degrees: float | None) -> str:
    return "-" if degrees is None else f"{rounded(-degrees):.1f}"


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"


def times(ratio: float) -> str:
    """Return a ratio in words; below 10 with two digits, for a slow computer.

    >>> times(20.3), times(6.05), times(0.271)
    ('20 times', '6 times', '0.27 times')
    """
    return f"{ratio:.0f} times" if ratio >= 10 else f"{ratio:.2g} times"
