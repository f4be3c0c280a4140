"""A study of missions: what it draws, what its table says, and what it refuses."""

from dataclasses import replace

import numpy as np
import pytest

from ross_payload.angles import difference
from ross_payload.config import validated
from ross_payload.errors import ConfigError
from ross_sim.scenario import load
from ross_sim.study.rows.mission_rows import MissionRow
from ross_sim.study.rows.mission_table import HEADER, missions
from ross_sim.study.runs.mission_design import (
    MissionStudy,
    MissionTask,
    check_draws,
    mission_tasks,
    scenario_of,
    staged,
)
from ross_sim.talkers.speech import TalkerVoice

ROW = MissionRow(
    "demo-K2-D0", "demo", 2, 0, 7, "0.1", "present", ("a", "b"), (40.0, 150.0), "a", "target_found", True, 2,
    (0.5, 1.5), 6, 0, 30.0, 20.0, 14.0, 100.0, 5.0,
)  # fmt: skip


def voices(n):
    clip = np.ones(16000, dtype=np.float32)
    return [TalkerVoice(f"voice-{index}", clip, clip, 16000) for index in range(n)]


def study(**changes):
    return validated(MissionStudy, {"scenarios": ("demo",), "draws": 3, **changes}, "test")


def test_a_draw_depends_on_its_seed_alone():
    task, later, heard = MissionTask("demo", 3, 2), MissionTask("demo", 3, 0), voices(9)
    assert staged(study(seed=5), task, heard) == staged(study(seed=7), later, heard)
    assert staged(study(seed=5), task, heard) != staged(study(seed=5), later, heard)


@pytest.mark.parametrize("name", ["demo", "living-room", "hall", "S2", "A0.45", "B0.7"])
@pytest.mark.parametrize("k", [2, 5])
def test_drawn_talkers_stand_apart_inside_the_room_at_distances_of_the_scenario(name, k):
    origin = scenario_of(name)
    for draw in range(5):
        drawn = staged(study(scenarios=(name,)), MissionTask(name, k, draw), voices(9))
        assert len(drawn.talkers) == len(drawn.scenario.talkers) == k
        drawn.scenario.spec()  # raises when somebody stands outside
        azimuths = np.deg2rad(drawn.azimuths_deg)
        gaps = np.abs(difference(azimuths[:, None], azimuths)) + 2 * np.pi * np.eye(k)
        assert np.rad2deg(gaps.min()) > 24.8
        assert {talker.distance_m for talker in drawn.scenario.talkers} <= {t.distance_m for t in origin.talkers}


def test_the_target_is_among_the_talkers_or_somebody_else():
    for draw in range(20):
        drawn = staged(study(), MissionTask("demo", 3, draw), voices(5))
        assert drawn.wanted["present"] in drawn.talkers
        assert drawn.wanted["absent"] not in drawn.talkers


def test_turns_are_heard_unless_somebody_asks_for_less():
    heard, unheard = (
        staged(study(**asked), MissionTask("demo", 3, 1), voices(9)) for asked in ({}, {"turns_heard": 0})
    )
    assert heard.scenario.room.turns_heard
    assert unheard.scenario.room == heard.scenario.room.model_copy(update={"turns_heard": False})


def test_places_can_stay_as_written():
    drawn = staged(study(places="written"), MissionTask("demo", 3, 1), voices(9))
    assert drawn.azimuths_deg == (40.0, 155.0, -80.0)
    assert drawn.scenario.payload.seed == 1001


def test_places_as_written_need_no_room_for_others(tmp_path):
    path = tmp_path / "corner.toml"
    path.write_text(
        'title = "corner"\n[room]\nsize_m = [4, 4]\narray_m = [0.3, 0.3]\n'
        "[[talkers]]\nazimuth_deg = 40\ndistance_m = 4\n[[talkers]]\nazimuth_deg = 50\ndistance_m = 4\n"
    )
    drawn = staged(study(places="written"), MissionTask(str(path), 2, 0), voices(9))
    assert drawn.azimuths_deg == (40.0, 50.0)


def test_every_scenario_and_k_has_its_draws():
    assert [task.id for task in mission_tasks(study(k=(2, 4), draws=2))] == [
        "demo-K2-D0", "demo-K2-D1", "demo-K4-D0", "demo-K4-D1",
    ]  # fmt: skip
    assert {task.k for task in mission_tasks(study(scenarios=("office", "S1")))} == {4, 3}


def test_keys_of_the_payload_can_be_changed():
    assert scenario_of("demo", ["explore.pipelined=true"]).payload.explore.pipelined
    assert not load("demo").payload.explore.pipelined


def test_a_key_without_a_value_is_absent_and_one_that_there_is_not_is_refused():
    assert scenario_of("paper-setting-1").payload.audio.frame == 1024
    assert scenario_of("paper-setting-1", ["audio.frame="]).payload.audio.frame is None
    with pytest.raises(ConfigError, match=r"unknown key 'payload\.audio\.frames'"):
        scenario_of("demo", ["audio.frames="])


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"scenarios": ("dmo",)}, "scenario 'dmo' is unknown; there are: .*did you mean 'demo'"),
        ({"scenarios": ("silence",)}, "silence: expected a scenario with talkers, got one without"),
        ({"k": (5,)}, "demo: expected 6 voices, one of them not in the room, got 5"),
        ({"k": (3,), "places": "written"}, "expected drawn ones where K is asked for, got written"),
        ({"k": (3, 3)}, "names something twice"),
        ({"settings": ("explore.pipelined",)}, "expected key=value"),
        ({"settings": ("explore.colour=1",)}, "unknown key"),
        ({"seed": 2**62}, "seed: expected a number less than 4611686018427387904"),
    ],
)
def test_what_cannot_be_flown_is_refused_in_one_line(changes, words):
    with pytest.raises(ConfigError, match=words) as refused:
        check_draws(study(**changes), voices(5))
    assert "\n" not in str(refused.value)


def test_a_room_too_small_for_its_talkers_is_refused(tmp_path):
    path = tmp_path / "corner.toml"
    path.write_text(
        'title = "corner"\n[room]\nsize_m = [4, 4]\narray_m = [0.3, 0.3]\n'
        "[[talkers]]\nazimuth_deg = 45\ndistance_m = 4\n"
    )
    with pytest.raises(ConfigError, match="expected room for 5 talkers 25 deg apart"):
        staged(study(), MissionTask(str(path), 5, 0), voices(9))


def cells(*rows):
    (line,) = missions(rows).rows
    return dict(zip(HEADER, line, strict=True))


def test_the_table_counts_what_became_of_the_missions():
    wrong = replace(
        ROW, target_right=False, heard_from_s=90.0, right_from_s=None, si_sdri_db=2.0, k_estimated=3, restarts=2
    )
    missed = replace(
        ROW, outcome="no_target", target_right=False, errors_deg=(0.5, 180.0), heard_from_s=None, right_from_s=60.0
    )
    away = replace(ROW, target_is="absent", outcome="no_target", target_right=True)
    heard = replace(away, outcome="target_found", target_right=False)
    ghost = replace(ROW, k_estimated=3, heard_from_s=80.0, right_from_s=20.0)
    told = cells(ROW, replace(ROW, heard_from_s=40.0, si_sdri_db=16.0), ghost, wrong, missed, away, heard)
    assert told[""] == "demo, K = 2"
    assert told["K right"].startswith("5/7 (")
    assert told["all within 5 deg"].startswith("6/7 (")
    assert told["found, K right"].startswith("2/5 (")
    assert told["target found"].startswith("3/5 (")
    assert told["absent: no target"].startswith("1/2 (")
    assert told["heard from [s]"] == "40.0"
    assert told["right from [s]"] == "20.0"
    assert told["SI-SDRi [dB]"] == "14.7 ± 2.9"
    assert told["explored again"] == "0.3"
    assert told["CPU [s/s]"] == "0.050"


def test_medians_have_their_intervals_where_there_are_enough():
    told = cells(*(replace(ROW, heard_from_s=float(second)) for second in range(1, 11)))
    assert told["heard from [s]"] == "5.5 (2.0-9.0)"  # ranks 2 and 9 of 10: 97.9 % of the binomial distribution


def test_a_target_that_was_heard_and_lost_in_the_end_is_not_found():
    told = cells(ROW, replace(ROW, outcome="no_target", heard_from_s=None, si_sdri_db=None))
    assert told["target found"].startswith("1/2 (")
    assert told["found, K right"].startswith("1/2 (")


def test_nothing_is_claimed_of_what_was_not_flown():
    told = cells(replace(ROW, target_right=False))
    assert (told["absent: no target"], told["heard from [s]"], told["SI-SDRi [dB]"]) == ("-", "-", "-")


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({}, ""),
        ({"k_estimated": 3}, "K = 3"),
        ({"errors_deg": (0.5, 6.0)}, "azimuth"),
        ({"outcome": "no_target"}, "no_target"),
        ({"target_right": False}, "wrong voice"),
        ({"si_sdri_db": 11.0}, "gain"),
    ],
)
def test_a_mission_says_why_it_does_not_succeed(changes, reason):
    assert replace(ROW, **changes).reason == reason
