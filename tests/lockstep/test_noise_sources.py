"""What sounds from one side of the room: where it comes from, how loud it is, and that nothing else changes."""

import math

import numpy as np
import pytest
import soundfile

from noise_bench import RATE, SPACING, SPEED_OF_SOUND, arrives_earlier_at_microphone_2, heard, power_db
from ross_payload.config import validated
from ross_payload.errors import ConfigError
from ross_sim.scenario import Scenario

FAN = {"name": "fan", "azimuth_deg": 60.0, "distance_m": 2.5, "snr_db": 10.0}


def scenario(*sources, room=None, **noise):
    values = {
        "title": "test",
        "talkers": [{"azimuth_deg": 155.0, "start_s": 0.5}, {"azimuth_deg": -80.0, "start_s": 0.5}],
        "noise": {"snr_db": 60, "sources": list(sources), **noise},
        "room": room or {},
    }
    return validated(Scenario, values, "test.toml")


@pytest.mark.parametrize(("reference", "below_mixture"), [("mixture", 0.0), ("talker", 10 * math.log10(2))])
def test_a_source_is_as_loud_as_it_asks_for(tmp_path, reference, below_mixture):
    world = heard(scenario(FAN, snr_reference=reference), tmp_path, seconds=6)
    together = world.images().sum(axis=0)[RATE:]
    assert power_db(together) - power_db(world.noise()[0]) == pytest.approx(10 + below_mixture, abs=0.5)


def test_two_sources_add_up(tmp_path):
    other = {**FAN, "name": "other", "azimuth_deg": -20.0}
    one, two = (heard(scenario(*sources), tmp_path, seconds=6) for sources in ((FAN,), (FAN, other)))
    assert power_db(two.noise()[0]) - power_db(one.noise()[0]) == pytest.approx(10 * math.log10(2), abs=0.5)


@pytest.mark.parametrize("heading_deg", [0.0, 40.0, -90.0])
def test_a_source_stands_in_the_room_and_does_not_turn_with_the_array(tmp_path, heading_deg):
    noise = heard(scenario(FAN), tmp_path, angle=math.radians(heading_deg)).noise()
    expected = SPACING / SPEED_OF_SOUND * math.cos(math.radians(60.0 - heading_deg))
    assert arrives_earlier_at_microphone_2(noise) == pytest.approx(expected, abs=4e-6)


def test_a_source_changes_neither_talkers_nor_sensor_noise(tmp_path):
    without, within = heard(scenario(), tmp_path), heard(scenario(FAN), tmp_path)
    assert np.array_equal(without.images(), within.images())
    far = heard(scenario({**FAN, "snr_db": 100.0}), tmp_path)
    assert np.abs(far.noise() - without.noise()).max() < 1e-5


def test_the_same_seed_makes_the_same_noise_and_another_seed_another(tmp_path):
    first, again, other = (heard(scenario(FAN), tmp_path, seed=seed).noise() for seed in (1, 1, 2))
    assert np.array_equal(first, again)
    assert abs(np.corrcoef(first[0], other[0])[0, 1]) < 0.2


def test_a_recording_sounds_again_and_again(tmp_path):
    tone = np.sin(2 * np.pi * 1000 * np.arange(RATE) / RATE)
    soundfile.write(tmp_path / "hum.wav", 0.1 * tone, RATE)
    noise = heard(scenario({**FAN, "sound": str(tmp_path / "hum.wav")}), tmp_path).noise()[0]
    spectrum = np.abs(np.fft.rfft(noise[-RATE:]))
    assert spectrum.argmax() == 1000
    assert spectrum[1000] ** 2 > 0.9 * (spectrum**2).sum()


def test_a_recording_that_is_not_there_is_told_in_one_line(tmp_path):
    with pytest.raises(ConfigError, match=r"noise source 'fan': expected 'fan' or a recording: .*none.wav") as refused:
        heard(scenario({**FAN, "sound": str(tmp_path / "none.wav")}), tmp_path)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"distance_m": 9.0}, "expected a place inside the room"),
        ({"height_m": 1.0}, "height_m: expected a room with three sides"),
        ({"snr_db": 500.0}, r"noise\.sources\.0\.snr_db"),
        ({"loud": 1}, "unknown key"),
    ],
)
def test_an_impossible_source_is_refused_in_one_line(change, words):
    with pytest.raises(ConfigError, match=words) as refused:
        scenario({**FAN, **change})
    assert "\n" not in str(refused.value)


def test_in_a_room_a_source_is_as_high_as_the_array_unless_told():
    room = {"size_m": [6.0, 5.0, 2.6], "array_m": [3.0, 2.5, 0.9]}
    low, high = scenario(FAN, {**FAN, "height_m": 2.0}, room=room).spec_of_noise().sources
    assert (low[2], high[2]) == (0.9, 2.0)
    assert low[:2] == pytest.approx((3.0 + 1.25, 2.5 + 2.5 * math.sin(math.radians(60))))
