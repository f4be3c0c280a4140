import math
import re
from pathlib import Path

import numpy as np
import pytest

from ross_payload.config import validated
from ross_payload.errors import ConfigError
from ross_sim.scenario import Scenario, load, names
from ross_sim.talkers.speech import TalkerVoice


def scenario(*talkers, **tables):
    return validated(Scenario, {"title": "test", "talkers": list(talkers), **tables}, "test.toml")


def voices(*called):
    clip = np.ones(16000, dtype=np.float32)
    return [TalkerVoice(name, clip, clip, 16000) for name in called]


@pytest.mark.parametrize("name", names())
def test_every_scenario_that_comes_with_the_simulator_loads(name):
    assert load(name).title


def test_the_papers_settings_are_as_in_its_table():
    first, second, third = (load(f"setting-{number}") for number in (1, 2, 3))
    assert [setting.room.t60_s for setting in (first, second, third)] == [0.0, 0.45, 0.7]
    for setting in (first, second, third):
        assert setting.room.size_m == (10.0, 10.0)
        assert setting.noise.snr_db == 15
        assert [talker.azimuth_deg for talker in setting.talkers] == [170, 70, -50]
        assert {talker.distance_m for talker in setting.talkers} == {2.5}
        assert setting.payload.array.spacing_m == 0.05


def test_nobody_talks_during_the_lead_in_unless_told_to():
    talker = {"azimuth_deg": 0}
    assert scenario(talker).start(scenario(talker).talkers[0]) == 2.0
    longer = scenario(talker, payload={"explore": {"lead_in_s": 5}})
    assert longer.start(longer.talkers[0]) == 5.0
    early = scenario({**talker, "start_s": 0})
    assert early.start(early.talkers[0]) == 0.0


def test_talkers_stand_where_azimuth_and_distance_say():
    (source,) = scenario({"azimuth_deg": 90, "distance_m": 3}).spec().sources
    assert source == pytest.approx((5.0, 8.0))


def test_height_gives_elevation():
    talker = {"azimuth_deg": 0, "distance_m": 1, "height_m": 2}
    room = scenario(talker, room={"size_m": [6, 6, 3], "array_m": [3, 3, 1]})
    assert room.spec().sources == ((4.0, 3.0, 2.0),)
    assert room.elevations() == pytest.approx((math.pi / 4,))


def test_azimuths_are_wrapped():
    assert scenario({"azimuth_deg": 270}).azimuths() == pytest.approx((-math.pi / 2,))


def test_a_small_room_that_rings_for_long_is_none_too_large():
    """19 million reflections: 5 GB while it is computed."""
    room = {"size_m": [3, 3, 3], "t60_s": 1.5}
    assert validated(Scenario, {"title": "x", "talkers": [{"azimuth_deg": 0, "distance_m": 0.8}], "room": room}, "bath")


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (
            {"talkers": [{"azimuth_deg": 0, "distance_m": 7}]},
            "source 0: expected a place inside the room of 10 x 10 m, got 12 x 5 m",
        ),
        (
            {"talkers": [{"azimuth_deg": 0, "distance_m": 0.1}]},
            "source 0: expected at least 0.2 m from the centre of the array, got 0.10 m",
        ),
        ({"talkers": [{"azimuth_deg": 0, "height_m": 1}]}, "height_m: expected a room with three sides"),
        (
            {"talkers": [{"azimuth_deg": 0, "start_s": 5, "end_s": 4}]},
            "end_s: expected a time after start_s = 5, got 4",
        ),
        ({"talkers": [{"azimuth_deg": 0, "pauses": [[5, 4]]}]}, "pauses: expected a pause that ends after it begins"),
        ({"talkers": [{"azimuth": 0}]}, "azimuth_deg"),
        (
            {"talkers": [{"azimuth_deg": 0, "path": [{"at_s": 1, "azimuth_deg": 1e300}]}]},
            "expected a way of at most 10000 m, got a longer one",
        ),
        ({"talkers": [], "payload": {"array": {"spacing_m": 0}}}, r"payload\.array\.spacing_m"),
        ({"talkers": [], "room": {"size_m": [10, 10], "t60_s": 0.01}}, "t60 = 0.01 s is too short"),
        ({"talkers": [], "rooms": {}}, "unknown key 'rooms'"),
        ({}, "talkers"),
        ({"talkers": [], "room": {"size_m": [6, 6, 3], "t60_s": 5}}, "t60 = 5 s is too long for a room of 6 x 6 x 3 m"),
        ({"talkers": [], "room": {"size_m": [6]}}, r"room\.size_m\.1: expected a value, got none"),
        ({"talkers": [], "target": -1}, "toml: target: expected a valid string, got -1"),
        (
            {"talkers": [{"azimuth_deg": 0, "path": [{"at_s": 1, "azimuth_deg": 1, "distance_m": 7}]}]},
            r"talkers\.0\.path: expected a place inside the room of 10 x 10 m",
        ),
        (
            {
                "talkers": [{"azimuth_deg": 0}],
                "noise": {"sources": [{"name": "fan", "azimuth_deg": 0, "distance_m": 7, "snr_db": 9}]},
            },
            "noise source 'fan': expected a place inside the room",
        ),
        (
            {"talkers": [{"azimuth_deg": 0}, {"azimuth_deg": 9, "end_s": 1}]},
            r"talkers\.1\.end_s: expected a time after 2 s, when the talker begins, got 1",
        ),
        (
            {"talkers": [], "troubles": [{"fault": "silent", "at_s": 30, "end_s": 10}]},
            r"troubles\.0: end_s: expected a time after at_s = 30, got 10",
        ),
    ],
)
def test_wrong_file_is_refused_in_one_line(tmp_path, values, message):
    with pytest.raises(ConfigError, match=message) as refused:
        validated(Scenario, {"title": "test", **values}, "test.toml")
    assert "\n" not in str(refused.value)
    assert str(refused.value).startswith("test.toml: ")


def test_unknown_name_lists_those_that_exist():
    with pytest.raises(ConfigError, match="scenario 'nowhere' is unknown; there are: demo, "):
        load("nowhere")


def test_a_file_is_loaded_by_its_path(tmp_path):
    (tmp_path / "mine.toml").write_text('title = "mine"\ntalkers = []\n')
    assert load(tmp_path / "mine.toml").title == "mine"
    with pytest.raises(ConfigError, match="cannot be read"):
        load(tmp_path / "yours.toml")


def test_talkers_get_voices_in_order_and_by_name():
    cast = scenario({"azimuth_deg": 0}, {"azimuth_deg": 90, "name": "a"}, {"azimuth_deg": 180, "name": 3}).cast(
        voices("a", "b", "c", "d")
    )
    assert [voice.name for voice in cast.talkers] == ["b", "a", "d"]
    assert cast.target.name == "b"


def test_target_may_be_a_name_or_somebody_who_is_not_there():
    talkers = ({"azimuth_deg": 0}, {"azimuth_deg": 90})
    everyone = voices("a", "b", "c")
    by_name = scenario(*talkers, target="b").cast(everyone)
    assert by_name.target is by_name.talkers[1]
    absent = scenario(*talkers, target=2).cast(everyone)
    assert absent.target.name == "c"
    assert absent.target not in absent.talkers
    assert scenario().cast(everyone).target.name == "a"


@pytest.mark.parametrize(
    ("talkers", "target", "message"),
    [
        ([{}, {}, {}], 0, "3 talkers but only 2 voices: a, b"),
        ([{"name": "x"}], 0, "voice 'x' is unknown; there are: a, b"),
        ([{"name": "a"}, {"name": 0}], 0, "expected each voice once, got 'a' twice"),
        ([{}], "x", "voice 'x' is unknown"),
        ([{}], 2, "voice number: expected 0 to 1, got 2"),
    ],
)
def test_impossible_cast_is_refused(talkers, target, message):
    placed = [{"azimuth_deg": 60 * index, **talker} for index, talker in enumerate(talkers)]
    with pytest.raises(ConfigError, match=message):
        scenario(*placed, target=target).cast(voices("a", "b"))


def test_the_manual_lists_every_scenario_with_its_title():
    page = (Path(__file__).parents[3] / "docs" / "how-to" / "write-a-scenario.md").read_text(encoding="utf-8")
    listed = re.findall(r"^\| `([a-z0-9-]+)` \| (.+) \|$", page.split("## Scenarios that come")[1], re.MULTILINE)
    assert dict(line for line in listed if "|" not in line[1]) == {name: load(name).title for name in names()}
