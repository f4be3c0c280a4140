"""What a turn tells about an array, in the open by theory, and when it tells nothing."""

import math

import numpy as np
import pytest

from examples import in_soak, rows_in_soak
from ross_payload.calibration.cross_spectrum import heading_spectrum
from ross_payload.calibration.estimate import NotCalibrated, calibrate, span_of
from turned_array import RATE, SPEED, around, heard_at, spectra


def found(headings, azimuth=0.7, **like):
    return calibrate(spectra(headings, **like), SPEED, azimuth=azimuth)


@pytest.mark.parametrize("spacing", [*in_soak(0.1, 0.03, 0.0453, 0.064)])
def test_the_spacing_is_found_within_half_a_millimetre_also_beyond_the_aliasing_limit(spacing):
    calibration = found(around(), spacing=spacing, noise=0.2)
    assert calibration.spacing == pytest.approx(spacing, abs=0.5e-3)
    assert abs(calibration.spacing - spacing) < 4 * calibration.spacing_sigma
    assert calibration.direct > 0.9


@pytest.mark.parametrize("offset_deg", [100.0, *in_soak(-30.0, 0.0, 12.0)])
def test_the_heading_offset_is_found_against_a_known_azimuth(offset_deg):
    wrong = around() - math.radians(offset_deg)  # as headings are configured
    heard = [heading_spectrum(s, RATE, float(h)) for s, h in zip(heard_at(around()), wrong, strict=True)]
    calibration = calibrate(heard, SPEED, azimuth=0.7)
    assert math.degrees(calibration.offset) == pytest.approx(offset_deg, abs=0.5)
    assert not calibration.swapped


@pytest.mark.soak
def test_without_an_azimuth_neither_offset_nor_swap_are_told_and_the_rest_is():
    calibration = found(around(), azimuth=None, gain_db=2.0, inverted=True)
    assert (calibration.offset, calibration.swapped) == (None, None)
    assert calibration.spacing == pytest.approx(0.05, abs=0.5e-3)
    assert calibration.inverted
    assert calibration.azimuth == pytest.approx(0.7, abs=0.01)


def test_microphones_that_are_swapped_are_told_from_an_offset():
    heard = [heading_spectrum(s[::-1], RATE, float(h)) for s, h in zip(heard_at(around()), around(), strict=True)]
    calibration = calibrate(heard, SPEED, azimuth=0.7)
    assert calibration.swapped
    assert math.degrees(calibration.offset) == pytest.approx(0.0, abs=0.5)


@pytest.mark.parametrize(("gain_db", "inverted"), rows_in_soak((-3.0, True), (1.5, False)))
def test_gain_and_polarity_are_found_together(gain_db, inverted):
    calibration = found(around(), gain_db=gain_db, inverted=inverted)
    assert calibration.gain_db == pytest.approx(gain_db, abs=0.2)
    assert calibration.inverted is inverted


@pytest.mark.soak
def test_a_delay_between_the_channels_is_told_apart_from_the_spacing():
    calibration = found(around(), delay=62.5e-6)
    assert calibration.delay == pytest.approx(62.5e-6, abs=1e-6)
    assert not calibration.inverted
    assert calibration.gain_db == pytest.approx(0.0, abs=0.2)
    assert calibration.spacing == pytest.approx(0.05, abs=0.5e-3)


@pytest.mark.parametrize("roll_off", [12.0, 45.0])
def test_a_microphone_that_rolls_off_higher_is_no_turned_array(roll_off):
    calibration = found(around(), roll_off=roll_off, noise=0.05)
    assert calibration.roll_off == pytest.approx(roll_off, abs=2.0)
    assert math.degrees(calibration.azimuth) == pytest.approx(math.degrees(0.7), abs=0.1)
    assert calibration.delay == pytest.approx(0.0, abs=5e-7)


def test_errors_of_the_roll_off_are_as_large_as_they_are_told():
    errors = [(each.roll_off - 20.0) / each.roll_off_sigma for each in map(rolled_off, range(6))]
    assert 0.4 < np.sqrt(np.mean(np.square(errors))) < 2.0


def rolled_off(seed):
    return found(around(), roll_off=20.0, noise=0.3, seed=seed)


@pytest.mark.soak
def test_a_third_of_a_turn_is_enough_and_delay_and_roll_off_are_not_told_then():
    calibration = found(around(8, 120.0))
    assert (calibration.delay, calibration.roll_off) == (None, None)
    assert calibration.spacing == pytest.approx(0.05, abs=0.5e-3)


@pytest.mark.soak
def test_a_sound_below_the_array_is_no_smaller_spacing_when_its_elevation_is_told():
    low = 0.05 * math.cos(math.radians(30))  # how delays of 50 mm look from there
    calibration = calibrate(spectra(around(), spacing=low), SPEED, elevation=math.radians(-30))
    assert calibration.spacing == pytest.approx(0.05, abs=0.5e-3)


def narrow(signal):
    spectrum = np.fft.rfft(signal)
    frequencies = np.fft.rfftfreq(signal.shape[1], 1 / RATE)
    return np.fft.irfft(spectrum * ((frequencies > 900) & (frequencies < 1200)), signal.shape[1]) * 5


@pytest.mark.parametrize(
    ("headings", "like", "why"),
    [
        (around(4), {}, "expected to listen at 6 headings at rest or more, for 0.5 s or more, got 4"),
        (around(8, 60.0), {}, "expected a turn of at least 90 deg, got 60"),
        (around(), {"silent": (0, 2, 3, 6)}, "or too soft: expected to hear it at 6 of 8 headings or more, got 4"),
        (around(), {"noise": 30.0, "level": 0.005}, "not steady or too soft"),
        (around(), {"azimuths": (0.7, 2.6)}, "two sounds were heard, 1.. deg apart: expected one alone"),
        (around(), {"azimuths": np.arange(24) * 2 * np.pi / 24}, "the delay is the same at all headings"),
        pytest.param(
            around(), {"azimuths": (0.7, 2.6, -1.4)}, "two sounds were heard|too reverberant", marks=pytest.mark.soak
        ),
        (around(), {"colour": narrow}, "expected a sound of 1000 Hz of bandwidth or more"),
        (around(), {"level": 1.0}, "samples at full scale at 8 of 8 headings"),
    ],
)  # fmt: skip
def test_what_does_not_serve_is_refused_in_one_line(headings, like, why):
    with pytest.raises(NotCalibrated, match=why) as refused:
        found(headings, **like)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(("dead", "rest"), [(1, 0.0), (2, 1e-3)])
def test_a_dead_microphone_is_named(dead, rest):
    noise = np.random.default_rng(1).standard_normal
    heard = []
    for samples, heading in zip(heard_at(around()), around(), strict=True):
        samples[dead - 1] = rest * samples.std() * noise(samples.shape[1])
        heard.append(heading_spectrum(samples, RATE, float(heading)))
    with pytest.raises(NotCalibrated, match=f"microphone {dead} is dead"):
        calibrate(heard, SPEED)


def test_a_stretch_that_is_too_short_tells_nothing():
    assert heading_spectrum(np.zeros((2, 8000), np.float32), RATE, 0.0) is None


def test_digital_silence_is_not_heard():
    silent = heading_spectrum(np.zeros((2, RATE), np.float32), RATE, 0.0)
    assert silent.coherence <= 0
    assert not silent.weight.any()


def test_the_span_of_a_turn_is_counted_across_the_back():
    assert math.degrees(span_of(np.deg2rad([170, 180, -170, -160]))) == pytest.approx(30)
    assert span_of([1.0]) == 0.0
