import numpy as np
import pytest

from ross_payload.dsp.stft import Stft, aliasing_limit, band
from ross_payload.errors import ConfigError


@pytest.mark.parametrize(("frame", "hop"), [(512, 128), (512, 256), (512, 200), (2048, 512), (512, 384), (1024, 768)])
@pytest.mark.parametrize("n", [1, 100, 5000])
def test_synthesis_gives_back_every_sample_edges_included(frame: int, hop: int, n: int) -> None:
    samples = np.random.default_rng(0).standard_normal((2, n))
    stft = Stft(16000, frame, hop)
    np.testing.assert_allclose(stft.synthesise(stft.analyse(samples), n), samples, atol=1e-12)


def test_single_precision_stays_single() -> None:
    stft = Stft(16000, 512, 128)
    spectrogram = stft.analyse(np.ones((2, 1000), np.float32))
    assert spectrogram.dtype == np.complex64
    assert stft.synthesise(spectrogram, 1000).dtype == np.float32


def test_no_samples_have_no_frames() -> None:
    stft = Stft(16000, 512, 128)
    spectrogram = stft.analyse(np.zeros((2, 0)))
    assert spectrogram.shape == (2, 257, 0)
    assert stft.synthesise(spectrogram, 0).shape == (2, 0)


def test_a_tone_peaks_in_its_bin() -> None:
    stft = Stft(16000, 512, 128)
    tone = np.cos(2 * np.pi * 1000 / 16000 * np.arange(4000))
    assert stft.frequencies[np.abs(stft.analyse(tone)[:, 10]).argmax()] == 1000.0


def test_another_number_of_frames_is_refused() -> None:
    stft = Stft(16000, 512, 128)
    with pytest.raises(ConfigError, match="frames"):
        stft.synthesise(stft.analyse(np.zeros(1000)), 5000)


@pytest.mark.parametrize(("frame", "hop"), [(511, 128), (512, 0), (512, 512), (0, 1)])
def test_sizes_without_an_inverse_are_refused(frame: int, hop: int) -> None:
    with pytest.raises(ConfigError):
        Stft(16000, frame, hop)


def test_the_band_ends_at_the_aliasing_limit() -> None:
    frequencies = np.array([0.0, 3430.0, 3431.0])
    assert band(frequencies, 0.0, aliasing_limit(0.05, 343.0)).tolist() == [False, True, False]
