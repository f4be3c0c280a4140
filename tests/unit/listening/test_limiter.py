"""The limiter and the level of what is heard."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ross_payload.listening.limiter import CEILING, LevelMeter, Limiter

RATE = 16000


def tone(level, seconds=0.5, frequency=300.0):
    return (level * np.sin(2 * np.pi * frequency * np.arange(round(seconds * RATE)) / RATE)).astype(np.float32)


def blocks(samples, size=256):
    return np.split(samples, range(size, len(samples), size))


def limited(samples, size=256):
    limiter = Limiter(RATE)
    return np.concatenate([limiter.limited(block) for block in blocks(samples, size)])


def test_what_is_below_the_ceiling_is_not_touched():
    quiet = tone(0.85)
    assert np.array_equal(limited(quiet), quiet)


@given(st.floats(0.9, 1e4), st.integers(1, 700))
def test_nothing_exceeds_the_ceiling(level, size):
    assert np.abs(limited(tone(level, 0.05), size)).max() <= CEILING * (1 + 1e-6)


def test_the_size_of_the_blocks_does_not_matter():
    loud = tone(3.0)
    assert limited(loud, 100) == pytest.approx(limited(loud, 333), abs=1e-6)


def test_the_gain_comes_back_slowly():
    after = limited(np.concatenate([tone(8.0, 0.1), tone(0.1, 2.0)]))[round(0.1 * RATE) :]
    early, late = after[: RATE // 100 * 5], after[-RATE // 10 :]
    assert np.abs(early).max() < 0.05  # still turned down, by most of 19 dB
    assert np.abs(late).max() == pytest.approx(0.1, rel=0.01)


def test_silence_stays_silence():
    assert not limited(np.zeros(1000, np.float32)).any()


def test_the_level_is_that_of_the_last_second():
    meter = LevelMeter(RATE)
    assert meter.level_db is None
    for block in blocks(np.concatenate([tone(1.0, 3.0), tone(0.1, 1.1)])):
        meter.add(block)
    assert meter.level_db == pytest.approx(-23.01, abs=0.05)
    meter.add(np.zeros(2 * RATE, np.float32))
    assert meter.level_db == -120


def test_the_gain_comes_back_without_a_jump():
    """Of what is steady nothing but the fade is heard: e^(1 / (0.2 s rate)) from one sample to the next."""
    steady = limited(np.concatenate([np.full(10, 8.0), np.full(3 * RATE, 0.5)]).astype(np.float32))[10:]
    assert steady[-1] == 0.5
    assert np.diff(np.log(steady)).max() < 2.2 / (0.2 * RATE)  # it is 19 dB, 2.2 in logarithms, that fade
