"""The study of talkers who move: what is known at the start, who walks where, and what its table says."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from ross_payload.events import Outcome
from ross_sim.study import moving_talkers
from ross_sim.study.moving_talkers import APART, WALKS, Case, staged
from ross_sim.study.rows.moving_rows import MovingRow, moving


@pytest.mark.parametrize("seed", range(3))
def test_true_azimuths_are_told_and_are_those_of_the_talkers(seed):
    case = Case("S1", 10.0, seed)
    scenario, _ = staged(case, np.random.default_rng([seed, 3]))
    told = scenario.payload.informed.azimuths_deg
    assert told == pytest.approx([talker.azimuth_deg for talker in scenario.talkers])


def test_an_exploration_is_told_nothing_of_the_same_layout():
    layouts = [staged(Case("S2", 5.0, 4, start=start), np.random.default_rng(4))[0] for start in ("true", "explored")]
    assert layouts[1].payload.informed is None
    assert [t.azimuth_deg for t in layouts[0].talkers] == [t.azimuth_deg for t in layouts[1].talkers]


@pytest.mark.parametrize("speed", [5.0, 10.0])
def test_one_walks_at_its_speed_and_away_from_the_others(speed):
    case = Case("S1", speed, 1)
    scenario, walker = staged(case, np.random.default_rng([1, 3]))
    times = np.arange(0.0, case.sets_out + WALKS, 0.1)
    azimuths = np.degrees(scenario.azimuths_at(times))
    rates = np.abs(np.diff(azimuths, axis=1)) * 10
    assert rates[walker, times[1:] < case.sets_out].max() == 0
    assert np.median(rates[walker, times[1:] > case.sets_out + 0.1]) == pytest.approx(speed, abs=1e-6)
    others = np.delete(azimuths, walker, axis=0)
    assert np.ptp(others, axis=1).max() == 0
    assert np.abs((azimuths[walker] - others + 180) % 360 - 180).min() > APART - 1e-6


def row(**changes):
    """A mission in which everybody was followed, with changes."""
    return replace(
        MovingRow("S1", 5.0, 0, 3, "true", "ann", False, 3.0, 0.0, 1.0, 1.0, 4, 0, si_sdr_db=8.0, known_si_sdr_db=9.0),
        **changes,
    )


def test_the_table_has_a_line_for_every_start_room_and_speed_with_the_rms_over_missions():
    rows = [row(), row(seed=1, walker_rms_deg=6.0, known_si_sdr_db=10.0), row(setting="S2"), row(start="explored")]
    lines = {line[0]: line[1:] for line in moving(rows).rows}
    assert list(lines) == ["S1, 5 deg/s", "S2, 5 deg/s", "explored, S1, 5 deg/s"]
    assert lines["S1, 5 deg/s"] == (
        "2", f"{math.sqrt(22.5):.1f}", "4.5", "1", "0.0", "100 %", "1.00", "4.0", "0", "1.5", "1.5"
    )  # fmt: skip


def test_the_tracker_alone_has_no_loss_in_the_table():
    (line,) = moving([row(si_sdr_db=None, known_si_sdr_db=None)]).rows
    assert line[-2:] == ("-", "-")


def test_a_mission_that_ctrl_c_stopped_is_no_row(monkeypatch, capsys):
    stopped = SimpleNamespace(result=SimpleNamespace(outcome=Outcome.STOPPED))
    monkeypatch.setattr(moving_talkers, "perform", lambda *_, **__: stopped)
    monkeypatch.setattr(moving_talkers, "enrol", lambda *_, **__: None)
    assert moving_talkers.main(["--draws", "1", "--settings", "S1", "--speeds", "5", "--tracker-alone"]) == 130
    assert capsys.readouterr() == ("", "interrupted after 0 missions\n")
