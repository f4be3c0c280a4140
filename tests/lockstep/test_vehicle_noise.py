"""Noise of rotors, wind, babble and cars as the microphones hear it: where it comes from, how loud, and when."""

import math

import numpy as np
import pytest
import soundfile

from noise_bench import RATE, SPACING, SPEED_OF_SOUND, Fixed, arrives_earlier_at_microphone_2, heard, power_db
from ross_payload.config import validated
from ross_payload.errors import ConfigError
from ross_sim.acoustics import far_noise
from ross_sim.clock import SimClock
from ross_sim.noise_tables import Noise
from ross_sim.scenario import Scenario
from ross_sim.sitl.world import World
from ross_sim.talkers.speech import TalkerVoice

ROTOR = {"name": "rotors", "kind": "rotor", "snr_db": 0.0}
ONE_ROTOR = {**ROTOR, "rotors_m": [(0.3, 0.2, 0.1)]}
WIND = {"name": "wind", "kind": "wind", "snr_db": 0.0}


def scenario(*sources, vehicle=None, microphones=None):
    values = {
        "title": "test",
        "talkers": [{"azimuth_deg": 155.0, "start_s": 0.0}, {"azimuth_deg": -80.0, "start_s": 0.0}],
        "noise": {"snr_db": 80, "sources": list(sources)},
        "vehicle": vehicle,
        "microphones": microphones,
    }
    return validated(Scenario, values, "test.toml")


def level(world):
    """SNR at microphone 1 [dB]."""
    return power_db(world.images().sum(axis=0)) - power_db(world.noise()[0])


def coherence(samples, low, high):
    """Magnitude-squared coherence of both microphones between two frequencies [Hz]."""
    frames = samples[:, : samples.shape[1] // 512 * 512].reshape(2, -1, 512) * np.hanning(512)
    first, second = np.fft.rfft(frames)
    cross = (second * first.conj()).mean(axis=0)
    whole = np.abs(cross) ** 2 / ((np.abs(first) ** 2).mean(axis=0) * (np.abs(second) ** 2).mean(axis=0))
    frequencies = np.fft.rfftfreq(512, 1 / RATE)
    return float(whole[(frequencies >= low) & (frequencies < high)].mean())


@pytest.mark.parametrize("yaw_deg", [0.0, 70.0])
def test_a_rotor_stays_where_it_is_on_the_vehicle_whatever_the_vehicle_does(tmp_path, yaw_deg):
    place, joint = (0.3, 0.2, 0.1), math.radians(25.0)
    rotor = {**ROTOR, "rotors_m": [place]}
    yawing = {"yaw_deg": 0.0, "amplitude_deg": yaw_deg, "rate_deg_s": 40.0} if yaw_deg else None
    noise = heard(scenario(rotor, vehicle=yawing), tmp_path, angle=joint).noise()
    along = 0.5 * SPACING * np.array([math.cos(joint), math.sin(joint), 0.0])
    expected = (math.dist(place, -along) - math.dist(place, along)) / SPEED_OF_SOUND
    assert arrives_earlier_at_microphone_2(noise) == pytest.approx(expected, abs=4e-6)


def test_a_rotor_is_heard_by_the_array_that_is_there_not_by_the_one_that_is_configured(tmp_path):
    there = {"spacing_m": 0.04, "offset_deg": 180.0}
    world = heard(scenario({**ROTOR, "rotors_m": [(0.2, 0.0, 0.0)]}, microphones=there), tmp_path)
    assert arrives_earlier_at_microphone_2(world.noise()) == pytest.approx(-0.04 / SPEED_OF_SOUND, abs=4e-6)
    assert level(world) == pytest.approx(0.0, abs=0.5)


def test_the_nearer_microphone_hears_a_rotor_louder_as_spherical_waves_are(tmp_path):
    noise = heard(scenario({**ROTOR, "rotors_m": [(0.2, 0.0, 0.0)]}), tmp_path).noise()
    assert power_db(noise[1]) - power_db(noise[0]) == pytest.approx(20 * math.log10(0.225 / 0.175), abs=0.1)


@pytest.mark.parametrize("source", [ROTOR, WIND, {"name": "people", "kind": "babble", "snr_db": 0.0}])
def test_a_source_of_any_kind_is_as_loud_as_it_asks_for(source, monkeypatch):
    monkeypatch.setattr(far_noise, "PERIOD", 4.0)  # of babble: as long as it is heard
    world = heard(scenario({**source, "snr_db": -5.0}), None, seconds=4 if source["kind"] == "babble" else 20)
    assert level(world) == pytest.approx(-5.0, abs=0.3)


@pytest.mark.soak
def test_wind_is_low_not_coherent_and_comes_in_gusts(tmp_path):
    windy, even = (heard(scenario({**WIND, "gusts": gusts}), tmp_path, seconds=20).noise() for gusts in (True, False))
    assert coherence(windy, 50, 2000) < 0.05
    power = np.abs(np.fft.rfft(windy[0])) ** 2
    frequencies = np.fft.rfftfreq(windy.shape[1], 1 / RATE)

    def density(low, high):
        return power[(frequencies >= low) & (frequencies < high)].mean()

    assert 10 * math.log10(density(400, 500) / density(3200, 4000)) == pytest.approx(50 / 3 * math.log10(8), abs=1)
    spread = [np.std(10 * np.log10((each[0].reshape(-1, RATE // 2) ** 2).mean(axis=1))) for each in (windy, even)]
    assert spread[0] > 3
    assert spread[1] < 1.5


@pytest.mark.soak
def test_a_windscreen_takes_from_the_wind_the_more_the_higher(tmp_path):
    bare, screened = (
        np.abs(np.fft.rfft(heard(scenario({**WIND, "windscreen": on}), tmp_path, seconds=4).noise()[0])) ** 2
        for on in (False, True)
    )
    frequencies = np.fft.rfftfreq(4 * RATE, 1 / RATE)

    def taken(low, high):
        band = (frequencies >= low) & (frequencies < high)
        return 10 * math.log10(bare[band].sum() / screened[band].sum())

    assert taken(40, 90) == pytest.approx(12, abs=1)
    assert taken(390, 410) == pytest.approx(24, abs=1)


@pytest.mark.soak
def test_a_car_comes_from_where_it_is_and_is_loudest_where_it_is_nearest(tmp_path):
    car = {"name": "car", "kind": "passing_car", "azimuth_deg": 90.0, "at_s": 6.0, "speed_m_s": 10.0, "snr_db": 0.0}
    noise = heard(scenario(car), tmp_path, seconds=12).noise()
    delays = [
        arrives_earlier_at_microphone_2(noise[:, round(t * RATE) : round((t + 0.6) * RATE)]) for t in (4.2, 5.7, 7.2)
    ]
    angles = [math.atan2(15.0, 10.0 * (6.0 - t - 0.3)) for t in (4.2, 5.7, 7.2)]
    assert delays == pytest.approx([SPACING / SPEED_OF_SOUND * math.cos(angle) for angle in angles], abs=6e-6)
    levels = [power_db(noise[0, s * RATE : (s + 2) * RATE]) for s in (1, 3, 5, 7, 9)]
    assert levels.index(max(levels)) == 2
    assert levels[0] < levels[1] < levels[2] > levels[3] > levels[4]


def test_noise_beyond_the_converter_is_clipped_and_wraps_nowhere(tmp_path):
    told = scenario().model_copy(update={"noise": Noise(snr_db=-100.0)})
    world = heard(told, tmp_path, seconds=1.0)
    loud = world.noise() > 0
    assert np.mean(loud) == pytest.approx(0.5, abs=0.02)
    assert np.mean((world.mixture() > 0) == loud) > 0.999


def test_recorded_rotors_share_the_recordings_of_a_folder(tmp_path):
    for index, pitch in enumerate((500, 1500)):
        tone = 0.1 * np.sin(2 * np.pi * pitch * np.arange(RATE) / RATE)
        soundfile.write(tmp_path / f"rotor-{index}.wav", tone, RATE)
    noise = heard(scenario({**ROTOR, "sound": str(tmp_path)}), tmp_path).noise()[0]
    spectrum = np.abs(np.fft.rfft(noise[-RATE:]))
    assert set(np.argsort(spectrum)[-2:].tolist()) == {500, 1500}


@pytest.mark.soak  # of one kind: test_noise_sources
def test_the_same_seed_makes_the_same_noise_of_every_kind(monkeypatch):
    monkeypatch.setattr(far_noise, "PERIOD", 1.0)  # more than is heard
    sources = [ONE_ROTOR, WIND, {"name": "people", "kind": "babble", "snr_db": 5.0}]
    first, again, other = (heard(scenario(*sources), None, seed=seed, seconds=0.5).noise() for seed in (1, 1, 2))
    assert np.array_equal(first, again)
    assert abs(np.corrcoef(first[0], other[0])[0, 1]) < 0.3


@pytest.mark.soak  # of talkers: test_world
def test_how_audio_is_read_does_not_change_the_noise(tmp_path):
    scene = scenario(ONE_ROTOR, WIND)
    clip = np.random.default_rng(7).standard_normal(4 * RATE).astype(np.float32)
    voices = [TalkerVoice(f"voice-{index}", clip, clip, RATE) for index in range(2)]
    noises = []
    for hop in (160, 777):
        world = World(scene, voices, Fixed(), SimClock(), 1, cache=tmp_path)
        with world.source as source:
            for _ in range(RATE // 2 // hop):
                source.read(hop)
        noises.append(world.noise()[:, : RATE // 2 - 1000])
    assert np.array_equal(*noises)


@pytest.mark.parametrize(
    ("source", "said"),
    [
        ({**ROTOR, "azimuth_deg": 3.0}, "azimuth_deg: expected one of blades, rotors_m, rpm for 'rotor'"),
        ({**ROTOR, "rotors_m": [(0.01, 0.0, 0.0)]}, "expected places at least 0.1 m from the array"),
        ({"name": "fan", "snr_db": 3.0}, "azimuth_deg: expected where it is, got nothing"),
        ({**WIND, "kind": "storm"}, "kind"),
    ],
)
def test_what_makes_no_sense_is_told(source, said):
    with pytest.raises(ConfigError, match=said):
        scenario(source)


def test_a_folder_without_recordings_is_told_in_one_line(tmp_path):
    with pytest.raises(
        ConfigError, match=r"noise source 'rotors': expected a recording: .*holds no recording"
    ) as refused:
        heard(scenario({**ROTOR, "sound": str(tmp_path)}), tmp_path)
    assert "\n" not in str(refused.value)
