"""Every exploration looks whether the array is as it is configured, and says so where it is not."""

from dataclasses import replace

import numpy as np
import pytest

from mission_bench import SETTINGS, rig
from ross_payload.calibration.common_delay import common_delay
from ross_payload.calibration.consistency import Contradiction, contradiction, explained_by
from ross_payload.calibration.cross_spectrum import heading_spectrum
from ross_payload.calibration.turn_fit import Steered, Turn
from ross_payload.config import Config, validated
from ross_payload.events import ArrayContradicted, OrientationHeard, State, StateChanged
from ross_payload.interfaces import Attitude, AudioBlock, Input
from ross_payload.mission import explore
from ross_payload.mission.context import Context, Listening
from ross_payload.mission.heard_turning import HeardTurning
from ross_payload.pointing import Pointing
from ross_payload.service.assemble import settings_of
from ross_payload.telemetry.status_texts import line
from ross_protocols.mavlink.values import Severity
from turned_array import RATE, SPEED, around, heard_at, spectra

THREE = (0.7, 2.6, -1.4)
TURN = around(9, 120.0)


@pytest.mark.parametrize("azimuths", [(0.7,), (0.7, 2.6), THREE])
def test_an_array_that_is_as_configured_is_not_doubted(azimuths):
    assert not contradiction(spectra(TURN, azimuths=azimuths), 0.05, SPEED)


@pytest.mark.parametrize(("azimuths", "true"), [((0.7,), 0.064), (THREE, 0.1), ((0.7,), 0.03), (THREE, 0.03)])
def test_another_spacing_is_noticed(azimuths, true):
    found = contradiction(spectra(TURN, azimuths=azimuths, spacing=true), 0.05, SPEED)
    assert found.spacing == pytest.approx(true, rel=0.12)
    assert (found.gain_db, found.inverted) == (None, False)


def test_below_a_vehicle_a_spacing_that_seems_too_small_may_be_an_elevation():
    heard = spectra(TURN, spacing=0.03)
    assert contradiction(heard, 0.05, SPEED, level=True).spacing is not None
    assert not contradiction(heard, 0.05, SPEED, level=False)
    assert not settings_of(validated(Config, {"mount": {"source": "autopilot"}}, ""), -3, 3).level


def test_a_gain_difference_is_noticed_and_a_small_one_is_not():
    assert contradiction(spectra(TURN, azimuths=THREE, gain_db=-2.5), 0.05, SPEED).gain_db == pytest.approx(
        -2.5, abs=0.2
    )
    assert not contradiction(spectra(TURN, azimuths=THREE, gain_db=0.8), 0.05, SPEED)


def test_reversed_polarity_is_noticed_and_nothing_else_is_said_then():
    found = contradiction(spectra(TURN, azimuths=THREE, inverted=True, gain_db=3.0), 0.05, SPEED)
    assert found == Contradiction(inverted=True)


def test_a_few_headings_tell_nothing():
    assert not contradiction(spectra(TURN[:4], spacing=0.1), 0.05, SPEED)


def explored(**like):
    """A context that has explored, and what it has to say."""
    context = Context(replace(SETTINGS, rate=RATE), tools=None)
    pairs = zip(TURN, heard_at(TURN, **like), strict=True)
    context.explored = [Listening(float(heading), samples) for heading, samples in pairs]
    explore.check_array(context)
    return [event for event in context.pending if isinstance(event, ArrayContradicted)]


def test_an_exploration_says_what_contradicts_the_configuration():
    (event,) = explored(spacing=0.064, gain_db=2.0)
    assert event.spacing == pytest.approx(0.064, abs=0.003)
    severity, text = line(event)
    assert severity is Severity.WARNING
    assert (
        text
        == f"array: spacing seems {1e3 * event.spacing:.0f} mm, not 50, microphone 2 is 2.0 dB louder: ross calibrate"
    )


def test_an_exploration_says_nothing_when_all_agrees_or_nobody_talks():
    assert explored() == []
    assert explored(silent=range(9)) == []


def turned(*, spacing=0.05, gain_db=0.0, inverted=False, rate_deg_s=20.0, seconds=6.0):
    """A context that has explored without a pause, and what it has to say: a source at 0.7 rad in the open."""
    rng, n, finer = np.random.default_rng(0), round(seconds * RATE), 8
    source = np.fft.irfft(np.fft.rfft(rng.standard_normal(n)), n * finer) * finer
    times = np.arange(n) / RATE
    delay = spacing / SPEED * np.cos(0.7 - np.deg2rad(rate_deg_s) * times)
    lags = np.array([[-0.5], [0.5]]) * delay
    samples = np.interp(times + lags, np.arange(n * finer) / (finer * RATE), source)
    samples += 0.1 * rng.standard_normal((2, n))
    samples[1] *= 10 ** (gain_db / 20) * (-1 if inverted else 1)
    context, kept = Context(replace(SETTINGS, rate=RATE), tools=None), HeardTurning(RATE)
    kept.begin()
    for hop in range(round(seconds * 100)):
        ends = np.deg2rad(rate_deg_s) * np.array([hop, hop + 1]) / 100
        block = AudioBlock(samples[:, hop * RATE // 100 : (hop + 1) * RATE // 100], hop * RATE // 100, hop / 100)
        kept.add(Input(block, float(ends[0]), Pointing(joint=float(ends[1])), False, Attitude(0.0)))
    context.explored = kept.pieces(np.deg2rad(15.0))
    explore.check_array(context)
    return [event for event in context.pending if isinstance(event, ArrayContradicted)]


@pytest.mark.soak
def test_an_exploration_without_a_pause_says_so_too():
    assert turned() == []
    assert turned(gain_db=-2.5)[0].gain_db == pytest.approx(-2.5, abs=0.2)
    assert turned(inverted=True)[0].inverted
    assert turned(spacing=0.1)[0].spacing == pytest.approx(0.1, rel=0.12)


@pytest.mark.parametrize("azimuths", [(0.7, 2.6), THREE])
def test_a_delay_between_the_channels_is_noticed(azimuths):
    heard = spectra(TURN, azimuths=azimuths, delay=-1 / RATE)
    found = contradiction(heard, 0.05, SPEED)
    assert found.delay == pytest.approx(-1 / RATE, abs=2.6e-5)
    assert (found.spacing, found.gain_db, found.inverted, found.fixed) == (None, None, False, False)
    assert contradiction(heard, 0.05, SPEED, level=False) == Contradiction()
    (text,) = [line(ArrayContradicted(1.0, None, 0.05, None, inverted=False, delay=found.delay))[1]]
    assert "microphone 2 seems about" in text


def test_what_turns_with_the_array_is_interference_and_no_wrong_spacing():
    """As of a radio beside the cable: the same on both channels, whatever the heading."""
    rng = np.random.default_rng(8)
    hiss, both = 1e-3 * rng.standard_normal((9, 2, 2 * RATE)), 0.05 * rng.standard_normal((9, 1, 2 * RATE))
    both[..., np.arange(2 * RATE) % 4000 > 400] = 0  # in bursts
    pairs = zip(TURN, (hiss + both).astype(np.float32), strict=True)
    heard = [heading_spectrum(samples, RATE, float(heading)) for heading, samples in pairs]
    found = contradiction(heard, 0.05, SPEED)
    assert found == Contradiction(fixed=True)
    assert "turns with it" in line(ArrayContradicted(1.0, None, 0.05, None, inverted=False, fixed=True))[1]


def test_noise_from_all_sides_is_no_smaller_spacing():
    """As of ventilation in a room where nobody talks: most of it is so long that both microphones hear the same."""
    rng, n, around_us = np.random.default_rng(0), 2 * RATE, 200
    towards = rng.standard_normal((around_us, 3))
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    frequencies, heard = np.fft.rfftfreq(n, 1 / RATE), []
    for heading in TURN:
        waves = np.fft.rfft(rng.standard_normal((around_us, n))) / (1 + frequencies / 300) ** 2
        along = towards[:, 0] * np.cos(heading) + towards[:, 1] * np.sin(heading)
        late = np.exp(2j * np.pi * frequencies * 0.05 / SPEED * along[:, None])
        both = np.fft.irfft([waves.sum(axis=0), (waves * late).sum(axis=0)])
        both = 0.01 * both / both.std() + 5e-4 * rng.standard_normal((2, n))
        heard.append(heading_spectrum(both.astype(np.float32), RATE, float(heading)))
    assert contradiction(heard, 0.05, SPEED) == Contradiction()


def test_polarity_is_told_in_words():
    assert "polarity of one microphone is reversed" in line(ArrayContradicted(1.0, None, 0.05, None, inverted=True))[1]


def test_no_step_of_the_check_takes_long(monkeypatch):
    """What it computes at once is a small array: 65,536 numbers at most, whatever was heard."""
    largest = []
    irfft = np.fft.irfft
    monkeypatch.setattr(np.fft, "irfft", lambda a, n=None, **k: largest.append(n) or irfft(a, n, **k))
    contradiction(spectra(TURN), 0.05, SPEED)
    assert max(n for n in largest if n) <= 2**16 + 2**14


def test_every_exploration_of_a_mission_looks_at_the_array(monkeypatch):
    looked = []

    def found(heard, spacing, speed_of_sound, *, level):
        looked.append((spacing, speed_of_sound, level))
        return Contradiction(gain_db=2.0)

    monkeypatch.setattr(explore, "contradiction", found)
    one = rig()
    one.run()
    assert looked == [(0.05, 343.0, True)]
    (event,) = one.said(ArrayContradicted)
    assert (event.gain_db, event.spacing, event.inverted) == (2.0, None, False)
    last = max(e.time for e in one.said(OrientationHeard))
    assert last <= event.time < min(e.time for e in one.said(StateChanged) if e.state is State.ALIGN_TURN) + 0.1


def test_pooled_frequencies_explain_as_much_as_all():
    generator, frequencies = np.random.default_rng(4), 300 + 4.0 * np.arange(1500)
    headings = np.radians(np.arange(7) * 25.0)
    delays = 1.4e-4 * np.cos(np.radians(50.0) - headings)
    phase = np.exp(2j * np.pi * np.outer(delays, frequencies) + 0.7j * generator.standard_normal((7, 1500)))
    turn = Turn(headings, frequencies, phase, generator.uniform(0.1, 1.0, (7, 1500)), np.zeros((7, 1500)))
    amplitudes = 1.4e-4 * np.arange(0.5, 2.5, 0.25)
    few = turn.pooled(8)
    assert few.frequencies.size == 187
    every, some = (explained_by(each, Steered(each, each.phase), amplitudes) for each in (turn, few))
    assert some == pytest.approx(every, abs=3e-3)
    (_, left, _), (_, same, _) = (common_delay(each, Steered(each, each.phase), 1.4e-4) for each in (turn, few))
    assert same == pytest.approx(left, abs=5e-3)
