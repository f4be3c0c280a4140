"""Two microphones that roll off at different low frequencies are made alike."""

import numpy as np
import pytest
from scipy.signal import butter, freqz, lfilter

from ross_payload.dsp.roll_off import RollOffMatch

RATE = 16000
FREQUENCIES = np.array([100.0, 300.0, 1000.0, 6000.0])  # [Hz]


def heard(corners, signal):
    """What two microphones with these corners [Hz] give of one signal."""
    filters = [butter(1, corner, "highpass", fs=RATE) for corner in corners]
    return np.stack([lfilter(*each, signal) for each in filters])


def impulse(n=RATE):
    return np.eye(1, n)[0]


@pytest.mark.parametrize("corners", [(20.0, 50.0), (120.0, 40.0)])
def test_phase_and_level_of_both_agree_afterwards(corners):
    first, second = RollOffMatch(corners, RATE)(heard(corners, impulse()))
    ratio = np.divide(*(freqz(each, worN=FREQUENCIES, fs=RATE)[1] for each in (second, first)))
    assert ratio == pytest.approx(1.0, abs=1e-3)


def test_a_difference_alone_is_enough_for_the_phase():
    first, second = RollOffMatch((0.0, 30.0), RATE)(heard((20.0, 50.0), impulse()))
    ratio = np.divide(*(freqz(each, worN=FREQUENCIES[1:], fs=RATE)[1] for each in (second, first)))
    assert np.abs(np.rad2deg(np.angle(ratio))).max() < 0.2


def test_the_microphone_that_rolls_off_higher_is_left_as_it_is():
    both = np.random.default_rng(0).standard_normal((2, 100)).astype(np.float32)
    matched = RollOffMatch((0.0, 30.0), RATE)(both)
    assert np.array_equal(matched[1], both[1])
    assert matched.dtype == np.float32


@pytest.mark.parametrize("hop", [1, 160, 777])
def test_blocks_of_any_length_give_what_all_at_once_gives(hop):
    both = np.random.default_rng(0).standard_normal((2, 3000))
    match = RollOffMatch((60.0, 25.0), RATE)
    pieces = [match(both[:, first : first + hop]) for first in range(0, both.shape[1], hop)]
    assert np.concatenate(pieces, axis=1) == pytest.approx(RollOffMatch((60.0, 25.0), RATE)(both), abs=1e-12)


def test_what_is_alike_stays_the_same_samples():
    both = np.zeros((2, 10))
    match = RollOffMatch((35.0, 35.0), RATE)
    assert match.none
    assert match(both) is both
