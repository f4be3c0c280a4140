"""The rooms that people live in: who sits and stands where, and what sounds beside them."""

import math
from dataclasses import replace

import numpy as np
import pytest

from examples import in_soak
from ross_sim.acoustics.fan_noise import fan
from ross_sim.acoustics.room import respond
from ross_sim.scenario import load

ROOMS = {"living-room": 0.38, "office": 0.51, "hall": 0.69}  # T60 of what is simulated [s]
SEATED, STANDING = 1.2, 1.6


@pytest.mark.parametrize("name", ROOMS)
def test_people_sit_and_stand_two_to_four_metres_away_and_one_is_soft(name):
    room = load(name)
    assert len(room.room.size_m) == 3
    assert {talker.height_m for talker in room.talkers} == {SEATED, STANDING}
    assert all(2 <= talker.distance_m <= 4 for talker in room.talkers)
    assert sorted(talker.level_db for talker in room.talkers)[:2] == [-10, 0]
    assert len(room.noise.sources) == 1
    azimuths = np.array([*room.azimuths(), math.radians(room.noise.sources[0].azimuth_deg)])
    apart = np.abs(np.angle(np.exp(1j * (azimuths[:, None] - azimuths)))) + 2 * np.pi * np.eye(azimuths.size)
    assert np.rad2deg(apart.min()) >= 25


@pytest.mark.parametrize("name", ["hall", *in_soak("living-room", "office")])
def test_a_room_decays_as_long_as_the_manual_says(name):
    spec = load(name).spec()
    spec = replace(spec, sources=spec.sources[:1])
    response = respond(spec, [0.1])[0, 0, 0]
    energy = np.cumsum(response[::-1].astype(float) ** 2)[::-1]
    level = 10 * np.log10(energy / energy[0])
    decay = 3 * (np.argmax(level < -25) - np.argmax(level < -5)) / spec.rate
    assert decay == pytest.approx(ROOMS[name], abs=0.05)


def test_a_fan_is_broadband_falls_with_frequency_and_has_the_tones_of_its_blades():
    rate = 16000
    noise = fan(rate, np.random.default_rng(3))
    power = np.abs(np.fft.rfft(noise)) ** 2
    frequencies = np.fft.rfftfreq(noise.size, 1 / rate)

    def density(low, high):
        return power[(frequencies >= low) & (frequencies < high)].mean()

    assert 10 * math.log10(density(1000, 1100) / density(4000, 4400)) == pytest.approx(12, abs=1)
    assert density(0, 35) < 1e-6 * density(200, 400)
    loudest = frequencies[power.argmax()]
    assert 7 * 18 <= loudest <= 7 * 24
    assert power.max() / power.sum() > 0.05


def test_a_fan_goes_on_without_a_seam():
    noise = fan(16000, np.random.default_rng(0), seconds=4.0)
    steps = np.abs(np.diff(np.concatenate([noise, noise])))
    assert steps[noise.size - 1] < steps.max()
    assert np.sqrt(np.mean(noise**2)) == pytest.approx(1)
