import itertools
import math

import numpy as np
import pytest
from scipy.signal import butter, sosfilt

from ross_sim.acoustics.impulse_responses import Responses
from ross_sim.acoustics.render import FULL_STEP, Microphones, MotorNoise, TalkerSignals, gains
from ross_sim.acoustics.room import RoomSpec, respond
from ross_sim.talkers.timeline import Timeline

RATE = 16000
QUANTUM = RATE // 100
SPACING = 0.05


def room(t60=0.0):
    return RoomSpec((10.0, 10.0), t60, RATE, (5.0, 5.0), SPACING, ((7.0, 6.0), (4.0, 7.5)))


def noise(seed, seconds=3):
    return np.random.default_rng(seed).standard_normal(seconds * RATE).astype(np.float32)


def tone(seconds=3):
    return np.sin(2 * np.pi * 200 * np.arange(seconds * RATE) / RATE).astype(np.float32)


def stems(tmp_path, spec, *speech):
    timelines = [Timeline.of(said, RATE) for said in speech]
    return TalkerSignals(timelines, [1.0] * len(speech), Responses(spec, tmp_path), RATE)


def hear(ears, path):
    """What is heard along headings at the ends of quanta, (2, n_talkers, n)."""
    parts = [
        ears.render(index * QUANTUM, (index + 1) * QUANTUM, begin, end)
        for index, (begin, end) in enumerate(itertools.pairwise(path))
    ]
    return np.concatenate(parts, axis=-1)


def direct(spec, heading, speech, n):
    """Plain convolution with the response of one heading, (2, n_talkers, n)."""
    (response,) = respond(spec, [heading])
    dry = [Timeline.of(said, RATE).between(0, n).astype(float) for said in speech]
    return np.array([[np.convolve(d, taps)[:n] for d, taps in zip(dry, mic, strict=True)] for mic in response])


@pytest.mark.parametrize("t60", [0.0, 0.4])
def test_rest_is_the_response_of_the_exact_heading(tmp_path, t60):
    spec, speech, heading = room(t60), (noise(1), noise(2)), 0.123456
    heard = hear(Microphones(stems(tmp_path, spec, *speech), SPACING, heading), np.full(151, heading))
    truth = direct(spec, heading, speech, heard.shape[-1])
    assert np.abs(heard - truth).max() < 1e-5 * np.abs(truth).max()


def test_rest_after_a_turn_is_the_response_of_the_exact_heading_too(tmp_path):
    spec, speech, goal = room(), (noise(1), noise(2)), math.radians(15.3)
    path = np.concatenate([np.zeros(20), np.linspace(0, goal, 30), np.full(50, goal)])
    heard = hear(Microphones(stems(tmp_path, spec, *speech), SPACING, 0.0), path)
    truth = direct(spec, goal, speech, heard.shape[-1])
    settled = 55 * QUANTUM  # three quanta at rest, one of fading
    assert np.abs(heard - truth)[..., settled:].max() < 1e-5 * np.abs(truth).max()


def curvature(heard):
    return np.abs(np.diff(heard, n=2, axis=-1)).max()


@pytest.mark.parametrize("t60", [0.0, 0.4])
def test_turning_does_not_click(tmp_path, t60):
    spec, speech = room(t60), (tone(), tone())
    there = stems(tmp_path, spec, *speech)
    path = np.concatenate([np.full(80, 0.02), 0.02 + np.linspace(0, 0.5, 40), np.full(30, 0.52)])
    rest = hear(Microphones(there, SPACING, 0.02), np.full(150, 0.02))[..., RATE // 2 :]
    turning = hear(Microphones(there, SPACING, 0.02), path)[..., RATE // 2 :]
    assert curvature(turning) < 1.3 * curvature(rest)


def test_a_hard_switch_of_headings_would_click(tmp_path):
    there = stems(tmp_path, room(), tone(), tone())
    parts = [there.at(index * math.radians(5), 4000 + 400 * index, 4400 + 400 * index) for index in range(20)]
    assert curvature(np.concatenate(parts, axis=-1)) > 1.5 * curvature(there.at(0.0, 4000, 12000))


def test_between_two_headings_of_the_grid_the_error_is_small(tmp_path):
    speech = tuple(sosfilt(butter(8, 4000, fs=RATE, output="sos"), noise(seed)).astype(np.float32) for seed in (1, 2))
    heading = math.radians(2.5)  # half way from 0 to 5 deg
    creeping = heading + 3e-6 * np.arange(101)  # too fast to count as rest, too slow to leave the heading
    heard = hear(Microphones(stems(tmp_path, room(), *speech), SPACING, 1.0), creeping)
    truth = direct(room(), heading, speech, heard.shape[-1])
    error = np.mean((heard - truth)[..., QUANTUM:] ** 2) / np.mean(truth**2)
    assert 10 * np.log10(error) < -35


@pytest.mark.parametrize("cuts", [(0, 9000, 20000), (0, 7999, 8000, 8001, 20000), tuple(range(0, 20001, 500))])
def test_a_sample_does_not_depend_on_who_asks(tmp_path, cuts):
    whole = stems(tmp_path, room(0.4), noise(1), noise(2)).at(0.3, 0, 20000)
    there = stems(tmp_path, room(0.4), noise(1), noise(2))
    parts = [there.at(0.3, first, last) for first, last in itertools.pairwise(cuts)]
    assert np.array_equal(np.concatenate(parts, axis=-1), whole)


def test_gains_give_equal_power_and_levels():
    speech = [noise(1), 0.1 * noise(2)]
    response = respond(room(), [0.0])[0]
    loud, soft = gains(speech, [0.0, -6.0], response, rms=0.05)
    powers = [
        gain**2 * np.mean(np.convolve(said, taps)[: said.size] ** 2)
        for gain, said, taps in zip((loud, soft), speech, response[0], strict=True)
    ]
    assert sum(powers) == pytest.approx(0.05**2, rel=1e-4)
    assert 10 * np.log10(powers[0] / powers[1]) == pytest.approx(6.0, abs=1e-3)


def test_pauses_start_and_end_are_silent_and_the_speech_loops():
    talk = Timeline.of(noise(1, seconds=1), RATE, start=1.0, end=4.0, pauses=[(2.0, 2.5)])
    said = talk.between(0, 5 * RATE)
    for silent in (slice(0, RATE), slice(2 * RATE, 5 * RATE // 2), slice(4 * RATE, None)):
        assert not said[silent].any()
    middle = slice(RATE // 10, RATE * 9 // 10)
    third, first = said[3 * RATE : 4 * RATE], said[RATE : 2 * RATE]
    assert np.array_equal(third[middle], first[middle])
    assert np.mean(said[RATE : 2 * RATE] ** 2) == pytest.approx(1.0, rel=0.05)


def test_a_start_beyond_all_time_never_comes():
    talk = Timeline.of(noise(1, seconds=1), RATE, start=1e308, end=1.5e308, pauses=[(1e307, 1e308)])
    assert not talk.between(0, RATE).any()


def test_motor_is_silent_at_rest_and_fades():
    motor = MotorNoise(0.1, np.random.default_rng(1))
    assert motor.between(0.3, 0.3, QUANTUM) == 0.0
    first = motor.between(0.3, 0.31, QUANTUM)
    assert first[0] == 0.0
    assert np.abs(first).max() > 0.0
    last = motor.between(0.31, 0.31, QUANTUM)
    assert np.abs(last[-10:]).max() < 0.1 * np.abs(last).max()
    assert motor.between(0.31, 0.31, QUANTUM) == 0.0


def test_motor_sings_at_the_rate_of_full_steps():
    motor = MotorNoise(0.1, np.random.default_rng(1))
    speed = 100 * FULL_STEP  # 100 steps a second
    angles = speed * np.arange(201) / 100
    heard = np.concatenate([motor.between(a, b, QUANTUM) for a, b in itertools.pairwise(angles)])
    spectrum = np.abs(np.fft.rfft(heard[-RATE:]))
    assert spectrum.argmax() == 100
    assert np.sqrt(np.mean(heard[-RATE:] ** 2)) == pytest.approx(0.1, rel=0.05)


def test_where_turns_are_not_heard_the_last_heading_sounds_on(tmp_path):
    there = stems(tmp_path, room(), noise(1), noise(2))
    path = np.concatenate([np.full(10, 0.02), 0.02 + np.linspace(0, 0.5, 30), np.full(20, 0.52)])
    heard = hear(Microphones(there, SPACING, 0.02, turns_heard=False), path)
    first, after = direct(room(), 0.02, (noise(1), noise(2)), heard.shape[-1]), 45 * QUANTUM
    assert np.allclose(heard[..., : 40 * QUANTUM], first[..., : 40 * QUANTUM], atol=1e-5 * np.abs(first).max())
    last = direct(room(), 0.52, (noise(1), noise(2)), heard.shape[-1])
    assert np.allclose(heard[..., after:], last[..., after:], atol=1e-5 * np.abs(last).max())
