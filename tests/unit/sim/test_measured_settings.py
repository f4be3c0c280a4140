"""Settings 4 and 5 hold what the paper's table and text say of the measurements."""

import math

import pytest

from ross_sim.scenario import load

TABLE = {"setting-4": (15.4, 0.0), "setting-5": (23.0, None)}  # SNR [dB], T60 [s]; None: not given


@pytest.mark.parametrize("name", TABLE)
def test_the_measured_settings_are_as_in_the_table_and_the_text(name):
    setting, (snr, t60) = load(name), TABLE[name]
    payload = setting.payload
    assert (setting.noise.snr_db, setting.noise.snr_reference) == (snr, "mixture")
    assert t60 is None or setting.room.t60_s == t60
    assert payload.audio.rate_hz == 16000
    assert payload.array.spacing_m == 0.05
    assert payload.actuator.kind == "tb6600"
    assert (payload.guard.max_speed_deg_s, payload.guard.max_acceleration_deg_s2) == (225, 112.5)
    assert (payload.explore.step_deg, payload.explore.unit_s) == (15, 3)
    assert [talker.azimuth_deg for talker in setting.talkers] == [170, 70, -50]
    assert {talker.level_db for talker in setting.talkers} == {0.0}


def test_the_field_is_larger_than_20_by_20_m_and_the_talkers_are_at_2_m():
    field = load("setting-4")
    assert min(field.room.size_m) > 20
    assert {talker.distance_m for talker in field.talkers} == {2.0}


def test_the_conference_room_is_6_by_8_m_and_the_talkers_are_at_2_to_2_5_m_and_level_with_the_array():
    room = load("setting-5")
    width, depth, height = room.room.size_m
    assert (width, depth) == (6, 8)
    assert room.centre()[:2] == (width / 2, depth / 2)
    assert 0 < room.centre()[2] < height
    assert all(2 <= talker.distance_m <= 2.5 for talker in room.talkers)
    assert room.elevations() == pytest.approx([0.0] * 3)
    assert [math.dist(source, room.centre()) for source in room.spec().sources] == pytest.approx(
        [talker.distance_m for talker in room.talkers]
    )
