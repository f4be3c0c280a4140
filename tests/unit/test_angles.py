import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ross_payload.angles import circular_mean, difference, wrap, wrap_axis

ANGLES = st.floats(-50, 50)


@given(ANGLES)
def test_wrapping_keeps_the_direction_and_lands_in_the_interval(angle):
    wrapped = wrap(angle)
    assert -np.pi < wrapped <= np.pi
    assert np.exp(1j * wrapped) == pytest.approx(np.exp(1j * angle), abs=1e-9)


@given(ANGLES)
def test_an_axis_is_the_same_after_half_a_turn(angle):
    assert abs(difference(2 * wrap_axis(angle), 2 * wrap_axis(angle + np.pi))) < 1e-9


def test_the_mean_of_directions_around_the_seam_lies_on_the_seam():
    assert abs(circular_mean([np.pi - 0.1, -np.pi + 0.1])) == pytest.approx(np.pi)
