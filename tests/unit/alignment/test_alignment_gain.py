"""How much a heading gains: claims about the prediction."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ross_payload.alignment.predicted_gain import BETWEEN, ECHOES, FINE, best_headings, predicted_gain

angles = st.floats(-np.pi, np.pi)
layouts = st.lists(angles, min_size=2, max_size=5)
shares = st.floats(0, 1)


@given(layouts, angles, shares)
def test_half_a_turn_changes_no_gain(azimuths: list[float], heading: float, directness: float) -> None:
    front, back = predicted_gain(azimuths, [heading, heading + np.pi], directness=directness).T
    np.testing.assert_allclose(front, back, atol=1e-9)


@given(layouts, angles)
def test_the_gain_stays_between_posing_as_one_and_the_echoes(azimuths: list[float], heading: float) -> None:
    gain = predicted_gain(azimuths, [heading])
    assert (gain >= -10 * np.log10(1 + ECHOES[1] + BETWEEN[1]) - 1e-9).all()
    assert (gain <= -10 * np.log10(ECHOES[1])).all()


@given(angles, angles, st.floats(-np.pi, np.pi))
def test_a_third_talker_where_the_second_is_changes_nothing(target: float, other: float, heading: float) -> None:
    """In reverberation: the mean leak is that of either, and interferers that pose as one gain nothing by it."""
    two = predicted_gain([target, other], [heading])[0]
    three = predicted_gain([target, other, other], [heading])[0]
    np.testing.assert_allclose(two, three, atol=1e-9)


@given(layouts, angles)
def test_the_open_promises_more_than_reverberation(azimuths: list[float], heading: float) -> None:
    dry, wet = (predicted_gain(azimuths, [heading], directness=directness) for directness in (1.0, 0.0))
    assert (dry > wet).all()
    np.testing.assert_array_equal(wet, predicted_gain(azimuths, [heading]))


@given(angles, angles)
def test_two_talkers_are_best_heard_along_their_chord(a: float, b: float) -> None:
    """cos(a - phi) - cos(b - phi) is greatest across the bisector: phi = (a + b) / 2 + 90 deg."""
    if abs(np.sin((a - b) / 2)) > 0.05:
        assert abs(np.cos(best_headings([a, b]) - (a + b) / 2)).max() <= np.sin(FINE)


@given(layouts, shares)
def test_no_heading_is_better_than_the_best_of_the_grid(azimuths: list[float], directness: float) -> None:
    finer = np.arange(0, np.pi, FINE / 8)
    best = best_headings(azimuths, directness=directness)
    found = np.diagonal(predicted_gain(azimuths, best, directness=directness))
    assert (found >= predicted_gain(azimuths, finer, directness=directness).max(axis=1) - 0.05).all()


def test_someone_straight_below_gains_by_turning_the_axis_to_the_other() -> None:
    best = best_headings([0.7, 0.0], elevations=[0.0, -np.pi / 2])
    assert best == pytest.approx([0.7, 0.7], abs=FINE)


def test_a_single_source_has_nothing_to_gain() -> None:
    assert predicted_gain([1.0], [0.0, 1.0]).tolist() == [[0.0, 0.0]]
    assert predicted_gain([], [0.0]).shape == (0, 1)


def test_posing_as_one_pays_in_the_open_only() -> None:
    """Target at 0, interferers at 90 and -90 deg: one TDOA at heading 0, two that are 0.2 d / v_p apart at 5.7 deg."""
    azimuths, headings = np.deg2rad([0, 90, -90]), [0.0, np.arcsin(0.1)]
    wet, dry = (np.diff(predicted_gain(azimuths, headings, directness=share)[0])[0] for share in (0.0, 1.0))
    assert abs(wet) < 0.2
    assert dry < -0.5


def test_interferers_on_either_side_leak_more_than_the_same_two_on_one_side() -> None:
    """TDOAs 0.5 and -0.5 around 0, and twice 0.5: equally far, but the first two can sound like somebody at 0."""
    either = predicted_gain([np.pi / 2, np.pi / 3, 2 * np.pi / 3], [0.0])[0]
    one = predicted_gain([np.pi / 2, np.pi / 3, -np.pi / 3], [0.0])[0]
    assert (one > either + 0.2).all()


def test_the_directness_that_an_explorer_finds_in_a_room_is_not_the_open() -> None:
    azimuths, headings = np.deg2rad([0, 100, -120]), np.deg2rad([0, 30, 60])
    room, unknown = (predicted_gain(azimuths, headings, directness=share) for share in (0.98, None))
    np.testing.assert_array_equal(room, unknown)
