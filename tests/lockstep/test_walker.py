"""A talker walks while the mission listens: followed, told, heard, and the same on a rerun."""

import json
import math

import numpy as np
import pytest

from ross_payload.config import validated
from ross_payload.events import Doubted, Outcome, SourcesTracked
from ross_sim.scenario import Scenario
from ross_sim.sitl.mission_session import perform
from ross_sim.sitl.mission_view import MissionView
from ross_sim.sitl.results_folder import ResultsFolder
from ross_sim.sitl.talker_selection import talkers_of

# without a room: test_source_tracking and test_moving_talkers
pytestmark = [pytest.mark.soak, pytest.mark.usefixtures("undrawn")]

SETS_OUT, SPEED = 3.0, 8.0  # [s], [deg/s]


def scenario(sets_out=SETS_OUT, **exploit):
    return validated(
        Scenario,
        {
            "title": "One walks",
            "talkers": [
                {"azimuth_deg": 40.0},
                {"azimuth_deg": 150.0},
                {
                    "azimuth_deg": -95.0,
                    "path": [
                        {"at_s": sets_out, "azimuth_deg": -95.0},
                        {"at_s": sets_out + 8, "azimuth_deg": -95.0 + 8 * SPEED},
                    ],
                },
            ],
            "noise": {"snr_db": 25},
            "payload": {
                "audio": {"rate_hz": 16000},
                "explore": {"lead_in_s": 1.0},
                "informed": {"azimuths_deg": [40, 150, -95], "target": 0},
                "exploit": {"separator": "gaussian", "check_s": 1.0, "run_s": 3.0, "runs": 3} | exploit,
            },
        },
        "walker",
    )


class Events(MissionView):
    def __init__(self):
        self.events = []

    def on_event(self, event, hop):
        self.events.append(event)


def fly(asked, folder):
    view = Events()
    with ResultsFolder(folder) as out:
        finished = perform(asked, talkers_of(asked, None, None), view, out, None)
    return finished, view.events, folder


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    return fly(scenario(), tmp_path_factory.mktemp("walker"))


def test_the_mission_listens_to_the_end_without_a_new_exploration(flown):
    finished, events, _ = flown
    assert finished.result.outcome is Outcome.TARGET_FOUND
    assert [event for event in events if isinstance(event, Doubted)] == []


def test_the_walker_is_told_where_it_is(flown):
    tracks = [row for row in flown[0].report["tracks"] if row["source"] == 2 and row["time_s"] > SETS_OUT + 4]
    errors = [row["azimuth_error_deg"] for row in tracks]
    assert len(errors) >= 8
    assert np.sqrt(np.mean(np.square(errors))) < 8.0
    assert max(row["rate_deg_s"] for row in tracks) == pytest.approx(SPEED, abs=5.0)


def test_the_target_is_heard_well_all_the_time(flown):
    gains = [period["si_sdri_db"] for period in flown[0].report["periods"]]
    assert len(gains) == 3
    assert min(gains) > 10.0


def test_the_truth_is_written_hop_by_hop(flown):
    lines = (flown[2] / "azimuths.csv").read_text().splitlines()
    assert lines[0] == "time_s,talker_0_deg,talker_1_deg,talker_2_deg"
    rows = np.array([[float(cell) for cell in line.split(",")] for line in lines[1:]])
    assert np.allclose(np.diff(rows[:, 0]), 0.01)
    assert np.allclose(rows[:, 1], 40.0)
    expected = -95.0 + SPEED * np.clip(rows[:, 0] - SETS_OUT, 0, 8)
    assert np.allclose(rows[:, 3], expected, atol=1e-3)


def test_a_rerun_gives_the_same_bytes(flown, tmp_path):
    one, other = flown[2], fly(scenario(), tmp_path / "other")[2]
    names = sorted(path.name for path in one.iterdir() if path.name != "timing.json")
    assert [name for name in names if (one / name).read_bytes() != (other / name).read_bytes()] == []
    assert "azimuths.csv" in names
    rates = [row["rate_deg_s"] for row in json.loads((one / "report.json").read_text())["tracks"]]
    assert max(rates) > SPEED / 2


def test_what_is_said_can_be_read_again(flown):
    said = [event for event in flown[1] if isinstance(event, SourcesTracked)]
    lines = (flown[2] / "events.jsonl").read_text().splitlines()
    written = [values for values in map(json.loads, lines) if values["event"] == "SourcesTracked"]
    assert len(written) == len(said) > 15
    assert written[-1]["ages"] == pytest.approx(said[-1].ages)
    assert math.isfinite(written[-1]["estimate"]["sources"][2]["azimuth"])
