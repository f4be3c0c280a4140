"""Sources are followed from the phases of trustworthy bins: theory makes the phases here."""

import math
from dataclasses import replace

import numpy as np
import pytest

from examples import in_soak
from heard_phases import SPACING, SPEED, STEP, phases
from ross_payload.alignment.predicted_gain import predicted_gain
from ross_payload.alignment.realignment import Beliefs, resolving_value, worth
from ross_payload.events import Estimate, SourceEstimate
from ross_payload.localization import tracking
from ross_payload.localization.phase_statistics import FrameStatistics, silence, statistics
from ross_payload.localization.talker_motion import AZIMUTHS

NEVER = 99.0


def found(*degrees):
    sources = (SourceEstimate(math.radians(a), math.radians(0.5), 1.0, resolved=True) for a in degrees)
    return Estimate(tuple(sources), certain=True, directness=1.0)


def test_tracks_know_reflections_by_the_directness_alone():
    told = found(-10.0, 100.0)
    wider = replace(
        told, sources=tuple(replace(each, sigma=math.radians(5.0), nominal_sigma=each.sigma) for each in told.sources)
    )
    plain, wet = (tracking.begin(each, SPACING, SPEED) for each in (told, wider))
    np.testing.assert_array_equal(plain.home_densities, wet.home_densities)


def follow(paths, seconds, heading=lambda time: 0.6, seed=0, silent=()):
    """Follow sources at paths [deg] (functions of time); those in ``silent`` say nothing; yields time and tracks."""
    rng = np.random.default_rng(seed)
    tracks = tracking.begin(found(*(path(0.0) for path in paths)), SPACING, SPEED)
    for time in np.arange(STEP, seconds + STEP / 2, STEP):
        heard = [path(time - STEP / 2) for k, path in enumerate(paths) if k not in silent]
        now = phases(heard, heading(time), rng) if heard else silence(STEP)
        tracks = tracking.step(tracks, now)
        yield time, tracks


def overheard(path, seconds, loud, heading=0.6, seed=0):
    """Follow a quiet source at a path [deg] beside a loud one at rest: it has a few bins in some steps only."""
    rng = np.random.default_rng(seed)
    tracks = tracking.begin(found(loud, path(0.0)), SPACING, SPEED)
    for number, time in enumerate(np.arange(STEP, seconds + STEP / 2, STEP)):
        both = [phases([loud], heading, rng, 120)]
        both += [phases([path(time - STEP / 2)], heading, rng, 24)] if number % 5 == 0 else []
        joined = (
            np.concatenate([getattr(each, name) for each in both]) for name in ("frequencies", "phases", "weights")
        )
        bundle = np.zeros(sum(len(each.bundle) for each in both), np.intp)
        tracks = tracking.step(tracks, FrameStatistics(STEP, np.array([heading]), bundle, *joined))
        yield time, tracks


def beliefs_of(tracks):
    odds, ways = tracks.ways
    return Beliefs(odds, ways, tracks.azimuths, tracks.spreads, tracks.elevations, 1.0)


def odds_of(tracks, k, degrees):
    """How likely source ``k`` is within 15 deg of an azimuth [deg]."""
    off = np.abs(np.angle(np.exp(1j * (AZIMUTHS - math.radians(degrees)))))
    return float(tracks.places[k][off < math.radians(15)].sum())


def at(degrees):
    return lambda time: degrees


def walk(start, speed, since=1.0):
    return lambda time: start + speed * max(time - since, 0.0)


def off(tracks, k, degrees):
    return abs(math.degrees(np.angle(np.exp(1j * (tracks.azimuths[k] - math.radians(degrees))))))


@pytest.mark.parametrize("speed", [5.0, *in_soak(-10.0)])
def test_a_source_that_walks_is_followed_and_the_others_stay(speed):
    path = walk(100.0, speed)
    time, tracks = list(follow([at(0.0), path, at(-140.0)], 6.0))[-1]
    assert off(tracks, 1, path(time)) < 4.0
    assert math.degrees(tracks.rates[1]) == pytest.approx(speed, abs=4.0)
    assert max(off(tracks, 0, 0.0), off(tracks, 2, -140.0)) < 3.0


def test_a_source_is_followed_while_the_array_turns():
    path = walk(100.0, 5.0)
    turning = follow([at(-30.0), path], 6.0, heading=lambda time: 0.6 + math.radians(4) * time)
    time, tracks = list(turning)[-1]
    assert off(tracks, 1, path(time)) < 4.0


def test_a_quiet_source_that_walks_is_found_beside_a_loud_one():
    """A loud one that rests must not select, by chance, among the particles that have the quiet one walk."""
    late = []
    for seed in range(6):
        path = walk(100.0, 8.0)
        errors = [
            (time, off(tracks, 1, path(time)), off(tracks, 0, -20.0))
            for time, tracks in overheard(path, 9.0, -20.0, seed=seed)
        ]
        late += [error for time, error, _ in errors if time > 4.5]
        assert max(other for _, _, other in errors) < 5.0
    assert np.sqrt(np.mean(np.square(late))) < 9.0


@pytest.mark.parametrize("seed", [0, *in_soak(1, 2)])
def test_a_source_that_passes_another_one_keeps_its_name(seed):
    path = walk(60.0, 10.0)
    time, tracks = list(follow([path, at(100.0), at(-140.0)], 9.0, seed=seed))[-1]
    assert off(tracks, 0, path(time)) < 5.0
    assert off(tracks, 1, 100.0) < 5.0
    assert off(tracks, 2, -140.0) < 5.0


def test_after_a_long_silence_a_source_that_has_gone_on_is_found_again():
    path = walk(100.0, 6.0)
    rng, sigmas = np.random.default_rng(0), []
    tracks = tracking.begin(found(-10.0, 100.0), SPACING, SPEED)
    for time in np.arange(STEP, 14.0, STEP):
        spoken = [-10.0] if 3.0 < time < 9.0 else [-10.0, path(time - STEP / 2)]
        tracks = tracking.step(tracks, phases(spoken, 0.6, rng))
        sigmas.append(tracks.sigmas[1])
    silent = sigmas[13:35]
    assert max(silent) > 3 * sigmas[2]
    assert off(tracks, 1, path(time)) < 5.0
    assert off(tracks, 0, -10.0) < 3.0


def test_who_is_silent_becomes_uncertain_and_old():
    sigmas, ages = [], []
    for _, tracks in follow([at(100.0), at(-60.0)], 12.0, silent=(1,)):
        sigmas.append(tracks.sigmas[1])
        ages.append(tracks.ages[1])
    assert np.mean(sigmas[-20:]) > 3 * sigmas[0]
    assert ages[-1] > 9.0
    assert tracks.ages[0] < 1.0
    assert math.degrees(tracks.sigmas[0]) < 5.0


@pytest.mark.soak
def test_errors_are_as_large_as_sigma_says():
    """Root mean square of the errors over their sigmas; the prior must cover walkers of all kinds, so below 1 here."""
    quotients = []
    for seed in (0, 3):
        path = walk(100.0, 4.0 + 2 * seed, since=2.0)
        for time, tracks in follow([at(-30.0), path, at(-140.0)], 8.0, seed=seed):
            quotients += [
                off(tracks, k, true) / math.degrees(tracks.sigmas[k]) for k, true in enumerate((-30, path(time), -140))
            ]
    assert 0.2 < np.sqrt(np.mean(np.square(quotients))) < 1.3


def test_past_the_axis_both_sides_stay_possible_until_the_array_turns():
    turned = 6.0
    path = walk(40.0, 8.0)  # the axis points to 34 deg: it cannot be told which way the source has gone
    for time, tracks in follow([path, at(-100.0)], 9.0, heading=lambda time: 0.6 if time < turned else 0.25):
        if time == turned - STEP:
            mirrored = 2 * math.degrees(0.6) - path(time)
            assert odds_of(tracks, 0, path(time)) > 0.2
            assert odds_of(tracks, 0, mirrored) > 0.02
            here, there = resolving_value(beliefs_of(tracks), 0.6 + np.radians([0.0, -20.0]))
            assert there > here + 0.5  # a turn would tell
    assert off(tracks, 0, path(time)) < 5.0
    assert odds_of(tracks, 0, path(time)) > 0.9


@pytest.mark.soak
def test_of_two_with_one_delay_either_may_have_set_out_until_the_array_turns():
    """Sources 1 and 2 are 50 degrees to either side of the axis, and 2 sets out; source 0 is the one listened to."""
    axis, turned = 40.0, 5.0
    path = walk(axis - 50.0, -8.0)
    heading = lambda time: math.radians(axis if time < turned else axis + 25.0)  # noqa: E731
    for time, tracks in follow([at(160.0), at(axis + 50.0), path], 8.0, heading=heading):
        if time == turned - STEP:
            stays = [odds_of(tracks, 1, axis + 50.0), odds_of(tracks, 2, axis - 50.0)]
            assert min(stays) > 0.15
            assert sum(stays) == pytest.approx(1.0, abs=0.2)
            here, there = resolving_value(beliefs_of(tracks), np.radians([axis, axis + 25.0]))
            assert there > here + 2.0
    assert off(tracks, 2, path(time)) < 5.0
    assert max(off(tracks, 0, 160.0), off(tracks, 1, axis + 50.0)) < 2.0
    assert odds_of(tracks, 1, axis + 50.0) > 0.95


@pytest.mark.soak
def test_what_was_taken_for_sure_is_corrected_when_it_turns_out_wrong():
    """A hypothesis is never so unlikely that a second or two in which it alone fits cannot bring it back."""
    path, rng = walk(-10.0, -8.0), np.random.default_rng(0)
    tracks = tracking.begin(found(160.0, 90.0, -10.0), SPACING, SPEED)
    for time in np.arange(STEP, 5.0, STEP):
        heading = math.radians(40.0 if time <= 3.0 else 65.0)  # either may have set out until the array turns
        tracks = tracking.step(tracks, phases([160.0, 90.0, path(time - STEP / 2)], heading, rng))
        if time == 3.0:
            wrong = max(tracks.hypotheses, key=lambda each: (each.members == (1,)) * each.weight)
            rest = [replace(each, weight=1e-9) for each in tracks.hypotheses if each is not wrong]
            tracks = replace(tracks, hypotheses=(replace(wrong, weight=1.0), *rest))
    assert off(tracks, 2, path(time)) < 6.0
    assert off(tracks, 1, 90.0) < 3.0


@pytest.mark.parametrize("seconds", [15.0, *in_soak(30.0)])
def test_those_at_rest_do_not_drift_while_somebody_walks_past(seconds):
    def to_and_fro(time):
        return 100.0 - 40.0 * math.cos(2 * math.pi * time / 30.0)

    errors = []
    for _, tracks in follow([at(-20.0), to_and_fro, at(170.0)], seconds, seed=3):
        errors.append((off(tracks, 0, -20.0), off(tracks, 2, 170.0)))
    assert np.sqrt(np.mean(np.square(errors), axis=0)).max() < 1.5
    assert np.max(errors) < 5.0


def test_where_everything_is_clear_a_heading_is_worth_the_predicted_gain():
    azimuths = np.radians([-30.0, 100.0, -150.0])
    tracks = tracking.begin(found(-30.0, 100.0, -150.0), SPACING, SPEED)
    headings = np.radians([60.0, 80.0, 110.0])
    value = worth(beliefs_of(tracks), 0, headings)
    gain = predicted_gain(azimuths, headings, directness=1.0)[0]
    assert np.allclose(value - value[0], gain - gain[0], atol=0.5)


def test_the_same_frames_give_the_same_tracks():
    one, two = (list(follow([at(0.0), walk(90.0, 5.0)], 2.0))[-1][1] for _ in range(2))
    assert np.array_equal(one.places, two.places)


def test_nobody_is_followed_when_nobody_was_found():
    tracks = tracking.begin(Estimate(()), SPACING, SPEED)
    assert tracking.step(tracks, silence(STEP)).azimuths.size == 0


def test_bins_of_one_wave_have_its_delay_and_those_beside_a_motor_do_not_count():
    rate, frame, hop = 16000, 512, 128
    rng, n = np.random.default_rng(0), 16000
    spectrum = np.fft.rfft(rng.standard_normal(n))
    delay = SPACING / SPEED * math.cos(math.radians(40.0))
    sound = np.fft.irfft(spectrum * np.exp(2j * np.pi * np.fft.rfftfreq(n, 1 / rate) * delay))
    cut = np.stack([np.fft.irfft(spectrum), sound])
    frames = np.stack([cut[:, k : k + frame] * np.hanning(frame) for k in range(0, 4000, hop)], axis=-1)
    spectrogram, frequencies = np.fft.rfft(frames, axis=1), np.fft.rfftfreq(frame, 1 / rate)
    headings, count = np.zeros(spectrogram.shape[-1]), spectrogram.shape[-1]
    silent_psd = np.full(frequencies.size, 1e-9)
    heard = statistics(spectrogram, frequencies, headings, silent_psd, period=hop / rate, skip=4)
    assert heard.seconds == pytest.approx((count - 4) * hop / rate)
    assert len(heard.weights) > 50
    expected = 2 * np.pi * heard.frequencies * delay
    assert np.abs(np.angle(np.exp(1j * (heard.phases - expected)))).mean() < 0.1
    none = np.zeros(count, bool)
    beside = statistics(spectrogram, frequencies, headings, silent_psd, period=hop / rate, still=none)
    assert len(beside.weights) == 0


def test_a_source_below_is_followed_by_its_shorter_delay():
    high = replace(found(100.0).sources[0], elevation=math.radians(-50))
    tracks = tracking.begin(Estimate((high,), certain=True, directness=1.0), SPACING, SPEED)
    assert tracks.elevations[0] == pytest.approx(math.cos(math.radians(50)))
