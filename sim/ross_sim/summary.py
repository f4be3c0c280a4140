"""The end of a simulated mission, for a person: tables on the terminal, or JSON for machines."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from ross_payload.terminal import with_whole_words
from ross_sim.session import Finished


def show(finished: Finished, out: Path | None, as_json: bool) -> None:
    """Print what was found and what it gained."""
    if as_json:
        click.echo(json.dumps(finished.report | {"timing": finished.timing}, indent=2))
        return
    console = Console()
    values = finished.report
    console.print()
    console.print(_sources(values))
    _elevated(console, values)
    _missed(console, values)
    if values["alignment"] and values["alignment"]["used"]:
        _aligned(console, values["alignment"]["used"])
    if values["groups"]:
        console.print()
        console.print(_groups(values))
    for complaint in finished.complaints:
        console.print(f"hardware: {complaint}", style="red", markup=False)
    timing = finished.timing
    console.print(
        f"\n{values['outcome'].replace('_', ' ')}: {values['reason']}. {values['mission_s'] or 0:.1f} s of mission in "
        f"{timing['mission_s']:.1f} s, {timing['times_real_time']:.0f} times real time.",
        highlight=False,
        soft_wrap=True,
    )
    if out is not None:
        console.print(
            f"Results: {out}/ (listen: mixture.wav, target.wav; look: mission.png)", highlight=False, soft_wrap=True
        )


def _sources(values: dict[str, Any]) -> Table:
    how = "sources given" if values["informed"] else f"found after {values['rotations']} rotations"
    title = f"K = {values['k']} {how}, {values['k_true']} true"
    table = Table(title=title, title_justify="left")
    for column in ("source", "talker", "true [deg]", "found [deg]", "error [deg]", "sigma [deg]", "confidence"):
        table.add_column(escape(column), justify="left" if column == "talker" else "right")
    for index, row in enumerate(values["sources"]):
        table.add_row(
            str(index),
            _target(row["name"], values["target"]),
            _number(row["azimuth_true_deg"], 1),
            _number(row["azimuth_deg"], 1),
            _number(row["azimuth_error_deg"], 2),
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
        console.print(f"missed: {row['name']} at {row['azimuth_true_deg']:.1f} deg", style="yellow", markup=False)


def _aligned(console: Console, used: dict[str, Any]) -> None:
    posing = " and ".join(str(index) for index in used["aliased"])
    text = f"aligned at heading {used['heading_deg']:.1f} deg for source {used['source']} ({used['rule']})"
    console.print(text + (f": sources {posing} pose as one" if posing else ""), highlight=False, soft_wrap=True)


def _groups(values: dict[str, Any]) -> Table:
    first = values["groups"][0]
    table = Table(title=f"separated by {first['separator']}", title_justify="left", caption=first["why"] or None)
    for column in ("group", "talkers", "voice score", "SI-SDR before [dB]", "after [dB]", "gain [dB]"):
        table.add_column(escape(column), justify="left" if column == "talkers" else "right")
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


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"
