import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.signal import butter, lfilter

from ross_payload.config import validated
from ross_payload.errors import AudioError, ConfigError
from ross_payload.interfaces import AudioFlag
from ross_sim.clock import SimClock
from ross_sim.scenario import Scenario
from ross_sim.sitl.world import LEVEL, World
from ross_sim.talkers.speech import TalkerVoice

RATE = 16000


class Turntable:
    """Turns at constant speed from one time to another."""

    port = None

    def __init__(self, speed=0.0, begin=0.0, end=0.0):
        self._speed, self._begin, self._end = speed, begin, end
        self._angle = 0.0

    def advance(self, now):
        self._angle = self._speed * (min(max(now, self._begin), self._end) - self._begin)

    def angle(self):
        return self._angle

    def complaints(self):
        return []


def scenario(
    *azimuths_deg, rate=RATE, noise=None, room=None, offset_deg=0.0, vehicle=None, corners=None, told=(0, 0), **changes
):
    talkers = [{"azimuth_deg": azimuth, "start_s": 0.5} | changes for azimuth in azimuths_deg]
    payload = {"audio": {"rate_hz": rate, "roll_off_hz": told}, "array": {"offset_deg": offset_deg}}
    values = {"title": "test", "talkers": talkers, "noise": noise or {}, "room": room or {}, "payload": payload}
    values |= {} if vehicle is None else {"vehicle": vehicle}
    values |= {} if corners is None else {"microphones": {"roll_off_hz": corners}}
    return validated(Scenario, values, "test")


def voices(n, rate=RATE, seconds=4):
    generator = np.random.default_rng(7)
    clips = [generator.standard_normal(seconds * rate).astype(np.float32) for _ in range(n)]
    return [TalkerVoice(f"voice-{index}", clip, clip, rate) for index, clip in enumerate(clips)]


@pytest.fixture
def make(tmp_path):
    def make_world(scene, far_end=None, seed=1, talkers=None):
        clock = SimClock()
        chosen = voices(len(scene.talkers), scene.payload.audio.rate_hz) if talkers is None else talkers
        return World(scene, chosen, far_end or Turntable(), clock, seed, cache=tmp_path)

    return make_world


def listen(world, seconds, hop=160):
    with world.source as source:
        blocks = [source.read(hop) for _ in range(math.ceil(seconds * world.rate / hop))]
    return np.concatenate([block.samples for block in blocks], axis=1), blocks


def test_images_and_noise_add_up_to_the_mixture_to_the_last_bit(make):
    world = make(scenario(40, 155, -80), Turntable(0.5, 1.0, 2.0))
    heard, _ = listen(world, 3)
    total = world.images().astype(float).sum(axis=0) + world.noise()[0]
    assert np.array_equal(total, heard[0])
    assert np.array_equal(world.mixture(), heard)


@pytest.mark.parametrize("hop", [160, 333])
def test_microphones_that_roll_off_shift_the_phase_while_the_array_rests_and_turns(make, hop):
    plain, _ = listen(make(scenario(40, 155), Turntable(0.5, 1.07, 2.03)), 3)
    world = make(scenario(40, 155, corners=(30, 90)), Turntable(0.5, 1.07, 2.03))
    heard = listen(world, 3, hop)[0][:, : plain.shape[1]]
    for corner, flat, real in zip((30, 90), plain, heard, strict=True):
        assert real == pytest.approx(lfilter(*butter(1, corner, "highpass", fs=RATE), flat), abs=1e-6)
    total = world.images().astype(float).sum(axis=0) + world.noise()[0]
    assert np.array_equal(total[: heard.shape[1]], heard[0])


@pytest.mark.parametrize(("corners", "told"), [((20, 60), (0, 40)), ((60, 20), (40, 0))])
def test_each_talker_alone_is_what_the_payload_makes_of_him(make, corners, told):
    world = make(scenario(40, corners=corners, told=told, noise={"snr_db": 80}))
    heard, _ = listen(world, 2)
    assert np.abs(world.images()[0] - heard[0]).max() < 1e-4
    plain, _ = listen(make(scenario(40, noise={"snr_db": 80})), 2)
    turned = np.rad2deg(np.angle(_between(heard) / _between(plain)))
    assert np.abs(np.median(turned)) < 0.3


def _between(both):
    """Microphone 2 over microphone 1 from 150 Hz to 1 kHz."""
    first, second = np.fft.rfft(both)[:, 300:2000]
    return second / first


def test_a_world_that_is_rendered_apart_from_its_time_sounds_the_same(make, tmp_path):
    def turntable():
        return Turntable(0.5, 1.0, 2.0)

    together, blocks = listen(make(scenario(40, 155), turntable()), 3)
    clock = SimClock()

    def wait():  # what turns is ahead of what is heard
        for _ in range(30):
            clock.advance()

    world = World(scenario(40, 155), voices(2), turntable(), clock, 1, cache=tmp_path, wait=wait)
    apart, later = listen(world, 3)
    assert np.array_equal(together, apart)
    assert [block.time for block in blocks] == [block.time for block in later]
    assert np.array_equal(world.drain().mixture[:, : apart.shape[1]], apart)


def test_samples_lie_on_the_24_bit_grid(make):
    heard, _ = listen(make(scenario(40)), 1)
    counts = heard.astype(float) * 2**23
    assert heard.dtype == np.float32
    assert np.array_equal(counts, np.rint(counts))


@pytest.mark.parametrize(
    ("rate", "vehicle"),
    [
        (RATE, None),
        (22050, None),
        (RATE, {"steady_deg_s": math.degrees(0.5)}),
    ],  # under a turntable that makes up for it
)
def test_quanta_that_are_rendered_at_once_sound_as_if_each_were_alone(make, monkeypatch, rate, vehicle):
    noise = {"motor_db": -30, "sources": [{"name": "fan", "azimuth_deg": 10, "snr_db": 5}]}

    def heard(ahead):
        monkeypatch.setattr("ross_sim.sitl.world.AHEAD", ahead)
        turntable = Turntable(0.5, 0.63, 0.98) if vehicle is None else Turntable(0.5, 0.0, 0.98)
        world = make(scenario(40, -80, rate=rate, noise=noise, vehicle=vehicle), turntable)
        return listen(world, 2)[0], world.images(), world.noise()

    for one, other in zip(heard(1), heard(25), strict=True):
        assert one.tobytes() == other.tobytes()


@pytest.mark.parametrize("hop", [1, 77, 320, 5000])
def test_bytes_do_not_depend_on_how_they_are_read(make, hop):
    reference, _ = listen(make(scenario(40, -80), Turntable(0.5, 0.2, 0.6)), 1)
    heard, _ = listen(make(scenario(40, -80), Turntable(0.5, 0.2, 0.6)), 1, hop)
    assert heard[:, :RATE].tobytes() == reference.tobytes()


def test_an_empty_cache_and_a_full_one_give_the_same_bytes(make):
    cold, _ = listen(make(scenario(40, -80), Turntable(0.5, 0.2, 0.6)), 1)
    warm, _ = listen(make(scenario(40, -80), Turntable(0.5, 0.2, 0.6)), 1)
    assert cold.tobytes() == warm.tobytes()


def test_another_seed_is_another_noise_and_nothing_else(make):
    first, second = make(scenario(40), seed=1), make(scenario(40), seed=2)
    listen(first, 1)
    listen(second, 1)
    assert np.array_equal(first.images(), second.images())
    assert not np.array_equal(first.noise(), second.noise())


def test_lead_in_holds_noise_only(make):
    world = make(scenario(40, -80))
    listen(world, 1)
    assert not world.images()[:, : RATE // 2].any()
    assert world.images()[:, RATE // 2 + 200 :].any(axis=1).all()


def power_db(samples):
    return 10 * np.log10(np.mean(samples.astype(float) ** 2))


@pytest.mark.parametrize(("reference", "below_mixture"), [("mixture", 0.0), ("talker", 10 * math.log10(3))])
def test_snr_is_as_defined(make, reference, below_mixture):
    world = make(scenario(40, 155, -80, noise={"snr_db": 12, "snr_reference": reference}))
    listen(world, 4)
    together = world.images().sum(axis=0)[RATE:]
    assert power_db(together) - power_db(world.noise()[0]) == pytest.approx(12 + below_mixture, abs=0.2)
    assert power_db(together) == pytest.approx(20 * math.log10(LEVEL), abs=0.2)


def test_talkers_are_equally_loud_at_microphone_1_whatever_the_recording_and_distance(make):
    scene = scenario(40, 155)
    near, far = (talker.model_copy(update={"distance_m": d}) for talker, d in zip(scene.talkers, (1, 4), strict=True))
    scene = scene.model_copy(update={"talkers": (near, far)})
    loud, soft = voices(2)
    soft = TalkerVoice("soft", soft.speech * np.float32(0.01), soft.enrolment, RATE)
    world = make(scene, talkers=[loud, soft])
    listen(world, 4)
    first, second = world.images()[:, RATE:]
    assert power_db(first) == pytest.approx(power_db(second), abs=0.2)


def test_sensor_noise_is_independent_at_each_microphone(make):
    world = make(scenario())
    listen(world, 4)
    assert abs(np.corrcoef(world.noise())[0, 1]) < 0.02


def arrives_earlier_at_microphone_2(samples):
    """TDOA [s] from the phase slope of the averaged cross-spectrum below 3 kHz."""
    first, second = np.fft.rfft(samples[:, : samples.shape[1] // 512 * 512].reshape(2, -1, 512) * np.hanning(512))
    frequencies = np.fft.rfftfreq(512, 1 / RATE)
    band = (frequencies > 200) & (frequencies < 3000)
    phase = np.angle(np.mean(second * first.conj(), axis=0))[band]
    return np.sum(phase * frequencies[band]) / np.sum(2 * np.pi * frequencies[band] ** 2)


def test_the_room_hears_the_true_angle_and_the_offset(make):
    world = make(scenario(70, noise={"snr_db": 60}, offset_deg=10), Turntable(math.radians(60), 1.0, 1.5))
    heard, _ = listen(world, 3)
    before = arrives_earlier_at_microphone_2(heard[:, RATE * 6 // 10 : RATE])
    after = arrives_earlier_at_microphone_2(heard[:, RATE * 17 // 10 :])
    assert before == pytest.approx(0.05 / 343 * math.cos(math.radians(60)), abs=2e-6)
    assert after == pytest.approx(0.05 / 343 * math.cos(math.radians(30)), abs=2e-6)
    assert world.headings()[[0, -1]] == pytest.approx(np.radians([10, 40]))
    assert world.headings().size == 301


def test_time_and_index_are_those_of_the_first_sample(make):
    world = make(scenario(40))
    world.clock.sleep(0.25)
    with world.source as source:
        blocks = [source.read(160) for _ in range(5)]
    assert [block.index for block in blocks] == [0, 160, 320, 480, 640]
    assert [block.time for block in blocks] == pytest.approx([0.25, 0.26, 0.27, 0.28, 0.29])


def test_what_is_heard_while_somebody_sleeps_is_not_lost(make):
    reference, _ = listen(make(scenario(40)), 1)
    world = make(scenario(40))
    with world.source as source:
        first = source.read(RATE // 2)
        world.clock.sleep(0.3)
        rest = source.read(RATE // 2)
    assert np.array_equal(np.concatenate([first.samples, rest.samples], axis=1), reference)
    assert rest.lost == 0


def test_a_rate_that_does_not_fit_the_quantum_loses_nothing(make):
    world = make(scenario(40, rate=22050))
    heard, _ = listen(world, 1, hop=441)
    assert heard.shape[1] == 22050
    assert world.clock.now() == pytest.approx(1.0)


def test_clipping_is_flagged_and_held_at_full_scale(make):
    crackle = np.zeros(4 * RATE, dtype=np.float32)
    crackle[1000::8000] = 1.0
    world = make(scenario(0), talkers=[TalkerVoice("crackle", crackle, crackle, RATE)])
    heard, blocks = listen(world, 1)
    flagged = [bool(block.flags & AudioFlag.CLIPPED) for block in blocks]
    assert np.abs(heard).max() <= 1.0
    assert any(flagged)
    assert not flagged[0]


def test_motor_is_heard_only_while_turning_and_leaves_the_sensor_noise_alone(make):
    still, turning = make(scenario()), make(scenario(), Turntable(1.0, 0.5, 1.0))
    listen(still, 2)
    listen(turning, 2)
    motor = turning.noise() - still.noise()
    moving = slice(RATE // 2, RATE + 160)
    assert np.array_equal(np.delete(motor, np.r_[moving], axis=1), np.zeros((2, 2 * RATE - RATE // 2 - 160)))
    assert power_db(motor[0, moving]) == pytest.approx(20 * math.log10(LEVEL) - 20, abs=0.5)
    assert np.abs(motor[0] - motor[1]).max() <= 2 * 2**-23  # rounded with the sensor noise


def test_nobody_there_is_noise_as_loud_as_with_a_mixture(make):
    world = make(scenario(noise={"snr_db": 20}))
    heard, _ = listen(world, 2)
    assert world.images().shape == (0, 2 * RATE)
    assert power_db(heard[0]) == pytest.approx(20 * math.log10(LEVEL) - 20, abs=0.2)


def test_three_dimensions_with_a_little_reverberation(make):
    scene = scenario(40, -80, room={"size_m": [5, 4, 2.5], "t60_s": 0.2}, distance_m=1.5, height_m=1.6)
    world = make(scene, Turntable(0.2, 0.7, 0.8))
    listen(world, 2)
    images = world.images()
    assert power_db(images[0, RATE:]) == pytest.approx(power_db(images[1, RATE:]), abs=0.5)


def test_reading_needs_an_open_source(make):
    world = make(scenario(40))
    with pytest.raises(AudioError, match="not open"):
        world.source.read(160)
    listen(world, 0.1)
    with pytest.raises(AudioError, match="not open"):
        world.source.read(160)
    with pytest.raises(AudioError, match="only once"):
        world.source.__enter__()


def test_voices_must_fit_the_scenario(make):
    with pytest.raises(ConfigError, match="expected one voice for each of 2 talkers, got 1"):
        make(scenario(40, -80), talkers=voices(1))
    with pytest.raises(ConfigError, match="voice 'voice-0': expected 16000 Hz, as the payload has, got 8000 Hz"):
        make(scenario(40), talkers=voices(1, rate=8000))


def test_what_was_taken_in_pieces_is_what_was_heard_and_leaves_nothing_behind(make):
    world = make(scenario(40, -80), Turntable(0.5, 0.3, 0.8))
    with world.source as source:
        pieces = []
        for _ in range(4):
            source.read(4000)
            pieces.append(world.drain())
    heard, _ = listen(make(scenario(40, -80), Turntable(0.5, 0.3, 0.8)), 1)
    assert np.array_equal(np.concatenate([piece.mixture for piece in pieces], axis=1), heard)
    assert [piece.images.shape for piece in pieces] == [(2, 2, 4000)] * 4
    assert all(before.headings[-1] == after.headings[0] for before, after in pairwise(pieces))
    assert world.images().shape == (2, 0)
