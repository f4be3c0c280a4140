"""What the health monitor says of microphones that are well, and of each way in which they are not."""

from dataclasses import replace

import numpy as np
import pytest
import soundfile

from examples import in_soak
from ross_payload.audio.audio_health import HealthMonitor
from ross_payload.audio.live_source import SourceStatus
from ross_payload.config import Config, validated
from ross_payload.health import AudioTrouble
from ross_payload.interfaces import AudioBlock, AudioFlag

RATE, HOP = 16000, 160
SPACING, SPEED = 0.05, 343.0


def talker(generator, seconds, azimuth, level=0.03):
    """Speech-like sound from one direction: coloured, in bursts, delayed at microphone 2 by its TDOA."""
    n = round(seconds * RATE)
    frequencies = np.fft.rfftfreq(n, 1 / RATE)
    colour = 1 / (1 + (frequencies / 500) ** 2) * (frequencies > 80)
    spectrum = np.fft.rfft(generator.standard_normal(n)) * colour
    tau = SPACING / SPEED * np.cos(azimuth)
    pair = np.fft.irfft([spectrum, spectrum * np.exp(2j * np.pi * frequencies * tau)], n)
    bursts = np.repeat(generator.random(n // 4000 + 1) > 0.4, 4000)[:n]
    return pair / pair.std() * level * bursts


def scene(seconds=6.0, azimuths=(0.3, 1.6, -2.0), noise=0.001, seed=3):
    generator = np.random.default_rng(seed)
    heard = noise * generator.standard_normal((2, round(seconds * RATE)))
    return heard + sum(talker(generator, seconds, azimuth) for azimuth in azimuths)


def blocks(samples, flags=AudioFlag.NONE):
    for begin in range(0, samples.shape[1] - HOP + 1, HOP):
        part = np.clip(samples[:, begin : begin + HOP], -1, 1 - 2**-23).astype(np.float32)
        clipped = AudioFlag.CLIPPED if np.abs(part).max() >= 1 - 2**-15 else AudioFlag.NONE
        yield AudioBlock(part, begin, begin / RATE, flags=flags | clipped)


def verdict(samples, monitor=None):
    monitor = monitor or HealthMonitor(Config())
    for block in blocks(samples):
        monitor.listen(block)
    return monitor.health()


@pytest.mark.parametrize("azimuths", [(), (0.3, 1.6, -2.0), *in_soak((0.3,), (np.pi / 2,))])
def test_ordinary_sound_and_ordinary_silence_are_no_trouble(azimuths):
    monitor = HealthMonitor(Config())
    for block in blocks(scene(6.0, azimuths)):
        monitor.listen(block)
        assert not monitor.health().trouble


def test_levels_and_peaks_are_re_full_scale():
    time = np.arange(2 * RATE) / RATE
    health = verdict(np.stack([0.5 * np.sin(2 * np.pi * 440 * time), 0.05 * np.sin(2 * np.pi * 440 * time)]))
    assert health.level_db == pytest.approx((-9.03, -29.03), abs=0.02)
    assert health.peak_db == pytest.approx((-6.02, -26.02), abs=0.02)


def test_clipping_is_told_for_a_second():
    samples = scene(4.0)
    samples[1, RATE // 2] = 1.0
    monitor = HealthMonitor(Config())
    assert verdict(samples[:, :RATE], monitor).trouble == AudioTrouble.CLIPPING
    assert not verdict(samples[:, RATE : 3 * RATE], monitor).trouble


@pytest.mark.parametrize(("row", "dead"), [(0, AudioTrouble.DEAD_1), (1, AudioTrouble.DEAD_2)])
@pytest.mark.parametrize("factor", [0.01, *in_soak(0.0)])
def test_a_microphone_that_is_silent_or_far_below_the_other_is_dead(row, dead, factor):
    samples = scene()
    samples[row] *= factor
    assert verdict(samples).trouble & (AudioTrouble.DEAD_1 | AudioTrouble.DEAD_2) == dead


def test_digital_silence_at_both_is_two_dead_microphones():
    assert verdict(np.zeros((2, 3 * RATE))).trouble == AudioTrouble.DEAD_1 | AudioTrouble.DEAD_2


def test_a_knock_on_one_microphone_does_not_kill_the_other():
    samples = scene(azimuths=())
    samples[0, 3 * RATE : 3 * RATE + 400] += 0.9
    monitor = HealthMonitor(Config())
    for block in blocks(samples):
        monitor.listen(block)
        assert not monitor.health().trouble & (AudioTrouble.DEAD_1 | AudioTrouble.DEAD_2)


def test_hum_at_one_microphone_does_not_kill_the_other():
    samples = scene(azimuths=())
    samples[1] += 0.2 * np.sin(2 * np.pi * 50 * np.arange(samples.shape[1]) / RATE)
    monitor = HealthMonitor(Config())
    for block in blocks(samples):
        monitor.listen(block)
        assert not monitor.health().trouble & (AudioTrouble.DEAD_1 | AudioTrouble.DEAD_2)


@pytest.mark.parametrize("offset", [0.02, -0.02])
def test_a_constant_part_is_told(offset):
    samples = scene()
    samples[1] += offset
    assert verdict(samples).trouble == AudioTrouble.OFFSET


def test_rumble_is_no_constant_part():
    rumble = 0.1 * np.sin(2 * np.pi * 1.3 * np.arange(8 * RATE) / RATE)
    assert not verdict(scene(8.0) + rumble).trouble


def test_one_microphone_on_both_channels_is_told_at_any_gain():
    samples = scene()
    samples[1] = 0.5 * samples[0]
    assert verdict(samples).trouble == AudioTrouble.IDENTICAL


@pytest.mark.parametrize("row", [0, *in_soak(1)])
def test_a_wrong_polarity_is_told_and_stays_told_through_silence_until_it_is_right(row):
    samples, right = scene(), scene(6.0, seed=4)
    samples[row] *= -1
    monitor = HealthMonitor(Config())
    assert verdict(samples, monitor).trouble == AudioTrouble.INVERTED
    assert verdict(scene(4.0, azimuths=()), monitor).trouble == AudioTrouble.INVERTED
    assert not verdict(right, monitor).trouble


def test_microphones_too_far_apart_for_polarity_raise_no_alarm():
    samples = scene()
    samples[1] *= -1
    config = validated(Config, {"array": {"spacing_m": 0.9}}, "test")
    assert not verdict(samples, HealthMonitor(config)).trouble


def test_missing_samples_are_told_for_ten_seconds_and_a_source_that_is_gone_is_absent():
    monitor = HealthMonitor(Config())
    assert not verdict(scene(1.0), monitor).trouble
    for block in blocks(np.zeros((2, RATE)), AudioFlag.MISSING):
        monitor.listen(replace(block, time=block.time + 1.0))
    assert monitor.health().trouble == AudioTrouble.LOST | AudioTrouble.ABSENT
    for block in blocks(scene(12.0)):
        monitor.listen(replace(block, time=block.time + 2.0))
        assert block.time + 2.0 > 11.9 or monitor.health().trouble & ~AudioTrouble.ABSENT == AudioTrouble.LOST
    assert not monitor.health().trouble


def test_samples_that_are_no_numbers_are_lost():
    monitor = HealthMonitor(Config())
    sound = list(blocks(scene(4.0)))
    for block in sound[:200]:
        monitor.listen(block)
    assert not monitor.health().trouble
    for block in sound[200:]:
        monitor.listen(replace(block, flags=AudioFlag.INVALID))
    assert monitor.health().trouble == AudioTrouble.LOST


def test_what_the_source_tells_is_passed_on():
    class Source:
        def status(self):
            return SourceStatus(lost=160, reopened=2, waiting=1.5, rate=16001.0, trouble="pulled out")

    health = HealthMonitor(Config(), Source()).health()
    assert (health.lost, health.reopened, health.waiting, health.rate) == (160, 2, 1.5, 16001.0)
    assert health.trouble == AudioTrouble.ABSENT


def test_recorded_voices_raise_no_alarm(speech):
    """One recorded talker from the side of the array, with the noise of two microphones."""
    path = next(iter(sorted([*speech.rglob("*.flac"), *speech.rglob("*.wav")])))
    voice, rate = soundfile.read(path, frames=20 * 16000, dtype="float64", always_2d=True)
    pair = np.stack([voice[1:, 0], voice[:-1, 0]]) + 1e-4 * np.random.default_rng(1).standard_normal(
        (2, len(voice) - 1)
    )
    config = validated(Config, {"audio": {"rate_hz": rate}}, "test")
    assert not verdict(pair, HealthMonitor(config)).trouble & ~AudioTrouble.CLIPPING
    pair[0] *= -1
    assert verdict(pair, HealthMonitor(config)).trouble & AudioTrouble.INVERTED
