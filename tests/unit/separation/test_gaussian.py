from dataclasses import replace

import numpy as np
import pytest

from ross_payload.dsp.covariance import diffuse, direct, outer
from ross_payload.dsp.smoothing import average
from ross_payload.dsp.steering import steering_vectors
from ross_payload.dsp.stft import Stft
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Complex, Groups, Scene
from ross_payload.plugin_checks import load_separator
from ross_payload.separation.cacgmm import learn
from ross_payload.separation.directness import astray, directness_of
from ross_payload.separation.local_gaussian_model import (
    in_long_frames,
    long_frame,
    reverberant,
    separator,
    source_psds,
    wiener,
)

FREQUENCIES = np.fft.rfftfreq(512, 1 / 16000)[1:]
LONGEST = 0.05 / 343.0
TAU = LONGEST * np.array([-0.8, 0.1, 0.9])
WHITE = np.broadcast_to([1.0, 1.0, 0.0, 0.0], (FREQUENCIES.size, 1, 4))


def _bins(rng: np.random.Generator, *shape: int) -> np.ndarray:
    return (rng.standard_normal(shape) + 1j * rng.standard_normal(shape)) / np.sqrt(2)


def _mixture(tau: np.ndarray, noise: float, frames: int = 120) -> tuple[np.ndarray, np.ndarray]:
    """Patchy sources of mean power 1: images at microphone 1 and the noisy mixture."""
    rng = np.random.default_rng(0)
    patches = rng.random((len(tau), FREQUENCIES.size // 8, frames // 8)) < 0.25
    active = np.kron(patches, np.ones((1, 8, 8)))
    images = 2 * active * _bins(rng, *active.shape)
    clean = np.einsum("fmk,kft->mft", steering_vectors(FREQUENCIES, tau), images)
    return images, clean + np.sqrt(noise) * _bins(rng, *clean.shape)


def _scene(tau: np.ndarray | None, noise: float | None) -> Scene:
    psd = None if noise is None else np.full(FREQUENCIES.size, noise)
    return Scene(FREQUENCIES, 0.05, 343.0, 0 if tau is None else len(tau), tau, psd)


def _ratio_db(estimate: np.ndarray, image: np.ndarray) -> float:
    return float(10 * np.log10((np.abs(image) ** 2).sum() / (np.abs(estimate - image) ** 2).sum()))


def test_the_psds_explain_covariances_that_the_model_can_make() -> None:
    covariances = np.concatenate([0.9 * direct(FREQUENCIES, TAU[[0, 2]]) + 0.1 * WHITE, WHITE], axis=1)
    psds = np.array([3.0, 0.5, 0.1])
    observed = np.repeat(np.einsum("fkc,k->fc", covariances, psds)[:, :, None], 5, axis=2)
    apart = (FREQUENCIES > 1000) & (FREQUENCIES < 3000)  # at 0 and at 1 / (tau_2 - tau_1) both covariances are the same
    shares = np.full((apart.sum(), 2, 5), psds[:2, None] / psds[:2].sum())
    found = source_psds(observed[apart], covariances[apart], np.full(apart.sum(), 0.1), shares)
    np.testing.assert_allclose(found.mean(axis=(0, 2)), psds, rtol=0.1)


def test_the_wiener_output_is_that_of_the_matrix_formula() -> None:
    rng = np.random.default_rng(1)
    factors = _bins(rng, 3, 2, 2)
    matrices = np.concatenate([factors @ np.swapaxes(factors.conj(), 1, 2), np.eye(2)[None]])
    psds, x = np.array([1.0, 0.3, 2.0, 0.1]), _bins(rng, 2)
    expected = [psds[k] * (matrices[k] @ np.linalg.inv(np.tensordot(psds, matrices, 1)) @ x)[0] for k in range(3)]
    root2 = np.sqrt(2)
    coordinates = np.array([[m[0, 0].real, m[1, 1].real, root2 * m[0, 1].real, root2 * m[0, 1].imag] for m in matrices])
    found = wiener(x[:, None, None], psds[None, :, None], coordinates[None])
    np.testing.assert_allclose(found.ravel(), expected)


def test_every_source_gains_and_is_told_apart() -> None:
    images, mixture = _mixture(TAU, noise=0.01)
    groups = separator.batch(mixture, _scene(TAU, 0.01))
    assert groups.members == ((0,), (1,), (2,))
    for signal, image in zip(groups.signals, images, strict=True):
        assert _ratio_db(signal, image) > _ratio_db(mixture[0], image) + 8


def test_aliased_sources_are_one_group_and_their_sum_is_what_comes_out() -> None:
    tau = TAU[[0, 2, 0]]
    images, mixture = _mixture(tau, noise=0.01)
    groups = separator.batch(mixture, _scene(tau, 0.01))
    assert groups.members == ((0, 2), (1,))
    assert _ratio_db(groups.signals[0], images[0] + images[2]) > 10


def test_one_source_gains_more_than_two_microphones_alone_can() -> None:
    images, mixture = _mixture(TAU[:1], noise=0.3)
    signal = separator.batch(mixture, _scene(TAU[:1], 0.3)).signals[0]
    assert _ratio_db(signal, images[0]) > _ratio_db(mixture[0], images[0]) + 3.01


def test_the_level_does_not_matter() -> None:
    _, mixture = _mixture(TAU, noise=0.01)
    loud = separator.batch(1000 * mixture, _scene(TAU, 1e4)).signals
    np.testing.assert_allclose(loud / 1000, separator.batch(mixture, _scene(TAU, 0.01)).signals, atol=1e-3)


@pytest.mark.parametrize("noise", [None, 0.0, 0.01])
def test_silence_dead_microphones_and_short_recordings_give_finite_signals(noise: float | None) -> None:
    _, mixture = _mixture(TAU, noise=0.01)
    left, right = np.array([1, 0])[:, None, None], np.array([0, 1])[:, None, None]
    for changed in (0 * mixture, mixture * left, mixture * right, mixture[:, :, :1], mixture[:, :, :0]):
        groups = separator.batch(changed, _scene(TAU, noise))
        assert groups.signals.shape == (3, *changed.shape[1:])
        assert np.isfinite(groups.signals).all()
        assert np.isfinite(groups.masks).all()


@pytest.mark.parametrize("name", ["auto", "gaussian", "refined"])
@pytest.mark.parametrize("noise", [None, 1e-7])
@pytest.mark.parametrize("tau", [(0.0, 1e-7, -1e-7), (-1.2e-4, 0.0, 1e-4)])
def test_what_both_microphones_hear_alike_gives_finite_signals(
    name: str, noise: float | None, tau: tuple[float, ...]
) -> None:
    """A DC part, a rumble and identical channels: covariances that cannot be inverted."""
    stft, rng = Stft(16000, 1024, 256), np.random.default_rng(3)
    alike = rng.standard_normal(16000).cumsum() * 1e-3 + 0.1
    heard = np.stack([alike, alike]) + 1e-4 * rng.standard_normal((2, 16000)) * np.array([[1.0], [0.0]])
    scene = Scene(
        stft.frequencies, 0.05, 343.0, 3, np.array(tau),
        noise_psd=None if noise is None else np.full(len(stft.frequencies), noise), hop=stft.hop,
    )  # fmt: skip
    for samples in (heard, np.stack([alike, alike]), np.clip(40 * heard, -1, 1)):
        spectrogram = stft.analyse(samples.astype(np.float32))
        groups = load_separator(name).batch(spectrogram, scene)
        assert np.isfinite(groups.masks).all()
        assert np.isfinite([(each.si_sdr, each.si_sdri) for each in groups.quality]).all()
        assert (np.abs(groups.signals) <= 200 * np.abs(spectrogram).sum(axis=0) + 1e-6).all()


def test_nobody_gives_no_groups() -> None:
    _, mixture = _mixture(TAU, noise=0.01)
    assert separator.batch(mixture, _scene(np.zeros(0), 0.01)).signals.shape == (0, *mixture.shape[1:])


@pytest.mark.parametrize("name", ["gaussian", "refined", "auto"])
def test_nobody_gives_no_groups_however_loud_one_is_who_was_not_found(name) -> None:
    heard = np.zeros((2, FREQUENCIES.size, 60), np.complex64)
    heard[:, :, ::6] = 1.0
    groups = load_separator(name).batch(heard, replace(_scene(np.zeros(0), 1e-6), hop=128))
    assert (groups.signals.shape, groups.members) == ((0, *heard.shape[1:]), ())


def test_unknown_directions_are_refused() -> None:
    with pytest.raises(ConfigError, match="TDOA"):
        separator.batch(np.ones((2, FREQUENCIES.size, 3), complex), _scene(None, None))


def test_learning_comes_nearer_to_the_truth_than_the_start() -> None:
    truth = TAU[[0, 2]]
    _, mixture = _mixture(truth, noise=0.001)
    start = 0.7 * direct(FREQUENCIES, truth + 0.2 * LONGEST * np.array([1, -1])) + 0.3 * WHITE
    learnt, _ = learn(outer(mixture), start, np.full(FREQUENCIES.size, 0.001), anchor=0.1)
    wanted = direct(FREQUENCIES, truth)
    assert np.linalg.norm(learnt - wanted) < 0.7 * np.linalg.norm(start - wanted)


def test_plane_waves_are_direct_and_a_diffuse_field_is_not() -> None:
    waves, silent = direct(FREQUENCIES, TAU), np.full(FREQUENCIES.size, 1e-6)
    _, open_air = _mixture(TAU[:1], noise=1e-6)
    assert directness_of(outer(open_air), FREQUENCIES, waves, silent) == 1.0
    coherence = diffuse(FREQUENCIES, 0.05, 343.0)[:, 2] / np.sqrt(2)
    first, second = _bins(np.random.default_rng(2), 2, FREQUENCIES.size, 100)
    mixed = coherence[:, None] * first + np.sqrt(1 - coherence**2)[:, None] * second
    assert directness_of(outer(np.stack([first, mixed])), FREQUENCIES, waves, silent) == 0.0


def test_the_share_of_a_group_tells_when_it_is_heard() -> None:
    rng = np.random.default_rng(3)
    waves = direct(FREQUENCIES, TAU[[0, 2]])
    first = steering_vectors(FREQUENCIES, TAU[:1])[:, :, 0].T[:, :, None] * _bins(rng, FREQUENCIES.size, 20)
    second = steering_vectors(FREQUENCIES, TAU[2:])[:, :, 0].T[:, :, None] * _bins(rng, FREQUENCIES.size, 20)
    observed = outer(np.concatenate([first, second], axis=2))
    _, shares = learn(observed, 0.9 * waves + 0.1 * WHITE, np.full(FREQUENCIES.size, 1e-6), anchor=0.1)
    np.testing.assert_allclose(shares.sum(axis=1), 1, atol=1e-6)
    assert shares[:, 0, :20].min() > 0.9
    assert shares[:, 1, 20:].min() > 0.9


def test_the_more_is_diffuse_the_more_goes_astray() -> None:
    rng, waves, silent = np.random.default_rng(4), direct(FREQUENCIES, TAU[:1]), np.full(FREQUENCIES.size, 1e-6)
    _, wave = _mixture(TAU[:1], noise=1e-6)
    field = _bins(rng, *wave.shape) * np.abs(wave[:1])
    parts = [astray(outer(wave + level * field), FREQUENCIES, waves, silent) for level in (0.0, 0.1, 0.3)]
    assert parts[0] < 1e-4
    assert parts[0] < parts[1] < parts[2]


@pytest.mark.parametrize("n", [1, 700, 16000])
def test_frames_cut_again_give_back_what_a_separator_leaves_alone(n: int) -> None:
    stft = Stft(16000, 1024, 256)
    samples = np.random.default_rng(5).standard_normal((2, n))
    seen = []

    def keep(spectrogram: Complex, scene: Scene) -> Groups:
        seen.append((spectrogram.shape[1], scene.frequencies.size, float(np.mean(np.asarray(scene.noise_psd)))))
        return Groups(spectrogram[:1], ((0,),), "keep")

    scene = Scene(stft.frequencies, 0.05, 343.0, 1, TAU[:1], np.full(513, 3.0), hop=256)
    groups = in_long_frames(keep, stft.analyse(samples), scene)
    np.testing.assert_allclose(stft.synthesise(groups.signals, n), samples[:1], atol=1e-9)
    assert seen == [(1025, 1025, 6.0)]  # 128 ms; white noise has twice the PSD in frames of twice the length


@pytest.mark.parametrize("rate", [8000, 11025, 16000, 22050, 32000, 44100, 48000, 96000])
def test_no_long_frame_is_cut_into_long_frames_once_more(rate: int) -> None:
    """Of 128 ms at 44.1 kHz there are no four hops."""
    rng = np.random.default_rng(6)
    for frame, again in ((long_frame(rate) // 2, True), (long_frame(rate), False)):
        stft = Stft(rate, frame, frame // 4)
        diffuse_sound = stft.analyse(rng.standard_normal((2, rate)))
        quiet = np.full(stft.frequencies.size, 1e-6)
        scene = Scene(stft.frequencies, 0.05, 343.0, 1, TAU[:1], quiet, hop=stft.hop)
        assert reverberant(diffuse_sound, scene) is again


def test_averages_keep_constants_and_the_total_inside() -> None:
    values = np.zeros((7, 2, 9))
    values[3, 1, 4] = 9
    np.testing.assert_allclose(average(np.ones((5, 2, 4))), 1)
    assert average(values)[2:5, 1, 3:6].tolist() == [[1.0] * 3] * 3
    assert average(values).sum() == pytest.approx(9)
