import importlib.util
import itertools
from dataclasses import replace

import numpy as np
import pytest

from ross_payload.errors import ConfigError
from ross_sim.talkers import texts
from ross_sim.talkers.synthetic_voices import LEVEL, RECIPES, speak, speech_text, synthetic_voice

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("espeakng_loader") is None, reason="needs the package espeakng-loader (extra sim)"
)

SHORT = "We walked for seven hours through the forest and never met another person."


def median_pitch(samples, rate):
    """Median of the autocorrelation peak over voiced frames [Hz]."""
    lags = np.arange(rate // 450, rate // 50)
    found = []
    for begin in range(0, samples.size - 2048, 1024):
        frame = samples[begin : begin + 2048] * np.hanning(2048)
        correlation = np.fft.irfft(np.abs(np.fft.rfft(frame, 4096)) ** 2)
        best = lags[correlation[lags].argmax()]
        if np.mean(frame**2) > 1e-3 and correlation[best] > 0.5 * correlation[0]:
            found.append(rate / best)
    return np.median(found)


@pytest.mark.parametrize("recipe", RECIPES[:3], ids=lambda recipe: recipe.name)
def test_a_voice_has_the_pitch_of_its_recipe(recipe):
    samples, rate = speak(recipe, SHORT)
    assert recipe.pitch[0] <= median_pitch(samples, rate) <= recipe.pitch[1]


def test_the_same_voice_says_the_same_thing_twice_alike():
    first, _ = speak(RECIPES[4], SHORT)
    second, _ = speak(RECIPES[4], SHORT)
    assert np.array_equal(first, second)


def test_there_are_eight_voices_of_different_pitch():
    pitches = sorted(recipe.pitch for recipe in RECIPES)
    assert len(pitches) >= 8
    assert all(lower[1] <= upper[1] and lower[0] < upper[0] for lower, upper in itertools.pairwise(pitches))


def test_any_three_neighbours_say_different_things():
    said = [set(speech_text(index).split(". ")) for index in range(len(RECIPES))]
    for index in range(len(RECIPES) - 2):
        assert not said[index] & (said[index + 1] | said[index + 2])
    assert not set(texts.SPEECH) & set(texts.ENROLMENT)


@pytest.mark.soak
def test_a_minute_of_levelled_speech_comes_from_the_cache_the_second_time(tmp_path):
    first = synthetic_voice(1, 16000, tmp_path)
    (path,) = (tmp_path / "voices").iterdir()
    made = path.stat().st_mtime_ns
    again = synthetic_voice(1, 16000, tmp_path)
    assert path.stat().st_mtime_ns == made
    assert np.array_equal(first.speech, again.speech)
    assert first.speech.size >= 60 * 16000
    assert first.enrolment.size >= 8 * 16000
    assert np.sqrt(np.mean(first.speech**2)) == pytest.approx(LEVEL, rel=1e-3)


def test_an_engine_that_stays_silent_is_an_error():
    with pytest.raises(ConfigError, match="voice 'arthur': espeak-ng stayed silent"):
        speak(RECIPES[0], "")


def test_an_unknown_language_is_an_error():
    with pytest.raises(ConfigError, match="does not know the voice xx"):
        speak(replace(RECIPES[0], language="xx"), SHORT)


def test_a_temporary_folder_with_a_long_path_is_an_error_not_silence(tmp_path, monkeypatch):
    deep = tmp_path / ("x" * 150)
    deep.mkdir()
    monkeypatch.setenv("TMPDIR", str(deep))
    with pytest.raises(ConfigError, match="set TMPDIR to a short one"):
        speak(RECIPES[0], SHORT)
