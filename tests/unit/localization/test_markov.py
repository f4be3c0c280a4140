"""Algorithm 1: peaks, binary hypothesis tests, the Markov chain over rotations, K-means with inertia.

Truth is geometry: a source at azimuth theta is heard at (d / v_p) cos(theta - heading).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from examples import examples
from ross_payload import plugins
from ross_payload.angles import difference
from ross_payload.dsp.density import itd_grid
from ross_payload.dsp.stft import Stft
from ross_payload.errors import ConfigError
from ross_payload.events import Estimate
from ross_payload.interfaces import Observation, Real, Score, VoicePrint
from ross_payload.localization import clusters, front_back_test
from ross_payload.localization.markov import Markov
from ross_payload.localization.markov_explorer import explorer, plain

SPACING, SPEED = 0.05, 343.0
UNIT = SPACING / SPEED
GRID = itd_grid(SPACING, SPEED, 241)
WIDTH = 0.03  # of a peak [d / v_p]
MARKOV: Markov = explorer.make(SPACING, SPEED)


def heard(azimuths: Real, heading: float) -> Observation:
    """An orientation without noise: a peak at the exact ITD of every source; sources of one ITD are one peak."""
    itds = UNIT * np.unique(np.cos(azimuths - heading).round(9))
    density = np.exp(-0.5 * ((GRID[:, None] - itds) / (WIDTH * UNIT)) ** 2).sum(axis=1)
    return Observation(heading, GRID, density / density.sum(), 100.0, tuple(itds.tolist()))


def believe(azimuths_deg: list[float], headings_deg: list[float]) -> Estimate:
    azimuths = np.deg2rad(azimuths_deg)
    return MARKOV.estimate([heard(azimuths, float(heading)) for heading in np.deg2rad(headings_deg)])


def found_deg(estimate: Estimate) -> list[float]:
    return sorted(float(np.rad2deg(source.azimuth).round(3)) for source in estimate.sources)


STEPS = [15.0 * r for r in range(13)]
PAPER = [170.0, 70.0, -50.0, -120.0, 10.0]


@pytest.mark.parametrize("k", [1, 2, 3, 4])
def test_exact_itds_give_the_exact_azimuths_of_the_paper(k: int) -> None:
    assert found_deg(believe(PAPER[:k], STEPS)) == pytest.approx(sorted(PAPER[:k]), abs=0.01)


@pytest.mark.parametrize(
    "headings",
    [
        [0, 15, 30, 15, 0, -15, -30, -15],
        [0, -15, -30, -45, -60],
        [0, 40, 10, 70, 25, 100],
        [200, 215, 230, 245, 260],
        [0, 15, 15, 30, 210, 225, 240],
    ],
    ids=["back and forth", "clockwise", "uneven", "from the back", "with rests and half a turn"],
)
def test_any_schedule_gives_the_exact_azimuths(headings: list[float]) -> None:
    assert found_deg(believe([100.0, -40.0], headings)) == pytest.approx([-40, 100], abs=0.01)


@settings(max_examples=examples(60))
@given(azimuth=st.floats(-179, 179), rotation=st.floats(10, 80), start=st.floats(-180, 180), back=st.booleans())
def test_one_source_and_one_rotation_tell_front_from_back(
    azimuth: float, rotation: float, start: float, back: bool
) -> None:
    turned = start + (-rotation if back else rotation)
    local = [abs(np.sin(np.deg2rad(azimuth - heading))) for heading in (start, turned)]
    assume(min(local) > 0.3)  # along the axis front and back are one place
    (source,) = believe([azimuth], [start, turned]).sources
    assert source.resolved
    assert abs(np.rad2deg(difference(source.azimuth, np.deg2rad(azimuth)))) < 0.01


def test_talkers_that_mirror_each_other_are_one_at_first_and_two_after_turning() -> None:
    assert believe([30.0, -30.0], [0.0]).k == 1
    assert found_deg(believe([30.0, -30.0], STEPS)) == pytest.approx([-30, 30], abs=0.01)


def test_one_orientation_has_magnitudes_only() -> None:
    (source,) = believe([-60.0], [0.0]).sources
    assert not source.resolved
    assert np.cos(source.azimuth) == pytest.approx(0.5)


def test_a_half_turn_cannot_tell_front_from_back() -> None:
    assert not any(source.resolved for source in believe([60.0], [0.0, 180.0]).sources)


def test_nobody_heard_is_nobody() -> None:
    assert MARKOV.estimate([]) == Estimate(())
    silent = MARKOV.observe(np.zeros((2, 257, 50), complex), np.linspace(0, 8000, 257), 0.0, None)
    assert (silent.weight, silent.peaks) == (0.0, ())
    assert MARKOV.estimate([silent] * 3).k == 0


@pytest.mark.parametrize("noise_psd", [None, np.full(257, 256.0)], ids=["unknown noise", "measured noise"])
def test_noise_alone_is_nobody(noise_psd: Real | None) -> None:
    """White noise of variance 1 has the PSD sum of the squared window, 256."""
    stft, rng = Stft(16000, 512, 128), np.random.default_rng(0)
    observations = [
        MARKOV.observe(stft.analyse(rng.standard_normal((2, 48000))), stft.frequencies, heading, noise_psd)
        for heading in np.deg2rad(STEPS[:5])
    ]
    assert MARKOV.estimate(observations) == Estimate(())


def test_the_stop_rule_waits_until_k_has_not_changed_twice() -> None:
    assert [believe([100.0, -40.0], STEPS[:n]).certain for n in (1, 2, 3, 4)] == [False, False, False, True]


def test_half_a_turn_in_total_is_enough_even_for_nobody_new() -> None:
    back_and_forth = [0.0, 45.0, 0.0, 45.0, 0.0]
    assert believe([100.0, -40.0], back_and_forth).certain


def test_everything_turns_with_the_frame() -> None:
    before = found_deg(believe(PAPER[:3], STEPS[:6]))
    after = believe([azimuth + 35 for azimuth in PAPER[:3]], [heading + 35 for heading in STEPS[:6]])
    turned = np.sort([np.rad2deg(difference(s.azimuth, np.deg2rad(35))) for s in after.sources])
    np.testing.assert_allclose(turned, before, atol=0.01)


# ---------------------------------------------------------------------------------------------------- one step


def test_the_higher_density_at_the_predicted_itd_wins() -> None:
    """From +-60 deg, a turn of 30 deg: a source in front moves to cos 30, one behind to cos 90."""
    before = Observation(0.0, GRID, np.ones_like(GRID), 1.0, (0.5 * UNIT,))
    for itd, azimuth in ((np.cos(np.pi / 6), 60.0), (0.0, -60.0)):
        density = np.exp(-0.5 * ((GRID / UNIT - itd) / WIDTH) ** 2)
        after = Observation(np.pi / 6, GRID, density, 1.0, (itd * UNIT,))
        (vote,) = front_back_test.decided(before, after, 1, UNIT, power=0.0)
        assert np.rad2deg(difference(vote.azimuth, 0.0)) == pytest.approx(azimuth)


# ---------------------------------------------------------------------------------------------------- clusters


@given(st.lists(st.floats(0, 6), min_size=1, max_size=7), st.integers(1, 4))
def test_no_partition_of_the_line_has_less_inertia(points: list[float], k: int) -> None:
    line = np.sort(points)
    inertia, _ = clusters.best_cuts(line, np.ones(len(line)), k)
    k = min(k, len(line))
    rng = np.random.default_rng(0)
    for _ in range(20):
        label = rng.integers(k, size=len(line))
        other = sum(((line[label == j] - line[label == j].mean()) ** 2).sum() for j in set(label.tolist()))
        assert inertia[k - 1] <= other + 1e-9


@given(st.integers(1, 6), st.floats(-10, 10))
def test_clusters_far_apart_are_counted_wherever_the_circle_is_cut(k: int, turn: float) -> None:
    rng = np.random.default_rng(k)
    centres = turn + 2 * np.pi * np.arange(k) / k
    points = (centres[:, None] + 0.02 * rng.uniform(-1, 1, (k, 5))).ravel()
    found = clusters.k_means(points, np.ones(len(points)), 0.03, 12)
    assert len(found) == k
    assert all(np.abs(difference(centres, cluster.mean)).min() < 0.02 for cluster in found)


# ------------------------------------------------------------------------------------------------------- seams


@pytest.mark.parametrize(("spacing", "speed"), [(0.0, 343.0), (0.05, -1.0), (np.nan, 343.0)])
def test_an_impossible_array_is_refused(spacing: float, speed: float) -> None:
    with pytest.raises(ConfigError, match="positive"):
        explorer.make(spacing, speed)


@pytest.mark.parametrize("name", ["markov", "markov-plain"])
def test_it_is_a_plug_in(name: str) -> None:
    assert plugins.load("ross_payload.explorers", name).make(SPACING, SPEED).name == name


@pytest.mark.parametrize(("setting", "t60"), [(1, 0.0), (2, 0.45), (3, 0.7)])
def test_the_paper_preset_has_the_papers_numbers(setting: int, t60: float) -> None:
    from ross_payload.service.assemble import tools_of
    from ross_sim.scenario import load

    scenario = load(f"paper-setting-{setting}")
    config = scenario.payload
    explorer_stft = tools_of(config, Deaf()).explorer_stft
    assert (scenario.room.t60_s, scenario.noise.snr_db, config.audio.rate_hz) == (t60, 15, 24000)
    assert (explorer_stft.frame, explorer_stft.hop) == (1024, 768)  # neighbours share 25 %
    assert config.explore.step_deg * config.explore.max_rotations == 180
    assert (config.guard.max_speed_deg_s, config.guard.max_acceleration_deg_s2) == (225, 112.5)
    assert (config.exploit.separator, config.exploit.rules) == ("paper", "paper")


@pytest.mark.parametrize("frame", [512, 1024])
@pytest.mark.parametrize("rate", [16000, 24000])
def test_frames_of_the_paper_tell_the_itd_of_a_plane_wave(frame: int, rate: int) -> None:
    """White noise from 60 deg, 3 s, half of d / v_p: delayed in the frequency domain."""
    stft = Stft(rate, frame, frame * 3 // 4)
    spectrum = np.fft.rfft(np.random.default_rng(0).standard_normal(3 * rate))
    delay = np.exp(2j * np.pi * np.fft.rfftfreq(3 * rate, 1 / rate) * UNIT / 2)
    samples = np.fft.irfft(np.stack([spectrum, spectrum * delay]), 3 * rate)
    seen = plain.make(SPACING, SPEED).observe(stft.analyse(samples), stft.frequencies, 0.0, None)
    assert seen.peaks[0] == pytest.approx(UNIT / 2, abs=0.02 * UNIT)
    assert seen.density.sum() == pytest.approx(1)


def test_loudness_does_not_matter() -> None:
    rng, frequencies = np.random.default_rng(1), np.linspace(0, 8000, 257)
    voice = rng.standard_normal((257, 200)) ** 3 * np.exp(2j * np.pi * rng.random((257, 200)))
    heard_at = np.stack([voice, voice * np.exp(2j * np.pi * frequencies[:, None] * UNIT / 2)])
    loud, soft = (MARKOV.observe(gain * heard_at, frequencies, 0.0, None) for gain in (100.0, 0.01))
    assert loud.peaks
    np.testing.assert_allclose(loud.peaks, soft.peaks, rtol=1e-6)


@pytest.mark.soak
def test_real_talkers_in_the_papers_rooms_are_counted_and_placed(speech: Path) -> None:
    """K unknown, 2 to 5; 12 rotations, T_unit 3 s; K right and all within 10 deg in .79 / .34 / .34 of the scenes."""
    from ross_sim.study.runs.study_case import perform
    from ross_sim.study.runs.study_design import chosen, tasks
    from ross_sim.study.runs.talker_placement import Source
    from ross_sim.study.scenes.mixtures import VOICES
    from ross_sim.study.scenes.room_settings import PLANES

    axes = {"settings": PLANES, "explorers": ("markov",), "rotations": (12,), "seed": 2}
    study = chosen("exploration", axes, quick=False)
    source = Source(speech, VOICES, study.rate_hz)
    last = [perform(task, study, source).explorations[-1] for task in tasks(study)]
    shares = [np.mean([row.right for row in last if row.setting == setting]) for setting in PLANES]
    assert np.all(np.array(shares) >= [0.79, 0.34, 0.34]), shares


class Deaf(VoicePrint):
    """A voice print that knows nobody."""

    def score(self, voice: Real, rate: int) -> Score:
        return Score(0.0, accepted=False)
