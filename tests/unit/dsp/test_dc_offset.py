import numpy as np
import pytest

from ross_payload.dsp.dc_offset import OffsetFilter, without_offset
from ross_payload.dsp.stft import Stft


def test_what_has_no_offset_is_left_alone() -> None:
    sound = np.random.default_rng(0).standard_normal((2, 16000)).astype(np.float32)
    assert without_offset(sound) is sound
    empty = np.zeros((2, 0), np.float32)
    assert without_offset(empty) is empty
    assert without_offset(np.zeros((2, 100), np.float32)).tolist() == np.zeros((2, 100)).tolist()


@pytest.mark.parametrize("offset", [0.01, 0.03, -0.5])
def test_an_offset_makes_no_click_at_the_ends_of_a_period(offset: float) -> None:
    """A step at both ends would be alike at both microphones: a talker ahead."""
    noise = 1e-4 * np.random.default_rng(1).standard_normal((2, 48000)).astype(np.float32)
    stft = Stft(16000, 1024, 256)
    quiet = np.abs(stft.analyse(noise)) ** 2
    heard = np.abs(stft.analyse(without_offset(noise + np.float32(offset)))) ** 2
    assert heard.mean(axis=(1, 2)) == pytest.approx(quiet.mean(axis=(1, 2)), rel=0.01)
    clicks = np.abs(stft.analyse(noise + np.float32(offset))) ** 2
    assert clicks[:, 10:].mean() > 2 * quiet[:, 10:].mean()


@pytest.mark.parametrize(("begin", "end"), [(20000, 36000), (0, 16000), (47000, 48000)])
def test_samples_that_never_came_stay_zeros_and_hide_no_offset(begin: int, end: int) -> None:
    """Less the mean of zeros and the rest they would be a step at both edges of the gap: a talker who is not there."""
    noise = 1e-2 * np.random.default_rng(5).standard_normal((2, 48000)).astype(np.float32)
    heard = noise + np.array([[0.05], [0.02]], np.float32)
    heard[:, begin:end] = 0
    left = without_offset(heard)
    assert not left[:, begin:end].any()
    came = np.r_[0:begin, end:48000]
    assert left[:, came] == pytest.approx(noise[:, came], abs=2e-4)


def test_what_came_of_a_period_does_not_pass_for_an_offset_because_the_rest_is_missing() -> None:
    noise = 1e-2 * np.random.default_rng(6).standard_normal((2, 48000)).astype(np.float32)
    noise[:, 8000:] = 0
    assert without_offset(noise) is noise


def test_zeros_of_a_soft_sound_are_sound() -> None:
    """Half of the samples of the least level that 16 bits have are 0, at both microphones at once here and there."""
    counts = np.random.default_rng(7).integers(0, 2, (2, 16000)) * 2.0**-15
    left = without_offset(counts.astype(np.float32))
    assert left.mean() == pytest.approx(0, abs=1e-9)
    assert left.std() == pytest.approx(counts.std(), rel=1e-3)


def passed(sound: np.ndarray, hop: int = 160) -> np.ndarray:
    offset_filter = OffsetFilter(16000, len(sound))
    return np.concatenate([offset_filter.push(sound[:, i : i + hop]) for i in range(0, sound.shape[1], hop)], axis=1)


def test_a_stream_without_an_offset_passes_as_it_is() -> None:
    sound = np.random.default_rng(2).standard_normal((2, 80000)).astype(np.float32)
    assert passed(sound).tobytes() == sound.tobytes()


@pytest.mark.parametrize("hop", [16, 160, 80000])
def test_the_offset_of_a_stream_goes_without_a_step_in_the_channel_that_has_one(hop: int) -> None:
    sound = 0.01 * np.random.default_rng(3).standard_normal((2, 160000)).astype(np.float32)
    heard = passed(sound + np.array([[0.1], [0.0]], np.float32), hop)
    assert heard[1].tobytes() == sound[1].tobytes()
    assert heard[0, 80000:] == pytest.approx(sound[0, 80000:], abs=5e-4)
    assert np.abs(np.diff(heard[0] - sound[0])).max() < 1.1 * 0.1 / hop


def test_an_offset_that_is_louder_than_the_rest_goes_before_the_lead_in_is_over():
    sound = 0.01 * np.random.default_rng(4).standard_normal((1, 16000)).astype(np.float32)
    assert passed(sound + np.float32(0.1))[0, 5000:].mean() == pytest.approx(0, abs=1e-3)


def test_a_tone_stays_when_an_offset_drifts_away() -> None:
    tone = 0.1 * np.sin(2 * np.pi * 100 / 16000 * np.arange(480000)).astype(np.float32)
    offset = np.interp(np.arange(480000), [0, 160000, 160001], [0.2, 0.2, 0.0]).astype(np.float32)
    assert passed((tone + offset)[None])[0, -16000:] == pytest.approx(tone[-16000:], abs=0.01)
