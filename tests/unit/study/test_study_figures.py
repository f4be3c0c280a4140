"""Figures and tables of a study, from rows whose means are known."""

from dataclasses import replace

import matplotlib.image
import numpy as np
import pytest

from ross_sim.study.rows.exploration_ends import end_rows
from ross_sim.study.rows.exploration_tables import finds
from ross_sim.study.rows.figures import draw
from ross_sim.study.rows.layout_gains import gain_rows
from ross_sim.study.rows.result_rows import Exploration, Separation
from ross_sim.study.rows.separation_tables import gains, losses

pytestmark = pytest.mark.lockstep

GAINS = {"aligned": 12.0, "estimated": 11.0, "unaligned": 6.0}
SETTINGS, COUNTS, SEPARATORS = ("S1", "S2", "S3"), (3, 4), ("duet", "gaussian")


def separations():
    blank = Separation("t", "S1", 3, 0, 0, "0.1", "aligned", 0, "anna", 170.0)
    for setting in SETTINGS:
        for k in COUNTS:
            for separator in SEPARATORS:
                for how, gain in GAINS.items():
                    for start in range(1 if how == "aligned" else 4):
                        row = replace(blank, setting=setting, k=k, separator=separator, how=how, si_sdri_db=gain - k)
                        if how != "aligned":
                            row = replace(row, start=start, start_heading_deg=45.0 * start)
                        if how == "estimated":
                            row = replace(row, explorer="joint", unit_s=3.0, schedule="4", rotations=4, all_found=True)
                        yield row
    lost = replace(blank, separator="duet", how="estimated", explorer="joint", unit_s=3.0, schedule="4", rotations=4)
    yield replace(lost, start=0, start_heading_deg=0.0, all_found=False, missed=True)


def explorations():
    for setting in SETTINGS:
        for explorer in ("joint", "markov"):
            for r in range(5):
                found = (170.0, 70.0 + r, -50.0)[: 3 if r else 2]
                errors = (0.0, float(r), 0.0 if r else 180.0)
                yield Exploration(
                    f"{setting}-{explorer}", setting, 3, 0, 0, "0.1", 0, 0.0, explorer, 3.0, r, 15.0 * r,
                    ("anna", "ben", "cleo"), (170.0, 70.0, -50.0), found, tuple(1.0 for _ in found),
                    tuple(0.9 for _ in found), errors, len(found), bool(r), r >= 3, None,
                )  # fmt: skip


def rows_to_draw():
    """Those of two settings, one K and one separator: several pictures in every figure, and as few as will do."""
    return (
        [row for row in separations() if row.setting != "S2" and row.k == 3 and row.separator == "gaussian"],
        [row for row in explorations() if row.setting != "S2"],
    )


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    folder = tmp_path_factory.mktemp("figures")
    return folder, draw(folder, *rows_to_draw())


@pytest.mark.soak
def test_there_are_three_kinds_of_figures_each_twice(drawn):
    folder, names = drawn
    expected = {"aoa", "orientation-gaussian", "methods"}
    assert set(names) == {f"{name}.{suffix}" for name in expected for suffix in ("pdf", "png")}
    assert set(names) == {path.name for path in folder.iterdir()}


@pytest.mark.soak
def test_figures_have_ink_and_still_have_it_in_grey(drawn):
    folder, names = drawn
    for name in names:
        if name.endswith(".png"):
            grey = matplotlib.image.imread(folder / name)[..., :3].mean(axis=-1)
            assert 0.01 < np.mean(grey < 0.5) < 0.6, name
        else:
            assert (folder / name).read_bytes().startswith(b"%PDF")


@pytest.mark.soak
def test_a_study_that_does_not_explore_has_no_figure_of_azimuths_and_the_same_bytes_every_time(tmp_path):
    rows = [row for row in separations() if row.how == "aligned"]
    once, again = tmp_path / "once", tmp_path / "again"
    for folder in (once, again):
        folder.mkdir()
        assert draw(folder, rows, []) == ["methods.pdf", "methods.png"]
    for path in once.iterdir():
        assert (again / path.name).read_bytes() == path.read_bytes(), path.name
    assert draw(tmp_path, [], []) == []


def test_means_count_a_missed_target_as_zero():
    rows = gain_rows(separations())
    assert gains(rows).rows[0] == ("S1, K = 3", "9.0 / 8.0 / 6.4 / 3.0", "9.0 / 8.0 / 8.0 / 3.0")  # (4 x 8 + 0) / 5
    assert losses(rows).rows[0] == ("S1, K = 3, joint, 3 s, 4", "0.89", "1.00", "1.00")  # 8 of 9 rows


def test_a_mean_is_that_of_all_targets_and_its_interval_that_of_the_layouts():
    blank = Separation("t", "S1", 3, 0, 0, "0.1", "aligned", 0, "anna", 170.0, separator="duet")
    found = [(0, 9.0), (0, 11.0), (1, 12.0), (1, 14.0), (2, 16.0)]
    (line,) = gains(gain_rows(replace(blank, layout=layout, si_sdri_db=gain) for layout, gain in found)).rows
    assert line == ("S1, K = 3", "12.4 ± 7.5 / -")  # 10, 13 and 16 dB: 3 dB times 4.303 over the root of 3


def test_explorations_step_by_step_and_without_a_pause_are_told_apart():
    blank = Separation("t", "S1", 3, 0, 0, "0.1", "aligned", 0, "anna", 170.0, separator="duet", si_sdri_db=9.0)
    there = replace(blank, how="estimated", start=0, explorer="joint", unit_s=3.0, schedule="4", all_found=True)
    turning = replace(there, turning_deg_s=20.0, si_sdri_db=6.0)
    assert losses(gain_rows([blank, there, turning])).rows == (
        ("S1, K = 3, joint, 3 s, 4", "1.00", "0.00"),
        ("S1, K = 3, joint, 3 s, 20 deg/s, 4", "1.00", "3.00"),
    )


def test_the_explorers_table_follows_schedules_and_the_stop_rule():
    rows = {row[0]: row[1:] for row in finds(end_rows((2, 4, "stop"), explorations())).rows}
    assert rows["S1, joint, 3 s, 2"] == ("2.0", "1.00", "1/1 (21-100 %)", "1.000", "0.67", "1/1")
    assert rows["S1, joint, 3 s, stop"][0] == "3.0"
    assert rows["S3, markov, 3 s, 4"][4] == "1.33"


def test_tables_are_markdown_with_as_many_cells_in_every_line():
    rows = gain_rows(separations())
    for table in (gains(rows), losses(rows), finds(end_rows((4,), explorations()))):
        lines = [line for line in table.markdown().splitlines() if line.startswith("|")]
        assert len(lines) == len(table.rows) + 2
        assert len({line.count("|") for line in lines}) == 1
        assert table.screen().row_count == len(table.rows)
