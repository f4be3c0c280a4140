"""Tables of K and of the confidence, from rows whose truth is known."""

from __future__ import annotations

from dataclasses import replace

import pytest

from ross_sim.study.page_tables import tables_of
from ross_sim.study.rows.exploration_ends import EndRow, SigmaRow, end_rows, sigma_rows
from ross_sim.study.rows.exploration_tables import counts, last, reliability, sigmas
from ross_sim.study.rows.result_rows import Exploration
from ross_sim.study.rows.row_files import as_csv

TASKS = ("one", "two", "three")


def row(
    task: str, rotations: int, true: tuple[float, ...], found: tuple[float, ...], told: tuple[float, ...]
) -> Exploration:
    errors = tuple(min((abs(a - b) for b in found), default=180.0) for a in true)
    layout = TASKS.index(task)
    return Exploration(
        task, "A0.3", len(true), layout, 7, "0.1", 0, 0.0, "joint", 3.0, rotations, 0.0, tuple("abc"[: len(true)]),
        true, found, (1.0,) * len(found), told, errors, len(found), max(errors) <= 10, False, None,
    )  # fmt: skip


ROWS = [
    row("one", 1, (0.0, 90.0), (0.0,), (0.6,)),
    row("one", 2, (0.0, 90.0), (1.0, 88.0), (0.99, 0.96)),
    row("two", 2, (0.0, 90.0), (1.0, 88.0, 150.0), (0.99, 0.75, 0.3)),
    row("three", 2, (0.0, 90.0, 170.0), (1.0, 4.0, 88.0), (0.99, 0.6, 0.99)),
]


ENDS = end_rows((1, 2, "stop"), ROWS)


def test_where_nobody_was_found_no_confidence_has_a_mean() -> None:
    nobody = end_rows((1,), [row("one", 1, (0.0, 90.0), (), ())])
    assert reliability(nobody).rows == (("all", "-", "-"),)


def test_a_schedule_ends_after_so_many_rotations_or_where_the_explorer_is_certain() -> None:
    certain = [replace(ROWS[0], rotations=0), replace(ROWS[0], certain=True), ROWS[1]]
    assert [(end.schedule, end.rotations) for end in end_rows((2, "stop", 3), certain)] == [("2", 2), ("stop", 1)]
    assert [end.k_estimated for end in end_rows((2, "stop"), certain)] == [2, 1]


def test_only_the_last_rotation_counts() -> None:
    assert [one.rotations for one in last(ENDS)] == [2, 2, 2]


def test_k_is_right_in_so_many_scenes() -> None:
    cells = {line[0]: line[1:] for line in counts(ENDS).rows}
    assert [cell.split()[0] for cell in cells["all"]] == ["1/2", "1/1", "2/3"]
    assert [cell.split()[0] for cell in cells["all right"]] == ["1/2", "0/1", "1/3"]
    assert (cells["K too small"], cells["K too large"]) == (("0", "0", "0"), ("1", "0", "1"))


def test_two_sources_at_one_talker_are_one_talker_and_one_ghost() -> None:
    (end,) = end_rows((2,), ROWS[3:])
    assert dict(zip(end.confidences, end.there, strict=True)) == {0.99: True, 0.6: False}
    assert sum(end.there) == 2


def test_the_confidence_is_compared_with_what_is_there() -> None:
    cells = {line[0]: line[1:] for line in reliability(ENDS).rows}
    assert cells["0 to 0.5"] == ("0.300", "0/1 (0-79 %)")
    assert cells["0.98 to 1"][1].startswith("4/4")
    assert float(cells["all"][0]) == pytest.approx(0.821, abs=0.001)
    assert cells["all"][1].startswith("6/8")


def test_all_tables_come_from_a_file_of_rows_and_the_same_from_one_of_their_ends(tmp_path) -> None:
    rows, ends = tmp_path / "explorations.csv", tmp_path / "ends.csv"
    rows.write_bytes(as_csv(ROWS, Exploration))
    ends.write_bytes(as_csv(end_rows((2, "stop"), ROWS), EndRow))
    made = tables_of(ends)
    assert made["counts"] == counts(ENDS).body()
    assert made["reliability"] == reliability(ENDS).body()
    assert made == tables_of(rows)


def test_azimuths_are_compared_with_their_standard_deviations(tmp_path) -> None:
    told = replace(ROWS[3], sigmas_deg=(0.5, 1.0, 1.5))  # the talker at 170 has no source: 82 deg are no error
    again = replace(ROWS[1], sigmas_deg=(1.0, 0.5), setting="B0.3")
    made = sigma_rows((1, 2), [ROWS[0], again, told])
    assert [(row.rotations, row.errors_deg, row.sigmas_deg) for row in made] == [
        (1, (0.0,), (1.0,)),
        (2, (1.0, 2.0), (1.0, 0.5)),
        (2, (1.0, 2.0), (0.5, 1.5)),
    ]
    cells = {line[0]: [cell.split()[0] for cell in line[1:]] for line in sigmas(made).rows}
    assert cells == {
        "B0.3": ["2", "1.5", "0.8", "1/2", "1/2"],
        "A0.3": ["2", "1.5", "1.0", "0/2", "2/2"],
        "all": ["4", "1.5", "0.8", "1/4", "3/4"],
    }
    (tmp_path / "sigmas.csv").write_bytes(as_csv(made, SigmaRow))
    assert tables_of(tmp_path / "sigmas.csv") == {"sigmas": sigmas(made).body()}


def test_nobody_found_has_no_standard_deviation() -> None:
    assert sigmas(sigma_rows((1,), [row("one", 1, (0.0, 90.0), (), ())])).rows[-1] == ("all", "0", "-", "-", "-", "-")
