"""The reference page of `ross study` lists every key, column and preset as the code has them."""

import json
from pathlib import Path

import pytest

from ross_sim.study.benchmark.benchmark_rows import BenchmarkLocalization, BenchmarkSeparation
from ross_sim.study.page_tables import MAKERS
from ross_sim.study.rows.calibration_rows import CalibrationRow
from ross_sim.study.rows.exploration_ends import EndRow, SigmaRow
from ross_sim.study.rows.layout_gains import GainRow
from ross_sim.study.rows.mission_rows import MissionRow
from ross_sim.study.rows.motion_rows import MotionRow
from ross_sim.study.rows.result_rows import Exploration, Separation, Timing, columns
from ross_sim.study.runs.mission_design import MissionStudy
from ross_sim.study.runs.study_design import PRESETS, Study, chosen, tasks
from ross_sim.study.scenes.room_settings import SETTINGS

PAGE = (Path(__file__).parents[3] / "docs" / "reference" / "study.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", Study.model_fields)
def test_every_key_is_listed_with_its_default(name):
    assert f"| `{name}` | `{json.dumps(Study.model_fields[name].default)}` |" in PAGE


@pytest.mark.parametrize("name", MissionStudy.model_fields)
def test_every_key_of_a_study_of_missions_is_listed(name):
    assert f"| `{name}` |" in PAGE.split("## Missions")[1]


def test_every_table_of_rows_is_listed():
    section = PAGE.split("## Tables of a page")[1]
    assert [name for made in MAKERS.values() for name in made if f"`{name}`" not in section] == []


TITLES = {
    Separation: "separations",
    Exploration: "explorations",
    GainRow: "gains",
    EndRow: "ends",
    SigmaRow: "sigmas",
    MotionRow: "motions",
    Timing: "timing",
    MissionRow: "missions",
    CalibrationRow: "calibrations",
}


@pytest.mark.parametrize(("kind", "title"), TITLES.items(), ids=TITLES.values())
def test_every_column_is_listed(kind, title):
    section = PAGE.split(f"### Columns of `{title}`")[1].split("##")[0]
    assert [name for name in columns(kind) if f"`{name}`" not in section] == []


@pytest.mark.parametrize("kind", [BenchmarkSeparation, BenchmarkLocalization])
def test_every_column_of_the_benchmark_is_listed(kind):
    title = {BenchmarkSeparation: "separation", BenchmarkLocalization: "localization"}[kind]
    section = PAGE.split(f"### Columns of the benchmark's `{title}.csv`")[1].split("##")[0]
    assert [name for name in columns(kind) if f"`{name}`" not in section] == []


@pytest.mark.parametrize("name", PRESETS)
def test_every_preset_is_listed_with_its_number_of_tasks(name):
    (line,) = (line for line in PAGE.splitlines() if line.startswith(f"| `{name}` |"))
    assert line.endswith(f"| {len(tasks(chosen(name, {}, False)))} |")


def test_every_room_is_listed():
    assert [name for name in SETTINGS if f"`{name}`" not in PAGE] == []
