"""Sums of sines that are computed otherwise than by adding sines are what the sums are."""

import numpy as np
import pytest

from ross_sim.acoustics.rotor_noise import TONES, rotor
from ross_sim.acoustics.sines import sines


def test_one_transform_is_the_sum_of_its_sines():
    rng, n = np.random.default_rng(1), 1000
    cycles, shifts, strengths = np.array([1, 7, 7, 499]), rng.uniform(0, 6, 4), rng.standard_normal(4)
    turned = 2 * np.pi * np.arange(n) / n
    direct = sum(s * np.sin(c * turned + shift) for c, s, shift in zip(cycles, strengths, shifts, strict=True))
    assert sines(cycles, shifts, n, strengths) == pytest.approx(direct, abs=1e-9)


@pytest.mark.soak
def test_the_harmonics_of_a_rotor_follow_its_speed_and_fall_as_one_over_their_number():
    rate, blades = 16000, 2
    sound = rotor(rate, 5400.0, blades, np.random.default_rng(2))
    phase = 2 * np.pi * blades * (np.cumsum(sound.speed) - sound.speed) / rate
    strengths = [abs(np.mean(sound.sound * np.exp(-1j * k * phase))) for k in range(1, TONES + 1)]
    assert np.array(strengths) * np.arange(1, TONES + 1) == pytest.approx(np.full(TONES, strengths[0]), rel=0.2)
