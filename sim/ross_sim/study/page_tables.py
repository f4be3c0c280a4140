"""Tables of a page of the manual, written from rows: a mark in the page names the rows and the table.

.. code-block:: markdown

    <!-- rows: rows/missions.csv, table: missions -->
    | ... |
    <!-- rows: end -->

The path counts from the page. What stands between the marks is written by `ross study table ROWS --into PAGE` alone.
"""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from ross_payload.atomic_files import replacing
from ross_payload.bounded_files import read_bounded
from ross_payload.errors import ConfigError, OutputError, refused_as, unknown
from ross_sim.study.benchmark.benchmark_rows import (
    BenchmarkLocalization,
    BenchmarkSeparation,
    localization_table,
    separation_table,
)
from ross_sim.study.rows import live_tables
from ross_sim.study.rows.above_rows import AboveRow, above
from ross_sim.study.rows.calibration_rows import CalibrationRow, calibrations
from ross_sim.study.rows.cost_rows import CostRow, costs, growth
from ross_sim.study.rows.elevation_rows import ElevationRow, below
from ross_sim.study.rows.exploration_ends import STOP, EndRow, SigmaRow, end_rows
from ross_sim.study.rows.exploration_tables import counts, finds, reliability, sigmas
from ross_sim.study.rows.heading_rows import HeadingRow, headings
from ross_sim.study.rows.headroom_rows import HeadroomRow, headroom
from ross_sim.study.rows.layout_gains import GainRow, gain_rows
from ross_sim.study.rows.long_run_rows import ListeningMinute, PageRun, PayloadRun, endurance, listening, page_runs
from ross_sim.study.rows.mission_rows import MissionRow
from ross_sim.study.rows.mission_table import missions
from ross_sim.study.rows.motion_rows import MotionRow, motions
from ross_sim.study.rows.moving_rows import MovingRow, moving
from ross_sim.study.rows.noise_rows import NoiseRow, noises
from ross_sim.study.rows.promptness_rows import PulseRow, StopRow, answers, pulses, stops
from ross_sim.study.rows.resting_rows import RestingRow, resting
from ross_sim.study.rows.result_rows import Exploration, Separation
from ross_sim.study.rows.row_files import read_rows
from ross_sim.study.rows.rtp_rows import NetworkRow, PlayerRow, networks, players
from ross_sim.study.rows.separation_tables import gains, losses
from ross_sim.study.rows.tables import Table
from ross_sim.study.rows.voice_print_rows import VoicePrintRow, voice_prints

BLOCK = re.compile(
    r"(<!-- rows: (?P<rows>[^,>]+), table: (?P<table>\S+) -->(?P<end>\r?\n)).*?(<!-- rows: end -->)", re.DOTALL
)
Maker = Callable[[Sequence[Any]], str]


def _ends(rows: Sequence[Exploration]) -> list[EndRow]:
    """Where explorations end after the last rotation, and where the explorer stops."""
    return end_rows((max(row.rotations for row in rows), STOP), rows)


def _bodies(
    makers: Mapping[str, Callable[[Any], Table]], ready: Callable[[Any], Any] = lambda rows: rows
) -> dict[str, Maker]:
    """What makes Markdown of rows, which ``ready`` turns into those that the tables are made of."""

    def body(make: Callable[[Any], Table], rows: Sequence[Any]) -> str:
        return make(ready(rows)).body()

    return {name: partial(body, make) for name, make in makers.items()}


FOUND: dict[str, Callable[[Any], Table]] = {"finds": finds, "counts": counts, "reliability": reliability}
GAINED: dict[str, Callable[[Any], Table]] = {"gains": gains, "losses": losses}
MAKERS: dict[type[Any], dict[str, Maker]] = {
    MissionRow: _bodies({"missions": missions}),
    Separation: _bodies(GAINED, gain_rows),
    GainRow: _bodies(GAINED),
    Exploration: _bodies(FOUND, _ends),
    EndRow: _bodies(FOUND),
    SigmaRow: _bodies({"sigmas": sigmas}),
    MotionRow: _bodies({"motions": motions}),
    CalibrationRow: _bodies({"calibrations": calibrations}),
    NoiseRow: _bodies({"noises": noises}),
    AboveRow: _bodies({"above": above}),
    RestingRow: _bodies({"resting": resting}),
    MovingRow: _bodies({"moving": moving}),
    ElevationRow: _bodies({"below": below}),
    HeadingRow: _bodies({"headings": headings}),
    CostRow: _bodies({"costs": costs, "growth": growth}),
    VoicePrintRow: _bodies({"voice-prints": voice_prints}),
    HeadroomRow: _bodies({"headroom": headroom}),
    PlayerRow: _bodies({"players": players}),
    NetworkRow: _bodies({"networks": networks}),
    StopRow: _bodies({"stops": stops, "answers": answers}),
    PulseRow: _bodies({"pulses": pulses}),
    PayloadRun: _bodies({"endurance": endurance}),
    ListeningMinute: _bodies({"listening": listening}),
    PageRun: _bodies({"page-runs": page_runs}),
    live_tables.Row: {"live": live_tables.tables},
    BenchmarkSeparation: _bodies({"benchmark-separation": separation_table}),
    BenchmarkLocalization: _bodies({"benchmark-localization": localization_table}),
}


def tables_of(path: Path) -> dict[str, str]:
    """Every table that the rows of a file give, as Markdown, by name.

    Raises
    ------
    ConfigError
        When there are no rows of a study.
    """
    kind, rows = read_rows(path, list(MAKERS))
    if not rows:
        raise ConfigError(f"{path}: expected rows, got none")
    return {name: make(rows) for name, make in MAKERS[kind].items()}


def with_tables(page: Path, rows: Path | None = None) -> str:
    """The text of a page with its tables made again: those of the file ``rows``, None: of every file that it names.

    Raises
    ------
    ConfigError
        When the page cannot be read or has no marks of these rows, or a mark names no table of its rows.
    """
    try:
        text = read_bounded(page).decode("utf-8")
    except OSError as error:
        raise ConfigError(f"{page}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise ConfigError(f"{page}: expected UTF-8 text, got other bytes") from error
    wanted = None if rows is None else rows.resolve()
    named = [(page.parent / block["rows"]).resolve() for block in BLOCK.finditer(text)]
    if wanted is not None and wanted not in named:
        raise ConfigError(f"{page}: expected a mark '<!-- rows: FILE, table: NAME -->' for {rows}, got none")
    return BLOCK.sub(partial(_written, page, wanted), text)


def _written(page: Path, wanted: Path | None, block: re.Match[str]) -> str:
    there = (page.parent / block["rows"]).resolve()
    if wanted is not None and there != wanted:
        return block[0]
    made = tables_of(there)
    if block["table"] not in made:
        raise ConfigError(f"{page}: {unknown('table', block['table'], made)}")
    table = f"{made[block['table']]}\n".replace("\n", block["end"])
    return f"{block[1]}{table}{block[5]}"


def write_page(page: Path, rows: Path | None = None) -> None:
    """Make the tables of a page again, whole or not at all: see `with_tables`. Links and the mode stay.

    Raises
    ------
    OutputError
        When it cannot be written.
    """
    text = with_tables(page, rows)
    with refused_as(OutputError, f"{page}: cannot be written"), replacing(page.resolve()) as path:
        path.write_bytes(text.encode())
        shutil.copymode(page, path)
