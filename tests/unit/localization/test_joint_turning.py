"""The joint explorer while the array turns: every frame has a heading of its own.

Scenes are plane waves, as in `test_joint`. Truth is the azimuth that was put in.
"""

from __future__ import annotations

import numpy as np
import pytest

from ross_payload.angles import difference
from ross_payload.dsp.itd import Trust, lowest_noise
from ross_payload.dsp.stft import Stft
from ross_payload.interfaces import Complex, Marks, Observation, Real
from ross_payload.localization import itd_mixture, talker_evidence, turning
from ross_payload.localization.itd_mixture import Data
from ross_payload.localization.joint import Joint
from ross_payload.localization.sectors import SECTOR, Histograms, Sectors, rows_of
from ross_payload.localization.talker_evidence import Among
from ross_payload.localization.turning import Turned

pytestmark = pytest.mark.lockstep

SPACING, SPEED, RATE, NOISE = 0.05, 343.0, 16000, 0.1
STFT = Stft(RATE, 512, 128)
FRAMES = 300  # of one period
PSD = np.full(len(STFT.frequencies), 2 * NOISE**2)
JOINT = Joint(SPACING, SPEED)


def heard(azimuths: Real, headings: Real, rng: np.random.Generator) -> Complex:
    """Spectrogram (2, n_freqs, n_frames): bursts of 10 frames, each bin of each burst is ruled by one source."""
    frequencies, n = STFT.frequencies, len(headings)
    shape = (len(frequencies), n)
    noise: Complex = NOISE * rng.standard_normal((2, *shape, 2)).view(np.complex128)[..., 0]
    ruler = np.repeat(rng.integers(len(azimuths), size=(shape[0], n // 10)), 10, axis=1)
    burst = np.repeat(rng.standard_normal((shape[0], n // 10)) ** 3, 10, axis=1)
    voice = burst * np.exp(2j * np.pi * rng.random(shape))
    tau = SPACING / SPEED * np.cos(azimuths[ruler] - headings)
    return noise + np.stack([voice, voice * np.exp(2j * np.pi * frequencies[:, None] * tau)])


def observed(azimuths: Real, turned_deg: float, periods: int) -> list[Observation]:
    """What is observed while the array turns by an angle in every period."""
    rng, found = np.random.default_rng(0), []
    for period in range(periods):
        headings = np.deg2rad(turned_deg) * (period + np.arange(FRAMES) / FRAMES)
        spectrogram = heard(azimuths, headings, rng)
        found.append(JOINT.observe_turning(spectrogram, STFT.frequencies, headings, PSD, frame_period=STFT.period))
    return found


def test_talkers_are_found_from_half_a_turn_without_a_pause() -> None:
    azimuths = np.deg2rad([20.0, -100.0, 150.0])
    estimate = JOINT.estimate(observed(azimuths, 60.0, 3))
    assert estimate.k == 3
    apart = np.abs(difference(azimuths[:, None], [source.azimuth for source in estimate.sources]))
    assert np.rad2deg(apart.min(axis=1)).max() < 1.0
    assert all(source.resolved for source in estimate.sources)


def test_without_the_headings_of_the_frames_the_same_sound_tells_another_place() -> None:
    """The motion is compensated: one talker in front of an array that turns is told from behind, and sharply."""
    azimuths, rng = np.deg2rad([20.0]), np.random.default_rng(0)
    headings = np.deg2rad(60.0) * np.arange(FRAMES) / FRAMES
    spectrogram = heard(azimuths, headings, rng)
    sharp = JOINT.place([JOINT.observe_turning(spectrogram, STFT.frequencies, headings, PSD)], 1)
    blurred = JOINT.place([JOINT.observe(spectrogram, STFT.frequencies, float(headings.mean()), PSD)], 1)
    assert sharp.sources[0].resolved
    assert not blurred.sources[0].resolved
    errors = [np.rad2deg(abs(difference(each.sources[0].azimuth, azimuths[0]))) for each in (sharp, blurred)]
    assert errors[0] < 1.0
    assert errors[1] > 5.0


def test_an_array_that_does_not_turn_hears_what_one_at_rest_does() -> None:
    spectrogram = heard(np.deg2rad([20.0, -100.0]), np.full(FRAMES, 0.3), np.random.default_rng(0))
    turned = JOINT.observe_turning(spectrogram, STFT.frequencies, np.full(FRAMES, 0.3), None)
    resting = JOINT.observe(spectrogram, STFT.frequencies, 0.3, None)
    assert turned.heading == pytest.approx(0.3)
    np.testing.assert_allclose(turned.density, resting.density)
    (only,) = turned.features.histograms
    np.testing.assert_allclose(only.blocks, resting.features.blocks)
    np.testing.assert_allclose(only.strict, resting.features.strict)


def test_a_sector_turns_by_little_and_nothing_is_counted_twice() -> None:
    headings = np.deg2rad(60.0) * np.arange(FRAMES) / FRAMES
    spectrogram = heard(np.deg2rad([20.0]), headings, np.random.default_rng(0))
    whole = JOINT.observe_turning(spectrogram, STFT.frequencies, headings, None).features
    assert isinstance(whole, Sectors)
    apart = np.rad2deg(np.diff(whole.headings))
    assert apart.max() < np.rad2deg(SECTOR) + 60.0 * 12 / FRAMES  # and what it turns in a block of 12 frames
    assert apart[:-1].min() >= np.rad2deg(SECTOR)
    still = JOINT.observe(spectrogram, STFT.frequencies, 0.0, None).features
    np.testing.assert_allclose(sum(each.strict for each in whole.histograms), still.strict)


def test_what_was_heard_before_the_period_is_not_counted() -> None:
    headings = np.zeros(FRAMES)
    spectrogram = heard(np.deg2rad([20.0]), headings, np.random.default_rng(0))
    spectrogram[..., :60] *= 100.0
    seen = JOINT.observe_turning(spectrogram, STFT.frequencies, headings, PSD, skip=60)
    rest = JOINT.observe_turning(spectrogram[..., 60:], STFT.frequencies, headings[60:], PSD)
    assert seen.weight < rest.weight  # its echoes are told from onsets


def test_the_noise_of_the_motor_has_no_vote() -> None:
    """Both microphones hear it alike, and the lead-in, at rest, did not."""
    rng, n = np.random.default_rng(0), len(STFT.frequencies)
    hum: Complex = rng.standard_normal((n, FRAMES, 2)).view(np.complex128)[..., 0]
    quiet = NOISE * rng.standard_normal((2, n, FRAMES, 2)).view(np.complex128)[..., 0]
    weights = [
        JOINT.observe_turning(hum + quiet, STFT.frequencies, np.zeros(FRAMES), psd).weight for psd in (PSD, 2.5 + PSD)
    ]
    untold = JOINT.observe(hum + quiet, STFT.frequencies, 0.0, PSD).weight
    assert weights[0] < untold / 2


def test_the_lowest_noise_is_that_of_the_quiet_frames() -> None:
    spectrogram = np.ones((2, 40, 100), complex)
    spectrogram[..., 20:] *= 10.0
    assert lowest_noise(spectrogram, 25.0 * np.arange(1, 41), 0.01, Trust()) == pytest.approx(np.full(40, 1.2))


def test_rows_of_one_period_share_their_weights() -> None:
    """Two headings of one period, at which other talkers are louder by chance: the model says that both talk alike."""
    grid = np.linspace(-1.5, 1.5, 61)
    counts = np.zeros((2, 61))
    counts[0, 50], counts[1, 30] = 30.0, 10.0
    headings, azimuths = np.zeros(2), np.array([0.0, np.pi / 2])
    apart = Data(grid, headings, counts)
    shared = Data(grid, headings, counts, periods=np.array([0]))
    for data, expected in ((apart, [0.9, 0.1]), (shared, [0.75])):
        model = itd_mixture.empty(data)
        for azimuth in azimuths:
            model = itd_mixture.add(model, azimuth, 1.0, 0.1, np.full(data.n_periods, 0.4))
        refined = itd_mixture.refine(data, model, 10)
        assert refined.weights.shape == (data.n_periods, 4)
        assert refined.weights[:, 0] == pytest.approx(expected, abs=0.1)


def test_a_frame_has_the_heading_of_its_middle() -> None:
    hops = 100
    turned = Turned(np.zeros((2, hops * 160), np.float32), np.deg2rad(0.2) * (np.arange(hops) + 0.5), before=1600)
    headings = turned.at(STFT, turned.headings)
    assert turned.frames(STFT).shape[-1] == len(headings) == hops * 160 // 128
    middles = (np.arange(len(headings)) + 1) * 128 - 256  # the first frame ends after 128 samples
    inside = (middles > 160) & (middles < (hops - 1) * 160)
    np.testing.assert_allclose(np.rad2deg(headings[inside]), 20.0 * middles[inside] / RATE, atol=1e-9)
    assert turned.skip(STFT) == 12


def test_headings_are_not_wrapped_between_two_hops() -> None:
    turned = Turned(np.zeros((2, 320), np.float32), np.deg2rad([179.0, -179.0]))
    assert np.rad2deg(turned.at(STFT, turned.headings)).max() == pytest.approx(180.0, abs=1.0)
    assert np.rad2deg(turned.at(STFT, turned.headings)).min() >= 179.0


def test_among_the_noise_of_the_vehicle_every_sector_is_observed_at_its_own_heading() -> None:
    n = 3 * RATE
    hops = np.deg2rad(60.0) * (np.arange(300) + 0.5) / 300
    turned = Turned(np.zeros((2, n), np.float32), hops, aboard=hops - 1.0)
    asked = []

    def observe(spectrogram: Complex, heading: float, aboard: float, tonal: Marks | None) -> Observation:
        assert tonal is None
        asked.append((spectrogram.shape[-1], heading, aboard))
        return Observation(heading, np.zeros(1), np.zeros(1), 1.0, features="kept")

    seen = turning.observe_in_noise(STFT, turned, observe)
    assert sum(frames for frames, _, _ in asked) == n // 128
    assert [heading - aboard for _, heading, aboard in asked] == pytest.approx([1.0] * len(asked))
    assert 60 / 7 < len(asked) <= 60 / 6
    assert seen.weight == len(asked)
    assert seen.features.histograms == ("kept",) * len(asked)


def test_tones_of_rotors_are_told_to_the_sector_in_which_they_were_heard() -> None:
    rng, before = np.random.default_rng(1), 8 * STFT.hop
    samples = rng.standard_normal((2, RATE + before)).astype(np.float32)
    turned = Turned(samples, np.deg2rad(np.linspace(0, 30, 50)), before)
    marks = np.abs(STFT.analyse(samples)[0]) > 1.0  # any that are those of their frames
    asked = []

    def observe(spectrogram: Complex, heading: float, _: float, tonal: Marks | None) -> Observation:
        assert tonal is not None
        np.testing.assert_array_equal(tonal, np.abs(spectrogram[0]) > 1.0)
        asked.append(tonal)
        return Observation(heading, np.zeros(1), np.zeros(1), 1.0, features="kept")

    turning.observe_in_noise(STFT, turned, observe, marks)
    assert len(asked) > 2
    assert any(tonal.any() for tonal in asked)


def test_what_is_known_of_the_noise_in_every_sector_counts_together() -> None:
    nothing = np.zeros((1, 3))
    kept = [Histograms(nothing, nothing[0], Among((1j,), share)) for share in (0.2, 0.4)]
    seen = Observation(0.0, np.zeros(3), np.zeros(3), 1.0, (), Sectors(np.array([0.0, 0.1]), tuple(kept)))
    assert talker_evidence.together(rows_of([seen]).among) == Among((1j,), pytest.approx(0.3))
