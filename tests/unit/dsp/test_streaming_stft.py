import numpy as np
import pytest

from ross_payload.dsp.stft import Stft
from ross_payload.dsp.streaming_stft import StreamingAnalysis, StreamingStft, StreamingSynthesis, transform_for
from ross_payload.errors import ConfigError

STFT = Stft(16000, 64, 16)
SAMPLES = np.random.default_rng(0).standard_normal((2, 1000)).astype(np.float32)
CUTS = [3, 4, 20, 36, 500, 501, 980]  # blocks of any size, some shorter than a hop


def _streamed(transform: StreamingStft) -> tuple[np.ndarray, np.ndarray]:
    analysis, synthesis = StreamingAnalysis(transform, 2), StreamingSynthesis(transform, 2)
    frames = [analysis.push(block) for block in np.split(SAMPLES, CUTS, axis=1)]
    samples = np.concatenate([synthesis.push(block) for block in frames], axis=1)
    return np.concatenate(frames, axis=2), samples


def test_frames_and_samples_are_those_of_the_whole_recording() -> None:
    transform = StreamingStft(STFT)
    frames, samples = _streamed(transform)
    whole = STFT.analyse(SAMPLES)
    assert frames.shape[2] == SAMPLES.shape[1] // STFT.hop
    np.testing.assert_allclose(frames, whole[..., : frames.shape[2]], atol=1e-5)
    first = transform.first_sample(0)
    np.testing.assert_allclose(samples[:, :-first], 0, atol=1e-6)
    np.testing.assert_allclose(samples[:, -first:], SAMPLES[:, : samples.shape[1] + first], atol=1e-5)


@pytest.mark.parametrize("delay", [32, 34, 48, 64])
def test_a_shorter_synthesis_window_delays_less_and_still_gives_back_what_came(delay: int) -> None:
    transform = StreamingStft(STFT, delay)
    _, samples = _streamed(transform)
    first = transform.first_sample(0)
    assert first == STFT.hop - delay
    np.testing.assert_allclose(samples[:, -first:], SAMPLES[:, : samples.shape[1] + first], atol=1e-5)


def test_nothing_but_single_precision_comes_out() -> None:
    frames, samples = _streamed(StreamingStft(STFT))
    assert (frames.dtype, samples.dtype) == (np.complex64, np.float32)


@pytest.mark.parametrize("delay", [30, 33, 66])
def test_a_synthesis_window_that_does_not_fit_is_refused(delay: int) -> None:
    with pytest.raises(ConfigError, match="expected an even length of 32 to 64 samples, got"):
        StreamingStft(STFT, delay)


@pytest.mark.parametrize("rate", [16000, 22050, 24000, 44100, 48000])
@pytest.mark.parametrize("latency", [0.04, 0.045, 0.1, 0.2, 1.0])
def test_a_transform_is_as_late_as_it_may_be_and_not_later(rate: int, latency: float) -> None:
    transform, lookahead = transform_for(rate, latency)
    spent = (transform.latency + lookahead * transform.stft.hop) / rate
    assert min(latency, 0.14) - 2 / rate <= spent <= latency
    assert transform.stft.frame / rate == pytest.approx(0.128 if latency > 0.064 else 0.096, rel=0.05)


def test_no_transform_is_quicker_than_two_hops() -> None:
    with pytest.raises(ConfigError, match="latency: expected at least 32 ms, got 31 ms"):
        transform_for(16000, 0.031)
