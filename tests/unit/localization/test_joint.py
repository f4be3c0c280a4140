"""The joint explorer: K and every azimuth from all orientations at once.

Scenes are plane waves: every source rules some bins for some frames, as talkers do, and each microphone adds noise of
its own. Truth is the azimuth that was put in.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

from examples import in_soak
from ross_payload.angles import difference
from ross_payload.dsp.stft import Stft
from ross_payload.errors import ConfigError
from ross_payload.events import Estimate
from ross_payload.interfaces import Complex, Observation, Real
from ross_payload.localization.joint import Joint, Stop, explorer, overdispersion
from ross_payload.mission.reconsideration import DROPPED
from ross_payload.plugin_checks import checked_explorer

pytestmark = pytest.mark.lockstep

SPACING, SPEED = 0.05, 343.0
RATE = 16000
STFT = Stft(RATE, 512, 128)
BAND = slice(10, 115)
STEP = np.deg2rad(15)


def scene(
    azimuths: Real,
    heading: float,
    rng: np.random.Generator,
    noise: float = 0.1,
    amplitudes: Real | float = 1.0,
    *,
    n_frames: int = 240,
) -> Complex:
    """Spectrogram (2, n_freqs, n_frames): bursts of 10 frames, each bin of each burst is ruled by one source."""
    frequencies = STFT.frequencies
    shape = (len(frequencies), n_frames)
    heard: Complex = noise * rng.standard_normal((2, *shape, 2)).view(np.complex128)[..., 0]
    if len(azimuths):
        ruler = np.repeat(rng.integers(len(azimuths), size=(shape[0], n_frames // 10)), 10, axis=1)
        burst = np.repeat(rng.standard_normal((shape[0], n_frames // 10)) ** 3, 10, axis=1)
        voice = burst * np.exp(2j * np.pi * rng.random(shape))
        tau = SPACING / SPEED * amplitudes * np.cos(azimuths - heading)
        heard = heard + np.stack([voice, voice * np.exp(2j * np.pi * frequencies[:, None] * tau[ruler])])
    return heard


def listen(
    azimuths: list[float],
    n_headings: int,
    seed: int = 0,
    noise: float = 0.1,
    start: float = 0.0,
    *,
    n_frames: int = 240,
    wider: float = 1.0,
) -> list[Observation]:
    rng, joint = np.random.default_rng(seed), explorer.make(SPACING, SPEED)
    headings = start + STEP * np.arange(n_headings)
    psd = np.full(len(STFT.frequencies), 2 * noise**2)
    heard = (scene(np.array(azimuths), heading, rng, noise, wider, n_frames=n_frames) for heading in headings)
    return [joint.observe(each, STFT.frequencies, phi, psd) for each, phi in zip(heard, headings, strict=True)]


def believe(observations: list[Observation]) -> Estimate:
    return explorer.make(SPACING, SPEED).estimate(observations)


def errors_deg(estimate: Estimate, azimuths: list[float]) -> Real:
    found = np.array([source.azimuth for source in estimate.sources])
    apart = np.abs(difference(np.array(azimuths)[:, None], found))
    return np.rad2deg(apart[linear_sum_assignment(apart)])


LAYOUTS = [
    [1.0],
    list(np.deg2rad([20, -100])),
    list(np.deg2rad([0, 40, 170])),
    list(np.deg2rad([-150, -60, 30, 100])),
    list(np.deg2rad([-150, -80, 10, 60, 130])),
]


@pytest.mark.parametrize("seed", [0, 1, *in_soak(2, 3, 4, 5)])
def test_a_talker_on_the_axis_hardly_votes_for_its_other_end(seed: int) -> None:
    azimuth = float(4 * STEP)
    (on_axis,) = listen([azimuth], 1, seed, start=azimuth)
    votes, itd = on_axis.features.blocks.sum(axis=0), on_axis.grid * SPEED / SPACING
    assert itd[votes.argmax()] > 0.9
    assert votes[itd < -0.8].sum() < 0.001 * votes.sum()


@pytest.mark.parametrize("azimuths", [*LAYOUTS[:3:2], *in_soak(LAYOUTS[4], *LAYOUTS[1::2])], ids=len)
def test_every_talker_is_counted_and_placed(azimuths: list[float]) -> None:
    estimate = believe(listen(azimuths, 9))
    assert estimate.k == len(azimuths)
    assert errors_deg(estimate, azimuths).max() < 3
    assert all(source.resolved and source.confidence > 0.5 for source in estimate.sources)
    assert estimate.rival is None  # a clear scene has no second explanation


@pytest.mark.parametrize("wider", [1.06, 1.12])
def test_an_array_that_is_wider_than_configured_has_no_sources_where_nobody_is(wider: float) -> None:
    azimuths = LAYOUTS[2]
    heard = listen(azimuths, 9, wider=wider)
    estimate = believe(heard)
    assert estimate.k == len(azimuths)
    assert errors_deg(estimate, azimuths).max() < 1.5
    again = explorer.make(SPACING, SPEED).reconsider(heard, estimate)
    assert again is not None
    assert errors_deg(again, azimuths).max() < 1.5


@pytest.mark.parametrize("n_headings", [1, 4, 9])
def test_an_array_that_is_as_configured_is_not_taken_for_wider(
    n_headings: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    heard = listen(LAYOUTS[2], n_headings)
    estimate = believe(heard)
    monkeypatch.setattr("ross_payload.localization.joint.WIDENED", 0)
    assert believe(heard) == estimate


@pytest.mark.parametrize(
    ("azimuths", "noise"), [([170, 70, -50], 4.0), pytest.param([0, 30, 60, 90], 1.5, marks=pytest.mark.soak)]
)
def test_where_k_is_in_doubt_the_second_explanation_has_who_is_missed_and_the_best_one_stays(
    azimuths: list[float], noise: float
) -> None:
    there = list(np.deg2rad(azimuths))
    heard = listen(there, 5, noise=noise, n_frames=360)
    estimate = believe(heard)
    assert estimate.rival is not None
    assert (estimate.k, estimate.rival.k, estimate.rival.rival) == (len(there) - 1, len(there), None)
    assert not estimate.certain
    assert errors_deg(estimate.rival, there).max() < 5
    trusting = replace(explorer.make(SPACING, SPEED), enough=Stop(doubt=1.0))
    assert trusting.estimate(heard) == replace(estimate, rival=None)


def test_an_exploration_goes_on_while_more_talkers_are_likelier_than_a_few_percent() -> None:
    """Three talkers of whom the mixture of four says 0.03 to 0.1, which would have been enough once."""
    heard, joint = listen(LAYOUTS[2], 9), explorer.make(SPACING, SPEED)
    fit = joint._counted(joint.evidence(heard))
    assert fit is not None
    for more, certain in ((0.02, True), (0.03, False), (0.1, False)):
        doubtful = replace(fit, more=more)
        sources = joint.estimate(heard).sources
        assert joint._certain(joint.evidence(heard).rich, doubtful, sources) is certain


def test_talkers_below_are_placed_and_their_elevation_is_told() -> None:
    """At 45 deg below, an estimator that ignores elevation takes cos 45 deg for an azimuth."""
    azimuths, elevations, rng = (
        np.deg2rad([10.0, 100.0, -120.0]),
        np.deg2rad([-45.0, -30.0, 0.0]),
        np.random.default_rng(1),
    )
    joint = explorer.make(SPACING, SPEED)
    estimate = joint.estimate(
        [
            joint.observe(scene(azimuths, heading, rng, amplitudes=np.cos(elevations)), STFT.frequencies, heading, None)
            for heading in STEP * np.arange(9)
        ]
    )
    assert estimate.k == 3
    assert errors_deg(estimate, list(azimuths)).max() < 3
    for azimuth, elevation in zip(azimuths, elevations, strict=True):
        (source,) = (s for s in estimate.sources if abs(difference(s.azimuth, azimuth)) < 0.2)
        assert (source.elevation or 0.0) == pytest.approx(elevation, abs=np.deg2rad(5))
    assert estimate.directness == 1.0


@pytest.mark.soak
def test_when_k_is_known_so_many_are_placed() -> None:
    observations = listen(LAYOUTS[3], 9)
    joint = explorer.make(SPACING, SPEED)
    assert errors_deg(joint.place(observations, 4), LAYOUTS[3]).max() < 3
    assert joint.place(observations, 2).k == 2
    assert joint.place([], 2) == Estimate(())


def test_asked_again_it_believes_in_who_is_there_the_more_is_heard_and_not_in_a_ghost() -> None:
    there, joint = list(np.deg2rad([170, 70, -50])), explorer.make(SPACING, SPEED)
    heard = listen(there, 9, noise=2.0, n_frames=360)
    believed = joint.place(heard[:5], 3)
    early, late = (joint.reconsider(part, believed) for part in (heard[:5], heard))
    assert early is not None
    assert late is not None
    assert min(source.confidence for source in late.sources) >= min(source.confidence for source in early.sources)
    assert errors_deg(late, there).max() < 5
    ghost = replace(believed.sources[0], azimuth=np.deg2rad(-140.0))
    doubted = joint.reconsider(heard, replace(believed, sources=(*believed.sources, ghost)))
    assert doubted is not None
    sure = sorted((source.confidence, source.azimuth) for source in doubted.sources)
    assert sure[0][0] < DROPPED
    assert sure[1][0] > 0.9
    assert np.abs(np.rad2deg(difference(np.array([azimuth for _, azimuth in sure[1:]]), sure[0][1]))).min() > 20
    assert joint.reconsider(heard, Estimate(())) is None
    assert joint.reconsider([], believed) is None


@pytest.mark.parametrize("side", [60, -60])
def test_asked_again_a_source_stays_where_it_is_believed_to_be_when_that_explains_all_as_well(side: int) -> None:
    """One heading does not tell a place from its mirror image in the axis of the array."""
    joint, heard = explorer.make(SPACING, SPEED), listen(list(np.deg2rad([60])), 1)
    believed = joint.place(heard, 1)
    there = replace(believed.sources[0], azimuth=np.deg2rad(side))
    again = joint.reconsider(heard, replace(believed, sources=(there,)))
    assert again is not None
    assert errors_deg(again, list(np.deg2rad([side]))).max() < 5


@pytest.mark.parametrize("seed", [0, 1, *in_soak(2)])
def test_noise_alone_is_nobody(seed: int) -> None:
    estimate = believe(listen([], 7, seed, noise=1.0))
    assert estimate.k == 0
    assert not estimate.certain


def test_noise_alone_is_nobody_in_frames_that_overlap_by_nine_tenths() -> None:
    joint, stft, generator = explorer.make(SPACING, SPEED), Stft(RATE, 512, 51), np.random.default_rng(0)
    heard = []
    for heading in np.deg2rad(15) * np.arange(7):
        spectrogram = stft.analyse(generator.standard_normal((2, RATE), dtype=np.float32))
        heard.append(joint.observe(spectrogram, stft.frequencies, heading, None, frame_period=stft.period))
    assert joint.estimate(heard).k == 0


def test_silence_is_nobody_and_has_no_evidence() -> None:
    joint = explorer.make(SPACING, SPEED)
    silence = np.zeros((2, len(STFT.frequencies), 100), complex)
    seen = joint.observe(silence, STFT.frequencies, 0.0, None)
    assert (seen.weight, seen.peaks) == (0.0, ())
    assert joint.estimate([seen] * 3).k == 0


@pytest.mark.parametrize("dead", [(True, True), (True, False)])
def test_a_dead_microphone_is_nobody_and_no_fault_of_the_explorer(dead: tuple[bool, bool]) -> None:
    joint = checked_explorer("joint", lambda: explorer.make(SPACING, SPEED))
    samples = np.random.default_rng(0).standard_normal((2, 16000)).astype(np.float32)
    samples[list(dead)] = 0.0
    spectrogram = STFT.analyse(samples)
    assert spectrogram.dtype == np.complex64
    seen = joint.observe(spectrogram, STFT.frequencies, 0.0, None)
    assert seen.weight == 0.0
    assert joint.estimate([seen] * 3).k == 0


def test_no_frames_and_no_observations_are_nobody() -> None:
    joint = explorer.make(SPACING, SPEED)
    seen = joint.observe(np.zeros((2, 257, 0), complex), STFT.frequencies, 0.0, None)
    assert joint.estimate([seen]) == joint.estimate([]) == Estimate(())


def test_one_orientation_cannot_tell_front_from_back() -> None:
    (source,) = believe(listen([np.deg2rad(60)], 1)).sources
    assert not source.resolved
    assert np.cos(source.azimuth) == pytest.approx(0.5, abs=0.05)


def test_a_turn_of_45_degrees_tells_front_from_back() -> None:
    for azimuth in np.deg2rad([60, -60]):
        (source,) = believe(listen([azimuth], 4)).sources
        assert source.resolved
        assert abs(np.rad2deg(difference(source.azimuth, azimuth))) < 3


def test_talkers_that_mirror_each_other_are_told_apart_by_turning() -> None:
    """At heading 0 talkers at +30 and -30 deg have one ITD."""
    azimuths = list(np.deg2rad([30, -30]))
    assert believe(listen(azimuths, 1)).k == 1
    assert errors_deg(believe(listen(azimuths, 9)), azimuths).max() < 3


@pytest.mark.soak
def test_a_pause_at_half_of_the_orientations_does_not_hide_a_talker() -> None:
    both, one = list(np.deg2rad([0, 100])), list(np.deg2rad([0]))
    observations = listen(both, 10)
    observations[1::2] = listen(one, 10)[1::2]
    estimate = believe(observations)
    assert estimate.k == 2
    assert errors_deg(estimate, both).max() < 3


@pytest.mark.soak
def test_everything_turns_with_the_frame() -> None:
    azimuths, by = list(np.deg2rad([0, 70, -120])), np.deg2rad(35)
    before = believe(listen(azimuths, 7))
    after = believe(listen([azimuth + by for azimuth in azimuths], 7, start=by))
    turned = [source.azimuth + by for source in before.sources]
    assert errors_deg(after, turned).max() < 0.5


def test_loudness_does_not_matter() -> None:
    joint, rng = explorer.make(SPACING, SPEED), np.random.default_rng(3)
    spectrogram = scene(np.array([1.0]), 0.0, rng)
    loud, soft = (joint.observe(gain * spectrogram, STFT.frequencies, 0.0, None) for gain in (100.0, 0.01))
    np.testing.assert_allclose(loud.features.blocks, soft.features.blocks, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(loud.features.strict, soft.features.strict, rtol=1e-6, atol=1e-9)


def test_an_observation_publishes_a_density_with_a_peak_at_the_talker() -> None:
    (seen,) = listen([np.deg2rad(60)], 1)
    assert seen.density.sum() == pytest.approx(1)
    assert seen.peaks[0] == pytest.approx(0.5 * SPACING / SPEED, abs=0.05 * SPACING / SPEED)


def test_the_stop_rule_waits_for_seven_orientations_and_then_trusts_a_clear_scene() -> None:
    observations = listen(LAYOUTS[2], 7)
    assert not believe(observations[:6]).certain
    assert believe(observations).certain


@pytest.mark.soak
def test_the_error_is_about_one_sigma() -> None:
    scaled = []
    for seed in range(4):
        estimate = believe(listen(LAYOUTS[2], 5, seed))
        for source in estimate.sources:
            nearest = np.abs(difference(np.array(LAYOUTS[2]), source.azimuth)).min()
            scaled.append(nearest / source.sigma)
    assert 0.1 < np.sqrt(np.mean(np.square(scaled))) < 2


def test_in_a_room_an_azimuth_may_be_farther_off_than_its_delays_tell() -> None:
    rng, joint = np.random.default_rng(1), explorer.make(SPACING, SPEED)
    azimuths, headings, psd = np.array(LAYOUTS[2]), STEP * np.arange(9), np.full(len(STFT.frequencies), 0.02)
    heard = []
    for heading in headings:
        strips = [scene(azimuths, heading, rng, amplitudes=0.8 + 0.15 * rng.standard_normal(3), n_frames=20)
                  for _ in range(12)]  # delays are drawn to 0, and scatter  # fmt: skip
        heard.append(joint.observe(np.concatenate(strips, axis=2), STFT.frequencies, heading, psd))
    wet, dry = joint.estimate(heard), believe(listen(LAYOUTS[2], 9))
    assert wet.directness is not None
    assert wet.directness < 0.9
    assert overdispersion(wet.directness) > 1.1
    for source in wet.sources:
        assert source.nominal_sigma is not None
        assert source.sigma == pytest.approx(overdispersion(wet.directness) * source.nominal_sigma)
    assert [source.sigma for source in dry.sources] == [source.nominal_sigma for source in dry.sources]
    sharp = Stop(1e-9, 1.0, 1.0, 1.01 * max(source.nominal for source in wet.sources), 1, 0.0)
    assert replace(joint, enough=sharp).estimate(heard).certain  # reverberation is no reason to listen on


@pytest.mark.parametrize(("spacing", "speed"), [(0.0, 343.0), (-0.05, 343.0), (0.05, 0.0), (np.nan, 343.0)])
def test_an_impossible_array_is_refused(spacing: float, speed: float) -> None:
    with pytest.raises(ConfigError, match="positive"):
        explorer.make(spacing, speed)


# -------------------------------------------------------------------------------------------------- recordings


def delayed(voice: Real, tau: float) -> Real:
    """What microphones 1 and 2 hear of a plane wave with TDOA ``tau`` [s], (2, n)."""
    shift = np.exp(2j * np.pi * np.fft.rfftfreq(len(voice), 1 / RATE) * tau / 2)
    spectrum = np.fft.rfft(voice)
    return np.fft.irfft(np.stack([spectrum / shift, spectrum * shift]), len(voice))


@pytest.mark.soak
def test_three_real_talkers_are_found_within_2_degrees(speech: Path) -> None:
    from ross_sim.talkers.speech import load_folder

    names = sorted(path.name for path in speech.iterdir() if path.is_dir())[:3]
    voices = [voice.speech for voice in load_folder(speech, RATE, names)]
    azimuths, rng, unit = np.deg2rad([10.0, 75.0, -130.0]), np.random.default_rng(0), 3 * RATE
    joint: Joint = explorer.make(SPACING, SPEED)
    observations = []
    for r in range(9):
        pieces = [voice[r * unit : (r + 1) * unit] / np.sqrt(np.mean(voice**2)) for voice in voices]
        tau = SPACING / SPEED * np.cos(azimuths - STEP * r)
        heard = sum(delayed(piece, t) for piece, t in zip(pieces, tau, strict=True)) + 0.2 * rng.standard_normal(
            (2, unit)
        )
        observations.append(joint.observe(STFT.analyse(heard), STFT.frequencies, STEP * r, None))
    estimate = joint.estimate(observations)
    assert estimate.k == 3
    assert errors_deg(estimate, list(azimuths)).max() < 2
