import numpy as np
import pytest

from examples import in_soak
from ross_payload.dsp.covariance import direct
from ross_payload.dsp.metrics import si_sdri
from ross_payload.dsp.steering import steering_vectors
from ross_payload.dsp.stft import Stft
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Scene
from ross_payload.separation import local_gaussian_model, refined
from ross_payload.separation.auto_separator import separator as auto
from ross_payload.separation.network import network_of
from ross_payload.separation.refined import Refined, separator
from ross_payload.separation.refiner_features import HIGHEST, N_FEATURES, features, stacked
from ross_sim.study.training import refiner_model
from ross_sim.talkers.synthetic_voices import synthetic_voice

pytestmark = pytest.mark.lockstep

RATE = 16000
STFT = Stft(RATE, 2048, 512)
LONGEST = 0.05 / 343.0
NOISE = 0.01


def _scene(tau: list[float] | None, stft: Stft = STFT, noise: float | None = None) -> Scene:
    psd = None if noise is None else np.full(stft.frequencies.size, noise)
    return Scene(stft.frequencies, 0.05, 343.0, len(tau or ()), None if tau is None else np.array(tau) * LONGEST, psd)


def _mixture(tau: list[float], seconds: float = 2.0, stft: Stft = STFT) -> tuple[np.ndarray, np.ndarray]:
    """Bursts of noise from plane waves, and white noise: images at microphone 1 and the mixture."""
    rng = np.random.default_rng(0)
    n = round(seconds * stft.rate)
    gates = np.repeat(rng.random((len(tau), n // 1600 + 1)) < 0.5, 1600, axis=1)[:, :n]
    images = stft.analyse(rng.standard_normal((len(tau), n)) * gates)
    mixture = np.einsum("fmk,kft->mft", steering_vectors(stft.frequencies, np.array(tau) * LONGEST), images)
    return images, mixture + stft.analyse(np.sqrt(NOISE) * rng.standard_normal((2, n)))


def _passive() -> Refined:
    zeros = {name: 0 * array for name, array in refiner_model.initial(2, 1, 2, np.random.default_rng(0)).items()}
    return Refined(network_of(zeros))


def test_a_network_that_corrects_nothing_leaves_the_gaussian_model(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(refined, "BEFORE", local_gaussian_model.UPDATES)
    monkeypatch.setattr(refined, "reestimated", lambda observed, covariances, psds: covariances)
    _, mixture = _mixture([-0.8, 0.7], 1.0)
    scene = _scene([-0.8, 0.7], noise=NOISE * 1024)
    expected, found = local_gaussian_model.separator.batch(mixture, scene), _passive().batch(mixture, scene)
    error = np.abs(found.signals - expected.signals) ** 2
    assert error.sum() < 1e-3 * (np.abs(expected.signals) ** 2).sum()
    np.testing.assert_allclose(found.masks, expected.masks, atol=0.01)


def test_each_group_follows_its_direction_in_whatever_order() -> None:
    _, mixture = _mixture([-0.8, 0.1, 0.9], 1.0)
    forth = separator.batch(mixture, _scene([-0.8, 0.1, 0.9]))
    back = separator.batch(mixture, _scene([0.9, -0.8, 0.1]))
    np.testing.assert_allclose(back.signals, forth.signals[[2, 0, 1]], atol=1e-2 * np.abs(mixture).max())


@pytest.mark.parametrize("seconds", [0.01, 0.2, *in_soak(1.0, 3.0)])
@pytest.mark.parametrize("tau", [[0.2], [-0.8, 0.7], [-0.9, -0.2, 0.3, 0.9]])
def test_short_recordings_stay_finite_and_no_louder_than_the_mixture(tau: list[float], seconds: float) -> None:
    _, mixture = _mixture(tau, seconds)
    groups = separator.batch(mixture, _scene(tau))
    assert groups.signals.shape == (len(tau), *mixture.shape[1:])
    assert np.isfinite(groups.signals).all()
    assert groups.masks is not None
    assert groups.masks.min() >= 0
    assert groups.masks.sum(axis=0).max() <= 1 + 1e-5
    assert (np.abs(groups.signals) ** 2).sum() <= 1.5 * (np.abs(mixture) ** 2).sum()


@pytest.mark.parametrize("level", [0.0, 1e-20, 1e12])
def test_silence_and_extreme_levels_stay_finite(level: float) -> None:
    _, mixture = _mixture([-0.8, 0.7], 0.5)
    groups = separator.batch(level * mixture, _scene([-0.8, 0.7]))
    assert np.isfinite(groups.signals).all()
    assert groups.signals.any() == (level > 0)


def test_identical_microphones_stay_finite() -> None:
    """No noise and one point in space: every covariance is singular."""
    rng = np.random.default_rng(1)
    one = STFT.analyse(rng.standard_normal(RATE))
    groups = separator.batch(np.stack([one, one]), _scene([-0.1, 0.1]))
    assert np.isfinite(groups.signals).all()


def test_the_level_of_the_recording_does_not_matter() -> None:
    _, mixture = _mixture([-0.8, 0.7], 0.5)
    loud = separator.batch(1000 * mixture, _scene([-0.8, 0.7], noise=1e6 * NOISE * 1024))
    quiet = separator.batch(mixture, _scene([-0.8, 0.7], noise=NOISE * 1024))
    np.testing.assert_allclose(loud.signals / 1000, quiet.signals, atol=1e-3 * np.abs(mixture).max())


def test_bins_of_another_width_keep_the_gaussian_model() -> None:
    coarse = Stft(RATE, 512, 128)
    _, mixture = _mixture([-0.8, 0.7], 1.0, coarse)
    scene = _scene([-0.8, 0.7], coarse, noise=NOISE * 256)
    expected, found = (method.batch(mixture, scene) for method in (local_gaussian_model.separator, separator))
    np.testing.assert_allclose(found.masks, expected.masks, atol=0.02)
    for told, usual in zip(found.quality, expected.quality, strict=True):
        assert told.si_sdr == pytest.approx(usual.si_sdr, abs=0.5)
    assert found.why == "the local Gaussian model alone: frames of 32 ms, and the network is for 67 to 167 ms"
    assert auto.batch(mixture, scene).why == f"directions known; {found.why}"


def test_bins_that_the_network_knows_need_no_reason() -> None:
    _, mixture = _mixture([-0.8, 0.7], 0.5)
    assert not separator.batch(mixture, _scene([-0.8, 0.7])).why


def test_bins_above_the_highest_keep_the_gaussian_model(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(refined, "BEFORE", local_gaussian_model.UPDATES)
    _, mixture = _mixture([-0.8, 0.7], 1.0)
    scene = _scene([-0.8, 0.7], noise=NOISE * 1024)
    above = STFT.frequencies >= HIGHEST
    expected, found = (method.batch(mixture, scene).masks for method in (local_gaussian_model.separator, separator))
    assert expected is not None
    assert found is not None
    np.testing.assert_allclose(found[:, above], expected[:, above], atol=0.02)
    assert np.abs(found - expected)[:, ~above].max() > 0.1


def test_nobody_gives_no_group() -> None:
    _, mixture = _mixture([0.0], 0.2)
    assert separator.batch(mixture, _scene([])).signals.shape[0] == 0


def test_without_directions_it_refuses() -> None:
    with pytest.raises(ConfigError, match="the refined model: expected the TDOA"):
        separator.batch(np.zeros((2, 5, 3), complex), Scene(np.arange(5.0), 0.05, 343.0, 2))


def test_features_of_a_bin_that_one_group_explains() -> None:
    """x = a_1 with v = (1, LEAST): the group fits, the other does not, and its PSD needs no change."""
    frequencies = np.array([2000.0])
    waves = direct(frequencies, LONGEST * np.array([-0.8, 0.7]))
    white = np.array([[[1.0, 1.0, 0.0, 0.0]]])
    covariances = np.concatenate([0.99 * waves + 0.01 * white, white], axis=1)
    psds = np.array([[1.0, 1e-7, 1e-4]])[..., None]
    shown = stacked(features(waves[:, :1].swapaxes(1, 2), covariances, psds))
    assert shown.shape == (2, N_FEATURES, 1, 1)
    own, _, _, power, misfit, margin, output, _, near, incoherence = shown[:, :, 0, 0].T
    assert own[0] == pytest.approx(0.0)
    assert power == pytest.approx([0.0, 0.0], abs=1e-6)
    assert misfit[0] < misfit[1]
    assert margin[0] > 0 > margin[1]
    np.testing.assert_allclose(near, misfit)  # the bins around are this one
    assert incoherence == pytest.approx(0.2 * np.log(1e-3), abs=1e-3)
    assert output[0] == pytest.approx(0.2 * np.log(0.995), abs=0.02)


def test_talkers_are_separated_better_than_by_the_gaussian_model() -> None:
    """Three synthetic voices that nobody trained on, in the open, 15 dB above the noise."""
    tau, n = [-0.6, 0.1, 0.8], 5 * RATE // 2
    voices = np.stack([synthetic_voice(index, RATE).speech[:n] for index in range(3)]).astype(float)
    voices /= voices.std(axis=1, keepdims=True)
    images = STFT.analyse(voices)
    mixture = np.einsum("fmk,kft->mft", steering_vectors(STFT.frequencies, np.array(tau) * LONGEST), images)
    mixture += STFT.analyse(np.sqrt(0.1) * np.random.default_rng(0).standard_normal((2, n)))
    heard = STFT.synthesise(mixture[0], n)
    gains = []
    for method in (local_gaussian_model.separator, separator):
        signals = STFT.synthesise(method.batch(mixture, _scene(tau)).signals, n)
        gains.append(np.mean([si_sdri(s, heard, voice) for s, voice in zip(signals, voices, strict=True)]))
    assert gains[1] > gains[0]


def test_covariances_are_estimated_again_in_a_room_and_not_in_the_open(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two who talk in turn, first as plane waves and then in a diffuse field that follows them."""
    asked: list[int] = []

    def counted(observed: np.ndarray, covariances: np.ndarray, psds: np.ndarray) -> np.ndarray:
        asked.append(len(observed))
        return covariances

    monkeypatch.setattr(refined, "reestimated", counted)
    rng = np.random.default_rng(5)
    images = STFT.analyse(rng.standard_normal((2, RATE)) * np.repeat(np.eye(2), RATE // 2, axis=1))
    waves = np.einsum(
        "fmk,kft->mft", steering_vectors(STFT.frequencies, np.array([-0.8, 0.7]) * LONGEST), images
    ) + STFT.analyse(np.sqrt(1e-4) * rng.standard_normal((2, RATE)))
    scene = _scene([-0.8, 0.7], noise=1e-4 * 1024)
    separator.batch(waves, scene)
    assert not asked
    field = np.abs(images).sum(axis=0) * (rng.standard_normal(waves.shape) + 1j * rng.standard_normal(waves.shape))
    as_they_were = separator.batch(waves + 0.3 * field, scene).signals
    assert asked == [(STFT.frequencies < HIGHEST).sum()]
    white = np.array([1, 1, 0, 0], np.float32)
    monkeypatch.setattr(refined, "reestimated", lambda observed, covariances, psds: 0 * covariances + white)
    changed = np.abs(separator.batch(waves + 0.3 * field, scene).signals - as_they_were)
    assert changed[:, STFT.frequencies < HIGHEST].max() > 0.1 * np.abs(as_they_were).max()
    assert not changed[:, STFT.frequencies >= HIGHEST].any()
