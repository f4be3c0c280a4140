"""Cars that pass again and again: each goes its whole way, however soon the next one follows."""

import math

import numpy as np
import pytest

from ross_payload.config import validated
from ross_payload.errors import ConfigError
from ross_sim.acoustics.far_noise import car_way
from ross_sim.acoustics.repeated_sounds import Passing
from ross_sim.noise_tables import NoiseSource

RATE, SPEED, AT = 1000, 14.0, 6.0  # [Hz], [m/s], [s]


@pytest.mark.parametrize("every", [30.0, 8.0, 5.0, 1.3])
def test_every_car_goes_its_whole_way_at_its_speed(every):
    along = car_way(0.0, 15.0)[1]
    samples = np.arange(20 * RATE)
    sound = np.ones(7, dtype=np.float32)
    heard = [
        Passing(sound, along, here, SPEED / RATE, AT * RATE, every * RATE).between(0, samples.size)
        for here in range(along.size)
    ]
    cars = [SPEED * (samples / RATE - AT - number * every) for number in range(20)]
    expected = sum((np.abs(car) <= along[-1]).astype(int) for car in cars)
    assert np.abs(np.sum(heard, axis=0) - expected).max() < 1e-5
    places = sum(np.where(np.abs(car) <= along[-1], car, 0.0) for car in cars)
    assert np.abs(along @ np.array(heard) - places).max() < 1e-3


def test_cars_on_their_way_at_once_have_different_parts_of_the_sound():
    sound = np.arange(1.0, 101.0, dtype=np.float32)
    way = np.array([-10.0, 0.0, 10.0])
    middle = Passing(sound, way, 1, 1.0, 0.0, 10.0)
    assert middle.between(0, 21) == pytest.approx([_both(sound, n) for n in range(21)])


def _both(sound, n):
    """What a car that is ``n % 10`` past the middle and its follower sound like there."""
    near, far = n // 10, n // 10 + 1
    share = 1 - n % 10 / 10
    parts = [sound[(n + 50 * (number % 2)) % 100] for number in (near, far)]
    return share * parts[0] + (1 - share) * parts[1]


def test_more_cars_than_can_be_told_apart_are_refused():
    car = {"name": "cars", "kind": "passing_car", "azimuth_deg": 0.0, "snr_db": 0.0, "every_s": 5.0}
    assert validated(NoiseSource, {**car, "distance_m": 100.0}, "test").away == 100.0
    most = 2 * 1000.0 * math.sqrt(15) / (14.0 * 5.0)
    with pytest.raises(ConfigError, match=f"every_s: expected at most 30 cars to be heard at once, got {most:.0f}"):
        validated(NoiseSource, {**car, "distance_m": 1000.0}, "test")
