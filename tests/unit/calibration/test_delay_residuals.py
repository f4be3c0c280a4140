"""Several talkers, whose azimuths are about known, tell the spacing and how differently the microphones roll off."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, lfilter

from mission_bench import SETTINGS
from ross_payload.calibration.consistency import Contradiction
from ross_payload.calibration.delay_residuals import finer_contradiction, residuals_of
from ross_payload.events import ArrayContradicted, Estimate, SourceEstimate
from ross_payload.mission import explore
from ross_payload.mission.context import Context, Listening
from ross_payload.telemetry.status_texts import line
from ross_sim.talkers.synthetic_voices import synthetic_voice
from turned_array import RATE, SPEED, waves

TALKERS = np.array([0.7, 2.6, -1.4])
TURN = np.deg2rad(15.0) * np.arange(9)
UNIT = 0.05 / SPEED
SECONDS = 1.0


@pytest.fixture(scope="module")
def voices():
    return [synthetic_voice(index, RATE).speech for index in range(len(TALKERS))]


def heard(voices, *, corners=(0.0, 0.0), delay=0.0, turn=TURN, noise=1e-3, spacing=0.05, seed=0):
    """Heading and samples of talkers in the open, by microphones that roll off at these frequencies [Hz]."""
    rng, n = np.random.default_rng(seed), round(SECONDS * RATE)
    for index, heading in enumerate(turn):
        said = np.stack([voice[index * n : (index + 1) * n] for voice in voices])
        both = waves(said, TALKERS[: len(voices)], heading, spacing, delay) + noise * rng.standard_normal((2, n))
        for channel, corner in enumerate(corners):
            if corner:
                both[channel] = lfilter(*butter(1, corner, "highpass", fs=RATE), both[channel])
        yield float(heading), both.astype(np.float32)


def believed(azimuths, *, sigma=0.01, nominal=0.01):
    return Estimate(tuple(SourceEstimate(float(a), sigma, 1.0, True, nominal_sigma=nominal) for a in azimuths))


@pytest.mark.parametrize("corners", [(20.0, 60.0), (80.0, 30.0)])
def test_the_difference_is_told_though_the_azimuths_are_off_by_it(voices, corners):
    off = TALKERS + np.deg2rad([2.0, -3.0, 2.0])
    wider, roll_off = finer_contradiction(heard(voices, corners=corners), believed(off), RATE, UNIT)
    assert wider is None
    assert roll_off == pytest.approx(corners[1] - corners[0], abs=6.0)


def test_microphones_that_are_alike_are_not_doubted(voices):
    found = residuals_of(heard(voices), TALKERS, RATE, UNIT)
    assert abs(found.roll_off) < max(4 * found.roll_off_sigma, 5.0)
    assert found.wider == pytest.approx(1.0, abs=0.01)
    assert finer_contradiction(heard(voices), believed(TALKERS), RATE, UNIT) == (None, None)


def test_one_talker_is_not_believed(voices):
    assert finer_contradiction(heard(voices[:1], corners=(0, 60)), believed(TALKERS[:1]), RATE, UNIT) == (None, None)


def test_a_reverberant_room_has_to_say_more(voices):
    estimate = believed(TALKERS, sigma=0.02)
    assert finer_contradiction(heard(voices, corners=(0, 40)), estimate, RATE, UNIT) == (None, None)


@pytest.mark.parametrize("sigmas", [{"nominal": None}, {"nominal": 0.0}, {"sigma": 0.0, "nominal": 0.0}])
def test_where_an_explorer_does_not_tell_how_reverberant_it_is_only_the_spacing_is_judged(voices, sigmas):
    estimate = believed(TALKERS, **sigmas)
    assert finer_contradiction(heard(voices, corners=(20, 60)), estimate, RATE, UNIT) == (None, None)
    assert finer_contradiction(heard(voices, spacing=0.058), estimate, RATE, UNIT)[0] > 1.1


def test_an_explorer_that_narrows_its_standard_deviations_makes_no_small_difference_a_large_one(voices):
    estimate = believed(TALKERS, sigma=0.0)
    assert finer_contradiction(heard(voices, corners=(20, 28)), estimate, RATE, UNIT) == (None, None)


def test_a_delay_is_no_roll_off(voices):
    turn = np.deg2rad(20.0) * np.arange(10)  # far enough to tell the two apart
    assert abs(residuals_of(heard(voices, delay=5e-6, turn=turn), TALKERS, RATE, UNIT).roll_off) < 10.0


def test_talkers_above_the_array_have_shorter_delays_and_no_other_roll_off(voices):
    found = residuals_of(heard(voices, spacing=0.043), TALKERS, RATE, UNIT)  # 30 deg up
    assert abs(found.roll_off) < 8.0
    assert found.wider == pytest.approx(0.86, abs=0.01)
    assert finer_contradiction(heard(voices, spacing=0.043), believed(TALKERS), RATE, UNIT) == (None, None)


def test_two_per_cent_are_not_worth_a_word(voices):
    assert finer_contradiction(heard(voices, spacing=0.051), believed(TALKERS), RATE, UNIT) == (None, None)


@pytest.mark.parametrize("spacing", [0.053, 0.058])
def test_an_array_that_is_a_little_wider_than_configured_is_noticed(voices, spacing):
    off = TALKERS + np.deg2rad([2.0, -2.0, 1.0])
    wider, roll_off = finer_contradiction(heard(voices, spacing=spacing), believed(off), RATE, UNIT)
    assert wider == pytest.approx(spacing / 0.05, rel=0.02)
    assert roll_off is None
    (event,) = explored(voices, spacing=spacing)
    assert f"spacing seems {1e3 * event.spacing:.0f} mm, not 50" in line(event)[1]


def test_what_scatters_from_heading_to_heading_is_not_said(voices):
    def wavering():
        for index, (heading, samples) in enumerate(heard(voices)):
            corner = (0, 90)[index % 2]
            samples[1] = lfilter(*butter(1, corner, "highpass", fs=RATE), samples[1]) if corner else samples[1]
            yield heading, samples

    assert abs(residuals_of(wavering(), TALKERS, RATE, UNIT).roll_off) > 15
    assert finer_contradiction(wavering(), believed(TALKERS), RATE, UNIT) == (None, None)
    narrow, wide = list(heard(voices)), list(heard(voices, spacing=0.061))
    breathing = [(narrow, wide)[index % 2][index] for index in range(len(TURN))]
    assert residuals_of(breathing, TALKERS, RATE, UNIT).wider > 1.04
    assert finer_contradiction(breathing, believed(TALKERS), RATE, UNIT)[0] is None


@pytest.mark.parametrize("turn", [TURN[:6], TURN[:0]])
def test_a_few_headings_tell_nothing(voices, turn):
    assert residuals_of(heard(voices, turn=turn), TALKERS, RATE, UNIT) is None


def test_silence_and_stretches_that_are_too_short_tell_nothing(voices):
    silent = [(heading, 0 * samples) for heading, samples in heard(voices)]
    short = [(heading, samples[:, :500]) for heading, samples in heard(voices)]
    assert residuals_of(silent, TALKERS, RATE, UNIT) is None
    assert residuals_of(short, TALKERS, RATE, UNIT) is None


def explored(voices, *, settings=SETTINGS, spread=0.0, deaf=False, **like):
    """What an exploration of these talkers has to say of the array."""
    context = Context(replace(settings, rate=RATE), tools=None)
    context.explored = [Listening(heading, samples, spread, deaf=deaf) for heading, samples in heard(voices, **like)]
    context.beliefs = [believed(TALKERS)]
    explore.check_array(context)
    return [event for event in context.pending if isinstance(event, ArrayContradicted)]


def test_an_exploration_says_so_and_an_operator_reads_it(voices):
    (event,) = explored(voices, corners=(20.0, 60.0))
    assert (event.spacing, event.gain_db, event.delay) == (None, None, None)
    assert line(event)[1] == f"array: microphone 2 rolls off about {event.roll_off:.0f} Hz higher: ross calibrate"
    assert "microphone 1 rolls off about 40 Hz higher" in line(replace(event, roll_off=-40.0))[1]


def test_nothing_finer_is_said_of_what_deaf_microphones_or_another_array_heard(voices, monkeypatch):
    assert explored(voices, corners=(20.0, 60.0), deaf=True) == []
    monkeypatch.setattr(explore, "contradiction", lambda *heard, **more: Contradiction(delay=5e-5))
    (event,) = explored(voices, corners=(20.0, 60.0))
    assert (event.delay, event.roll_off) == (5e-5, None)


def test_nothing_is_said_of_it_below_a_vehicle_or_while_the_array_turns(voices):
    assert explored(voices, corners=(20.0, 60.0), settings=replace(SETTINGS, level=False)) == []
    assert explored(voices, corners=(20.0, 60.0), spread=0.1) == []
