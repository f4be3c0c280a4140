import numpy as np
import pytest

from ross_payload.dsp.metrics import si_sdr
from ross_payload.dsp.stft import Stft
from ross_sim.study.oracle_separators import ORACLES, ideal_ratio_mask, multichannel_wiener, ratio_masks, varying_wiener

STFT = Stft(8000, 256, 64)
N = 8000


def _scene(n_sources: int = 3, noise_level: float = 0.05) -> tuple[np.ndarray, np.ndarray]:
    """Bursts of coloured noise that reach microphone 2 some samples later or earlier, and sensor noise."""
    rng = np.random.default_rng(0)
    images = np.zeros((n_sources, 2, N))
    for k in range(n_sources):
        bursts = np.repeat(rng.gamma(0.3, size=N // 400), 400)
        voice = np.convolve(bursts * rng.standard_normal(N), np.hanning(3 + 4 * k), "same")
        images[k] = np.stack([voice, np.roll(voice, 2 * k - 2)])
    return images, noise_level * rng.standard_normal((2, N))


def test_masks_lie_between_0_and_1_and_add_up_to_1() -> None:
    images, noise = _scene()
    masks = ratio_masks(STFT.analyse(np.concatenate([images[:, 0], noise[:1]])))
    assert masks.min() >= 0
    assert masks.max() <= 1
    np.testing.assert_allclose(masks.sum(axis=0), 1)


@pytest.mark.parametrize("name", ORACLES)
def test_a_source_alone_comes_out_as_it_is(name: str) -> None:
    images, _ = _scene(2)
    images[1] = 0
    found = ORACLES[name](images, np.zeros((2, N)), STFT)
    assert found.shape == (2, N)
    assert si_sdr(found[0], images[0, 0]) > 50
    assert (found[1] ** 2).mean() < 1e-6 * (images[0, 0] ** 2).mean()


def test_two_plane_waves_without_noise_are_unmixed() -> None:
    """As many microphones as sources: the Wiener filter becomes the inverse of the mixing."""
    images, _ = _scene(2)
    found = multichannel_wiener(images, np.zeros((2, N)), STFT)
    assert min(si_sdr(found[k], images[k, 0]) for k in (0, 1)) > 15


def test_who_knows_more_does_better() -> None:
    images, noise = _scene()
    mixture = images.sum(axis=0)[0] + noise[0]

    def score(found: np.ndarray) -> float:
        return float(np.mean([si_sdr(voice, image) for voice, image in zip(found, images[:, 0], strict=True)]))

    nothing = score(np.broadcast_to(mixture, (3, N)))
    fixed, masked, varying = (
        score(f(images, noise, STFT)) for f in (multichannel_wiener, ideal_ratio_mask, varying_wiener)
    )
    assert nothing < fixed < varying
    assert nothing < masked < varying


@pytest.mark.parametrize("name", ORACLES)
def test_estimates_of_all_talkers_and_the_noise_add_up_to_the_mixture(name: str) -> None:
    images, noise = _scene(2)
    everyone = np.concatenate([images, noise[None]])
    found = ORACLES[name](everyone, 1e-9 * noise, STFT).sum(axis=0)
    assert si_sdr(found, everyone.sum(axis=0)[0]) > 40


@pytest.mark.parametrize("name", ORACLES)
def test_silence_gives_silence(name: str) -> None:
    assert not ORACLES[name](np.zeros((2, 2, N)), np.zeros((2, N)), STFT).any()
