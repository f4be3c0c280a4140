"""The voice print: what it accepts, what it refuses, and what it must not depend on."""

import time
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from examples import in_soak
from ross_payload.errors import AudioError, ConfigError
from ross_payload.voiceprint import built_in_model, enrol
from ross_payload.voiceprint.built_in import FILE, encode_model, read_model
from ross_payload.voiceprint.features import RATE, analyse, mel_filters
from ross_payload.voiceprint.speaker_model import clipped_share

ANN = (210.0, (850, 1650, 2900, 4100))  # pitch and formants [Hz]
BOB = (105.0, (600, 1150, 2350, 3300))


@cache
def talk(talker, seconds, seed, rate=RATE):
    """Vowels of a source-filter talker: pulses with a moving pitch through moving resonances, with pauses."""
    pitch, formants = talker
    rng = np.random.default_rng(seed)
    n = int(seconds * rate)
    t = np.arange(n) / rate
    wander = np.interp(t, np.arange(0, seconds + 1, 0.25), rng.uniform(-1, 1, 4 * int(np.ceil(seconds)) + 4))
    phase = 2 * np.pi * np.cumsum(pitch * 1.12**wander) / rate
    shift = np.interp(t, np.arange(0, seconds + 1, 0.2), rng.uniform(-1, 1, 5 * int(np.ceil(seconds)) + 5))
    voice = np.zeros(n)
    for harmonic in range(1, int(6500 / pitch)):
        frequency = harmonic * pitch
        gain = sum(1 / (1 + ((frequency - formant * 1.2**shift) / 120) ** 2) for formant in formants) / harmonic**0.5
        voice += gain * np.sin(harmonic * phase)
    pauses = np.sin(2 * np.pi * t / 1.3) > -0.8
    spoken = 0.1 * voice * pauses / np.sqrt(np.mean(voice**2)) + 1e-5 * rng.standard_normal(n)
    spoken.flags.writeable = False  # several tests share it
    return spoken


@pytest.fixture(scope="module")
def ann():
    return enrol(talk(ANN, 4, seed=0), RATE)


def test_the_enrolled_voice_is_accepted_and_scores_above_another(ann):
    same, other = ann.score(talk(ANN, 3, seed=1), RATE), ann.score(talk(BOB, 3, seed=2), RATE)
    assert same.accepted
    assert same.value > max(0, other.value)  # how far vowels of a formula are from people is not what the model knows


def test_the_score_does_not_depend_on_the_level(ann):
    voice = talk(ANN, 3, seed=1)
    assert ann.score(0.01 * voice, RATE).value == pytest.approx(ann.score(voice, RATE).value, abs=1e-3)


@pytest.mark.soak
def test_the_score_hardly_depends_on_the_sampling_rate(ann):
    at_48k = talk(ANN, 3, seed=1, rate=48000)
    at_16k = at_48k.reshape(-1, 3)[:, 0]  # nothing above 8 kHz but the noise 80 dB below
    assert ann.score(at_48k, 48000).value == pytest.approx(ann.score(at_16k, RATE).value, abs=0.3)


@pytest.mark.parametrize("seconds", in_soak(1.5, 3.0, 10.0))
def test_the_enrolled_voice_is_accepted_however_long_it_speaks(ann, seconds):
    assert ann.score(talk(ANN, 10, seed=3)[: round(seconds * RATE)], RATE).accepted


@pytest.mark.parametrize("seconds", [0.1, 3.0])
def test_silence_is_undecided_and_not_accepted(ann, seconds):
    score = ann.score(np.zeros(int(seconds * RATE)), RATE)
    assert score.value == 0
    assert not score.accepted


def test_noise_is_not_accepted(ann):
    for seed in range(5):
        assert not ann.score(np.random.default_rng(seed).standard_normal(3 * RATE), RATE).accepted


def test_the_criterion_decides(ann):
    voice = talk(ANN, 3, seed=1)
    value = ann.score(voice, RATE).value
    assert not replace(ann, criterion=value + 0.01).score(voice, RATE).accepted
    assert replace(ann, criterion=value - 0.01).score(voice, RATE).accepted


def test_scoring_the_same_recording_twice_gives_the_same_bits(ann):
    voice = talk(ANN, 3, seed=1)
    assert ann.score(voice, RATE) == ann.score(voice.copy(), RATE)


def test_scoring_costs_less_than_20_ms_of_cpu_per_second(ann):
    voice = talk(ANN, 10, seed=3)
    costs = []
    for _ in range(3):
        before = time.process_time()
        ann.score(voice, RATE)
        costs.append((time.process_time() - before) / 10)
    assert min(costs) < 0.02


def tone(frequency):
    return 0.3 * np.sin(2 * np.pi * frequency * np.arange(4 * RATE) / RATE)


def broken(voice, index, value):
    damaged = voice.copy()
    damaged[index] = value
    return damaged


@pytest.mark.parametrize(
    ("samples", "says"),
    [
        (np.zeros(0), "expected a recording, got 0 s"),
        (np.zeros(4 * RATE), "expected speech, got 4.0 s of silence"),
        (talk(ANN, 1, seed=0), "expected at least 1.5 s of voiced speech"),
        (np.random.default_rng(0).standard_normal(4 * RATE), "expected at least 1.5 s of voiced speech"),
        (broken(talk(ANN, 4, seed=0), 7, np.nan), "expected finite samples, got 1"),
        (broken(talk(ANN, 4, seed=0), 7, np.inf), "expected finite samples, got 1"),
        (np.clip(talk(ANN, 4, seed=0), -0.1, 0.1), "clipped"),
        (np.full(4 * RATE, 0.5), "expected speech, got 4.0 s of a constant level, 0.5 re full scale"),
        (-0.25 + 1e-5 * np.random.default_rng(0).standard_normal(4 * RATE), "of a constant level, -0.25 re full scale"),
        (tone(440), "expected speech, got a tone of 440 Hz"),
        (np.round(2**15 * tone(50)) / 2**15, "expected speech, got a tone of 50 Hz"),
        (tone(0.3) + 0.001 * np.random.default_rng(0).standard_normal(4 * RATE), "got a level that drifts"),
        (0.3 + tone(123) + 0.01 * np.random.default_rng(0).standard_normal(4 * RATE), "got a tone of 123 Hz"),
        (1e30 * talk(ANN, 4, seed=0), r"expected samples of at most 1e\+06 re full scale, got .*e\+29"),
        (np.zeros((2, 4 * RATE)), "one channel"),
    ],
)
def test_what_cannot_be_enrolled_is_refused_with_the_reason(samples, says):
    with pytest.raises(AudioError, match=says):
        enrol(samples, RATE)


@pytest.mark.parametrize("use", [enrol, lambda voice, rate: enrol(talk(ANN, 4, seed=0), RATE).score(voice, rate)])
def test_a_telephone_rate_is_refused_by_its_number(use):
    with pytest.raises(AudioError, match="expected a rate of at least 16000 Hz, got 8000 Hz"):
        use(talk(ANN, 4, seed=0), 8000)


@pytest.mark.parametrize("use", [enrol, lambda voice, rate: enrol(talk(ANN, 4, seed=0), RATE).score(voice, rate)])
def test_a_rate_that_no_recording_has_is_refused_by_its_number(use):
    with pytest.raises(AudioError, match="expected a rate of at most 192000 Hz, got 1999999999 Hz"):
        use(talk(ANN, 4, seed=0), 1_999_999_999)


def test_numbers_that_are_not_finite_are_refused_when_scoring(ann):
    with pytest.raises(AudioError, match="expected finite samples"):
        ann.score(broken(talk(ANN, 3, seed=0), 0, np.nan), RATE)


@pytest.mark.parametrize("talker", [ANN, BOB])
@pytest.mark.parametrize(("frequency", "gain"), [(0.3, 10), (50, 1), (50, 10), (60, 0.25), (60, 10)])
def test_drift_and_the_hum_of_the_mains_are_no_part_of_a_voice(talker, frequency, gain):
    voice, hum = talk(talker, 4, seed=0), tone(frequency)
    hummed, clean = enrol(voice + gain * hum * voice.std() / hum.std(), RATE), enrol(voice, RATE)
    for seed in range(3):
        heard = talk(talker, 4, seed=seed + 1)
        assert hummed.score(heard, RATE).value == pytest.approx(clean.score(heard, RATE).value, abs=1.0)


def test_a_slow_tone_at_the_rate_of_a_sound_card_is_not_called_clipped():
    with pytest.raises(AudioError, match="expected speech, got a tone of 50 Hz"):
        enrol(0.3 * np.sin(2 * np.pi * 50 * np.arange(4 * 48_000) / 48_000), 48_000)


def test_loud_speech_that_is_not_cut_is_not_called_clipped():
    voice = talk(ANN, 4, seed=0)
    assert clipped_share(voice / np.abs(voice).max()) == 0


@pytest.mark.parametrize("pitch", [80.0, 125.0, 220.0, 320.0])
def test_the_pitch_of_a_harmonic_sound_is_found(pitch):
    t = np.arange(RATE) / RATE
    tone = sum(np.sin(2 * np.pi * pitch * k * t) / k for k in range(1, 15))
    found = np.exp(np.median(analyse(tone, RATE).pitch))
    assert found == pytest.approx(pitch, rel=0.025)  # the lag is a whole number of samples: 1 of 50 at 320 Hz


def test_every_frequency_inside_the_bands_is_weighed_once():
    filters = mel_filters()
    frequencies = np.arange(filters.shape[1]) * RATE / 512
    inner = (frequencies > 250) & (frequencies < 6300)  # the outermost triangles have one neighbour
    np.testing.assert_allclose(filters.sum(axis=0)[inner], 1)


def test_the_shipped_model_is_small_and_survives_encoding():
    from importlib.resources import files

    content = files("ross_payload.voiceprint").joinpath(FILE).read_bytes()
    assert len(content) < 2_000_000
    model = built_in_model()
    assert read_model(encode_model(model.parameters), "again").fingerprint == model.fingerprint


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 not a zip", encode_model(built_in_model().parameters)[:5000]])
def test_a_damaged_model_is_refused(content):
    with pytest.raises(ConfigError, match=r"other\.npz: expected a model of voices"):
        read_model(content, "other.npz")


def test_a_print_is_of_many_conditions_unless_it_was_separated(ann):
    separated = enrol(talk(ANN, 4, seed=0), RATE, separated=True)
    assert separated.embedding == pytest.approx(built_in_model().embed(talk(ANN, 4, seed=0)))
    assert 0.5 < float(ann.embedding @ separated.embedding) < 0.9999
    assert separated.criterion == pytest.approx(float(built_in_model().parameters.separated))
