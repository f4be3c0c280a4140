"""Densities of ITDs."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import find_peaks

from ross_payload.dsp.density import histogram, itd_grid, kde, prominent_peaks

GRID = itd_grid(0.05, 343.0)
UNIT = 0.05 / 343.0

inside = st.lists(st.tuples(st.floats(-1.49, 1.49), st.floats(0.01, 10)), min_size=1, max_size=30)


@given(inside)
def test_a_histogram_keeps_all_weight_and_the_mean(points: list[tuple[float, float]]) -> None:
    itd, weight = np.array(points).T
    counts = histogram(itd * UNIT, weight, GRID)
    assert counts.sum() == pytest.approx(weight.sum())
    assert (counts * GRID).sum() / UNIT == pytest.approx((itd * weight).sum(), abs=1e-9)


def test_what_is_impossible_is_lost() -> None:
    assert histogram(np.array([2.0, -1.6]) * UNIT, np.ones(2), GRID).sum() == 0


@given(inside)
def test_a_density_sums_to_1_and_is_never_negative(points: list[tuple[float, float]]) -> None:
    itd, weight = np.array(points).T
    density = kde(histogram(itd * UNIT, weight, GRID), GRID, 0.04 * UNIT)
    assert density.sum() == pytest.approx(1)
    assert density.min() >= 0


def test_silence_has_no_density_and_no_peak() -> None:
    density = kde(np.zeros(len(GRID)), GRID, 0.04 * UNIT)
    assert density.max() == 0
    assert prominent_peaks(density, GRID) == ()


def test_two_talkers_make_two_peaks_and_the_louder_comes_first() -> None:
    rng = np.random.default_rng(0)
    itd = np.concatenate([rng.normal(-0.7, 0.05, 1000), rng.normal(0.4, 0.05, 2000)]) * UNIT
    density = kde(histogram(itd, np.ones(3000), GRID), GRID, 0.04 * UNIT)
    np.testing.assert_allclose(np.array(prominent_peaks(density, GRID)) / UNIT, [0.4, -0.7], atol=0.06)


@pytest.mark.parametrize("edge", [0, -1])
def test_a_talker_at_the_very_end_of_the_grid_is_a_peak(edge: int) -> None:
    density = np.zeros(len(GRID))
    density[edge] = 1.0
    assert prominent_peaks(density, GRID) == (GRID[edge],)


levels = st.lists(st.one_of(st.integers(0, 4).map(float), st.floats(0, 4)), min_size=1, max_size=40)


@given(levels, st.floats(0.01, 1.0))
def test_peaks_are_those_of_scipy(values: list[float], prominence: float) -> None:
    density, grid = np.array(values), np.arange(len(values), dtype=float)
    padded = np.pad(density, 1)
    peaks, _ = find_peaks(padded, prominence=prominence * density.max())
    wanted = sorted((peak - 1 for peak in peaks), key=lambda peak: -density[peak]) if density.max() > 0 else ()
    assert prominent_peaks(density, grid, prominence) == tuple(float(peak) for peak in wanted)
