"""The mixture of ITD histograms and the search for its order, on histograms whose truth is put in."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

from examples import in_soak
from ross_payload.angles import difference
from ross_payload.interfaces import Real
from ross_payload.localization import itd_mixture, model_order

STEP = np.deg2rad(15)
HEADINGS, GRID = STEP * np.arange(13), np.linspace(-1.5, 1.5, 61)


def toy(scale: float = 1.0) -> tuple[itd_mixture.Data, itd_mixture.Mixture]:
    headings, grid = STEP * np.arange(5), np.linspace(-1.5, 1.5, 61)
    weights = np.tile([0.5, 0.4, 0.05, 0.05], (5, 1))
    model = itd_mixture.Mixture(np.array([0.3, 2.0]), np.ones(2), np.array([0.1, 0.1]), weights)
    counts = itd_mixture.densities(itd_mixture.Data(grid, headings, np.zeros((5, 61))), model)
    return itd_mixture.Data(grid, headings, 200 * scale * counts), model


def test_the_mixture_is_a_probability() -> None:
    data, model = toy()
    np.testing.assert_allclose(itd_mixture.densities(data, model).sum(axis=1), 1, atol=1e-3)


def test_delays_that_are_longer_than_any_source_may_have_tell_how_much_wider_the_array_is() -> None:
    data, model = toy()
    assert itd_mixture.longer(data, itd_mixture.refine(data, model, 10)) == 1.0
    wide = replace(data, grid=1.1 * data.grid)
    fitted = itd_mixture.refine(wide, model, 10)
    assert itd_mixture.longer(wide, fitted) == pytest.approx(1.1, abs=0.02)
    assert itd_mixture.longer(replace(wide, counts=wide.counts / 1000), fitted) == 1.0  # too little was heard
    assert itd_mixture.longer(replace(wide, amplitudes=(0.4, 0.9)), fitted) == 1.0  # far above them


def test_refining_from_nearby_finds_the_true_azimuths() -> None:
    data, model = toy()
    away = model.azimuths + np.array([0.1, -0.1])
    start = itd_mixture.Mixture(away, np.full(2, 0.9), np.array([0.2, 0.2]), np.full((5, 4), 1 / 4))
    found = itd_mixture.refine(data, start, 60)
    np.testing.assert_allclose(found.azimuths, model.azimuths, atol=np.deg2rad(0.5))
    assert itd_mixture.log_likelihood(data, found) > itd_mixture.log_likelihood(data, start)


def test_four_times_the_evidence_halves_sigma() -> None:
    once, four = toy(1.0), toy(4.0)
    np.testing.assert_allclose(np.array(itd_mixture.sigmas(*once)) / np.array(itd_mixture.sigmas(*four)), 2, rtol=1e-6)


def test_no_source_ever_loses_likelihood_and_the_missing_one_gains_most() -> None:
    data, model = toy()
    gain, share = itd_mixture.gains(
        data, itd_mixture.remove(model, 1), (model_order.GRID, np.ones(len(model_order.GRID))), 0.1, rounds=200
    )
    assert gain.min() > -1e-2
    assert abs(float(difference(model_order.GRID[gain.argmax()], 2.0))) < np.deg2rad(6)
    assert share[:, gain.argmax()].mean() == pytest.approx(0.4, abs=0.1)


def test_a_source_that_explains_everything_gains_what_can_be_counted() -> None:
    azimuth, one, width = np.array([2.0]), np.ones(1), np.array([0.05])
    nothing = itd_mixture.Data(GRID.astype(np.float32), HEADINGS, np.zeros((13, 61), np.float32))
    data = replace(nothing, counts=200 * itd_mixture.kernels(nothing, azimuth, one, width)[:, 0])
    elsewhere = itd_mixture.Mixture(np.array([-0.5]), one, width, np.tile([1 - 2e-7, 1e-7, 1e-7], (13, 1)))
    gain, share = itd_mixture.gains(data, elsewhere, (model_order.GRID, np.ones(len(model_order.GRID))), 0.05)
    assert np.isfinite(gain).all()
    assert abs(float(difference(model_order.GRID[gain.argmax()], 2.0))) < np.deg2rad(6)
    assert np.median(share[:, gain.argmax()]) > 0.99


# ---------------------------------------------------------------------------------------------- amplitudes and rooms


def heard(
    azimuths: Real, amplitudes: Real, shape: tuple[float, float], counts: float, seed: int | None = None
) -> itd_mixture.Data:
    """Counts at 13 headings of equally loud talkers of a width and a diffuse share; expected ones, or drawn.

    A count sums the small weights of four bins.
    """
    k, (width, diffuse) = len(azimuths), shape
    weights = np.tile([*[(0.95 - diffuse) / k] * k, diffuse, 0.05], (len(HEADINGS), 1))
    model = itd_mixture.Mixture(azimuths, amplitudes, np.full(k, width), weights)
    expected = counts * itd_mixture.densities(itd_mixture.Data(GRID, HEADINGS, np.zeros((len(HEADINGS), 61))), model)
    drawn = expected if seed is None else np.random.default_rng(seed).poisson(4 * expected) / 4
    return itd_mixture.Data(GRID, HEADINGS, drawn)


def worst_deg(model: itd_mixture.Mixture, azimuths: Real) -> float:
    apart = np.abs(difference(azimuths[:, None], model.azimuths))
    return float(np.rad2deg(apart[linear_sum_assignment(apart)].max()))


def test_every_talker_keeps_its_own_amplitude() -> None:
    azimuths, amplitudes = np.deg2rad([0.0, 100.0, -130.0]), np.cos(np.deg2rad([60.0, 45.0, 0.0]))
    data = heard(azimuths, amplitudes, (0.06, 0.03), 200)
    start = itd_mixture.Mixture(azimuths + 0.1, np.full(3, 0.8), np.full(3, 0.1), np.full((13, 5), 0.2))
    found = itd_mixture.refine(data, start, 60, tie=0.0)
    np.testing.assert_allclose(found.amplitudes, amplitudes, atol=0.01)
    assert worst_deg(found, azimuths) < 0.5


def test_the_error_of_an_amplitude_is_about_one_sigma() -> None:
    azimuths, amplitudes = np.deg2rad([0.0, 100.0]), np.array([0.7, 0.8])
    scaled = []
    for seed in range(20):
        data = heard(azimuths, amplitudes, (0.06, 0.03), 100, seed)
        start = itd_mixture.Mixture(azimuths, amplitudes, np.full(2, 0.06), np.full((13, 4), 0.25))
        found = itd_mixture.refine(data, start, 20, tie=0.0)
        scaled.append((found.amplitudes - amplitudes) / itd_mixture.sigmas(data, found)[1])
    assert 0.35 < np.sqrt(np.mean(np.square(scaled))) < 0.7  # half of it: a count is four bins


@pytest.mark.parametrize("seed", [0, *in_soak(1, 2)])
@pytest.mark.parametrize("degrees", [(20, -100), (0, 50, 170), (-150, -60, 30, 100)], ids=len)
def test_sources_are_worth_more_than_ghosts_in_a_diffuse_field(degrees: tuple[float, ...], seed: int) -> None:
    """A poor room: ITDs shrunk to 0.82, wide kernels, a fifth of all counts diffuse."""
    azimuths = np.deg2rad(np.array(degrees, dtype=float))
    data = heard(azimuths, np.full(len(azimuths), 0.82), (0.13, 0.2), 60, seed)
    by_order = {len(step.worth): step for step in model_order.steps(data, model_order.Penalty()) if step.possible}
    step = by_order[len(azimuths)]
    assert worst_deg(step.model, azimuths) < 6
    assert step.model.directness == pytest.approx(0.82, abs=0.05)
    assert step.worth.min() >= 1 > max((by_order[k].worth.min() for k in by_order if k > len(azimuths)), default=0)


def test_orders_fall_by_one_to_a_single_source() -> None:
    data = heard(np.deg2rad([0.0, 100.0]), np.ones(2), (0.08, 0.05), 100, seed=1)
    orders = [len(step.worth) for step in model_order.steps(data, model_order.Penalty())]
    assert orders == list(range(orders[0], 0, -1))


def test_sources_do_not_gather_around_a_loud_talker_whose_kernel_fits_badly() -> None:
    """Reflections give his ITDs long tails; the search used to put seven of eight sources into them, at one place."""
    talkers, grid = np.deg2rad([14.0, -120.0]), np.linspace(-1.5, 1.5, 121)
    off = grid - 0.85 * np.cos(talkers[:, None, None] - HEADINGS[:, None])  # (2, n_headings, n_bins)
    kernels = np.exp(-(np.abs(off / 0.12) ** 0.6))
    loud, soft = np.array([30.0, 4.0])[:, None, None] * kernels / kernels.sum(axis=-1, keepdims=True)
    largest = next(model_order.steps(itd_mixture.Data(grid, HEADINGS, loud + soft + 0.02), model_order.Penalty()))
    assert largest.possible
    assert len(largest.worth) < 4
    apart = np.abs(difference(talkers[:, None], largest.model.azimuths)).min(axis=1)
    assert np.rad2deg(apart).max() < 3


def test_so_many_sources_are_fitted_as_are_told() -> None:
    data = heard(np.deg2rad([0.0, 100.0, -130.0]), np.ones(3), (0.08, 0.05), 100)
    assert [len(step.worth) for k in (2, 3) if (step := model_order.search(data, model_order.Penalty(), k))] == [2, 3]


def test_nothing_heard_is_no_source() -> None:
    assert model_order.search(heard(np.zeros(1), np.ones(1), (0.1, 0.95), 0.0), model_order.Penalty(), 2) is None


def test_a_room_is_wet_when_itds_are_drawn_to_0_and_spread() -> None:
    def wetness(amplitude: float, width: float) -> float:
        weights = np.full((1, 3), 1 / 3)
        model = itd_mixture.Mixture(np.zeros(1), np.ones(1), np.full(1, width), weights, amplitude)
        return model_order.wetness(heard(np.zeros(1), np.ones(1), (0.1, 0.95), 0.0), model)

    assert wetness(0.8, 0.13) == 1
    assert wetness(1.0, 0.13) == 0  # the paper's plane
    assert wetness(0.7, 0.06) == 0  # talkers far below, in the open


def test_a_source_between_two_true_ones_is_put_right() -> None:
    azimuths = np.deg2rad([0.0, 30.0, 150.0])
    data = heard(azimuths, np.ones(3), (0.08, 0.05), 100)
    merged = itd_mixture.Mixture(np.deg2rad([15.0, 150.0, -90.0]), np.ones(3), np.full(3, 0.15), np.full((13, 5), 0.2))
    merged = itd_mixture.refine(data, merged, 10)
    assert worst_deg(merged, azimuths) > 10
    assert worst_deg(model_order.rearrange(data, merged, model_order.Penalty()), azimuths) < 3


def test_the_likelihood_never_falls_by_refining_without_ties() -> None:
    data, model = toy()
    start = itd_mixture.Mixture(model.azimuths + 0.05, np.full(2, 0.9), np.full(2, 0.15), np.full((5, 4), 0.25))
    better = itd_mixture.refine(data, start, 10)
    assert itd_mixture.log_likelihood(data, better) > itd_mixture.log_likelihood(data, start)
