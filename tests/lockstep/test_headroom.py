"""What a mission computes is told state by state."""

import csv

import pytest
from click.testing import CliRunner

from ross_sim.study import headroom
from ross_sim.study.page_tables import tables_of
from short_mission import PAIR

pytestmark = pytest.mark.lockstep


@pytest.fixture
def scenario(tmp_path):
    path = tmp_path / "short.toml"
    path.write_text(PAIR)
    return path


def test_the_states_of_a_mission_have_their_time_and_what_they_computed(scenario, tmp_path):
    out = tmp_path / "rows.csv"
    done = CliRunner().invoke(headroom.main, [str(out), "--scenario", str(scenario), "--seeds", "0,1"])
    assert done.exit_code == 0, done.output
    rows = list(csv.DictReader(out.read_text().splitlines()))
    assert {row["seed"] for row in rows} == {"0", "1"}
    states = {row["state"]: row for row in rows if row["seed"] == "0"}
    assert float(states["LEAD_IN"]["audio_s"]) == pytest.approx(2.0, abs=0.02)
    assert 1.0 <= float(states["EXPLORE_LISTEN"]["audio_s"]) <= 1.6  # two or three orientations of 0.5 s
    assert all(0 < float(row["longest_s"]) <= float(row["cpu_s"]) + 1e-6 for row in rows)
    listening, waiting = (float(states[name]["cpu_s"]) for name in ("EXPLORE_LISTEN", "LEAD_IN"))
    assert listening > 10 * waiting
    assert "exploring, while it listens" in tables_of(out)["headroom"]


def test_a_scenario_that_there_is_not_is_refused_in_one_line(tmp_path):
    done = CliRunner().invoke(headroom.main, [str(tmp_path / "rows.csv"), "--scenario", "nowhere"])
    assert done.exit_code == 2
    assert "nowhere" in done.stderr
    assert not (tmp_path / "rows.csv").exists()
