"""Phases of bins that several talkers share: densities against quadrature and against summed cross-spectra."""

import math

import numpy as np
import pytest

from examples import in_soak
from ross_payload.events import Estimate, SourceEstimate
from ross_payload.localization import tracking
from ross_payload.localization.phase_likelihood import GROUP, Scene, likelihood
from ross_payload.localization.phase_statistics import HEARING, FrameStatistics
from ross_payload.localization.talker_motion import AZIMUTHS

UNIT = 0.05 / 343.0


def bins(frequencies, phases, heading=0.0, weights=None):
    n = len(phases)
    frequencies = np.broadcast_to(np.asarray(frequencies, float), n)
    weights = np.full(n, 0.3) if weights is None else weights
    return FrameStatistics(0.25, np.array([heading]), np.zeros(n, np.intp), frequencies, np.asarray(phases), weights)


def scene(*degrees):
    k = len(degrees)
    return Scene(UNIT, np.radians(degrees), np.ones(k), np.full(k, 1 / k), wet=False, amplitude=1.0)


@pytest.mark.parametrize("frequency", [400.0, 1500.0, 5000.0])
def test_densities_of_a_phase_integrate_to_one_for_every_azimuth_and_for_nobody(frequency):
    phases = (np.arange(HEARING.used) + 0.5) / HEARING.used * 2 * np.pi - np.pi
    found = likelihood(bins(frequency, phases), scene(40.0, 130.0), HEARING)
    for density in (*found.density, found.nobody[:, None]):
        assert 2 * np.pi * density.mean(axis=0) == pytest.approx(1.0, abs=0.02)


def test_a_bin_that_another_talker_shares_still_speaks_for_its_own():
    """With 38 % of the power the other draws the phase three standard deviations towards its own."""
    own, other, frequency = math.radians(60.0), math.radians(150.0), 600.0
    turned = 2 * np.pi * frequency * UNIT
    mixed = np.angle(0.62 * np.exp(1j * turned * np.cos(own)) + 0.38 * np.exp(1j * turned * np.cos(other)))
    heard = bins(frequency, np.full(GROUP, mixed))
    at = int(np.abs(AZIMUTHS - own).argmin())

    def density(*degrees):
        found = likelihood(heard, scene(*degrees), HEARING)
        return found.density[0][0, found.case[0][at]]

    assert density(60.0, 150.0) > 1.5 * density(60.0)
    assert density(60.0, 150.0) > 1.5 * density(60.0, 20.0)  # on the other side nobody draws it there


def test_bins_drawn_evenly_count_as_much_as_all():
    rng = np.random.default_rng(0)
    heard = bins(rng.uniform(300, 8000, 250), rng.uniform(-3, 3, 250), weights=rng.uniform(0.01, 1.0, 250))
    drawn = heard.evenly(160, GROUP)
    assert len(drawn.weights) == 160
    assert drawn.weights.sum() == pytest.approx(heard.weights.sum())
    assert np.ptp(drawn.weights) == 0.0
    mean = np.average(heard.frequencies, weights=heard.weights)
    assert drawn.frequencies.mean() == pytest.approx(mean, rel=0.02)


def rested(told, drawn, azimuths=(40.0, -115.0), heading=0.1):
    """Tracks after five seconds of talkers at rest; reflections draw their delays to 0 by ``drawn``."""
    sources = tuple(SourceEstimate(math.radians(a), math.radians(1.0), 1.0, resolved=True) for a in azimuths)
    tracks, rng = (
        tracking.begin(Estimate(sources, certain=True, directness=told), 0.05, 343.0),
        np.random.default_rng(0),
    )
    for _ in range(20):
        turned = 2 * np.pi * rng.uniform(300, 6000, 80) * UNIT
        delay = drawn * np.cos(np.radians(rng.choice(azimuths, 80)) - heading)
        phases = turned * delay + 0.15 * np.sqrt(turned) * rng.standard_normal(80)
        heard = bins(turned / (2 * np.pi * UNIT), np.angle(np.exp(1j * phases)), heading, np.ones(80))
        tracks = tracking.step(tracks, heard)
    return tracks


@pytest.mark.parametrize("directness", [0.7, *in_soak(0.8, 0.9)])
def test_nobody_leaves_when_reflections_draw_delays_to_zero_as_the_exploration_has_told(directness):
    """Of what is not direct three quarters draw the delays (measured in simulated rooms, decision 115)."""
    drawn = 1 - 0.75 * (1 - directness)
    stays = [each.weight for each in rested(directness, drawn).hypotheses if not each.members]
    assert stays
    assert stays[0] > 0.5
    left = sum(each.weight for each in rested(1.0, drawn).hypotheses if each.members)
    assert left > 0.9  # who is told of the open takes the same delays for those of somebody elsewhere


def test_where_somebody_rests_is_heard_within_what_was_told():
    """Told 3 degrees beside where it is: heard there after seconds, and nobody is taken to have left."""
    sources = tuple(SourceEstimate(math.radians(a), math.radians(2.0), 1.0, resolved=True) for a in (100.0, -60.0))
    tracks = tracking.begin(Estimate(sources, certain=True, directness=1.0), 0.05, 343.0)
    rng, heading = np.random.default_rng(0), 0.6
    for _ in range(20):
        frequencies = rng.uniform(300, 6000, 80)
        turned = 2 * np.pi * frequencies * UNIT
        delay = np.cos(np.radians(rng.choice([103.0, -60.0], 80)) - heading)
        phases = turned * delay + 0.12 * np.sqrt(turned) * rng.standard_normal(80)
        tracks = tracking.step(tracks, bins(frequencies, np.angle(np.exp(1j * phases)), heading))
    assert np.degrees(tracks.azimuths) == pytest.approx([103.0, -60.0], abs=1.5)
    stays = [each for each in tracks.hypotheses if not each.members]
    assert stays
    assert stays[0].weight > 0.5
