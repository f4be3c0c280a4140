import numpy as np
import pytest

from ross_payload.dsp.dc_offset import without_offset
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
