"""A card that drifts, stalls, loses samples, is pulled out and comes back: counting samples is counting time."""

import numpy as np
import pytest

from examples import in_soak
from ross_payload.audio.channel_map import ChannelMap
from ross_payload.audio.live_source import LiveSource
from ross_payload.audio.sound_card import SoundCard
from ross_payload.config import Audio
from ross_payload.errors import AudioError
from ross_payload.interfaces import AudioFlag

RATE, HOP = 16000, 160
NEAR = 0.003  # [s] within which a sample's time is right


class Done:
    def join(self, timeout):
        pass


def at_once(call):
    call()
    return Done()


@pytest.fixture
def listen(moments):
    def make(card, *, buffer=10.0, name="card", settling=0.0, **keys):
        audio = Audio(**keys)
        wiring = ChannelMap.of(audio)
        opener = SoundCard(name, audio, wiring, card)
        return LiveSource(opener, audio.rate_hz, wiring, buffer, moments, settling=settling, start=at_once)

    return make


@pytest.fixture
def errors(captured_at):
    def of(blocks, card):
        """What the stamped time of every sample that came is off by [s], one per block."""
        off = []
        for block in blocks:
            count = block.samples[0]
            came = np.flatnonzero(count)
            if len(came):
                stamped = block.time + came / RATE
                off.append(float(np.mean(stamped - captured_at(count[came], block.time, card.true_rate))))
        return np.array(off)

    return of


def read(source, seconds):
    return [source.read(HOP) for _ in range(round(seconds * RATE / HOP))]


def missing(blocks):
    return sum(int(np.sum(block.samples[1] == 0)) for block in blocks)


def test_every_sample_arrives_once_and_in_order(listen, make_card):
    with listen(make_card(jitter=0.008)) as source:
        blocks = read(source, 5)
    counts = np.concatenate([block.samples[0] for block in blocks]).astype(float) * 2**23
    assert np.all(np.diff(counts) == 1)
    assert [block.index for block in blocks] == list(range(0, 5 * RATE, HOP))


@pytest.mark.parametrize("settling", [0.0, 0.3])
def test_the_first_sample_is_the_first_that_the_card_gave_after_it_settled(listen, make_card, moments, settling):
    card, begin = make_card(), moments.now()
    with listen(card, settling=settling) as source:
        block = source.read(HOP)
    assert block.index == 0
    assert block.time == pytest.approx(begin + settling, abs=NEAR)
    assert block.samples[0, 0] * 2**23 == pytest.approx((begin + settling) * RATE, abs=1)


@pytest.mark.parametrize("ppm", [-150, *in_soak(100, 0)])
def test_the_time_of_a_sample_follows_the_card_through_drift_and_jitter(listen, make_card, errors, ppm):
    card = make_card(ppm=ppm, jitter=0.012)
    with listen(card) as source:
        blocks = read(source, 43)  # until the rate is told
        measured = source.status().rate
    assert np.abs(errors(blocks, card)).max() < NEAR
    assert measured / RATE - 1 == pytest.approx(ppm * 1e-6, abs=20e-6)
    assert source.status().lost == 0


def test_time_never_jumps(listen, make_card):
    card = make_card(ppm=80, jitter=0.02)
    with listen(card) as source:
        times = np.array([block.time for block in read(source, 20)])
    assert np.diff(times) == pytest.approx(HOP / RATE, rel=0.011)


def test_a_stall_of_which_the_driver_keeps_everything_loses_nothing(listen, make_card, moments, errors):
    card = make_card()
    with listen(card) as source:
        begin = moments.now() + 3
        card.blocked = (begin, begin + 0.4, True)
        blocks = read(source, 8)
    assert source.status().lost == 0
    assert np.abs(errors(blocks, card)).max() < NEAR


@pytest.mark.parametrize("speed", [1.02, 3.0, *in_soak(1.1)])
def test_time_does_not_run_ahead_of_a_feed_that_is_too_fast(listen, make_card, moments, caplog, speed):
    """As of a file that a server sends without a pause, or of 48 kHz that are called 16."""
    card = make_card(ppm=(speed - 1) * 1e6)
    began = moments.now()
    with listen(card) as source:
        blocks = read(source, 60)
        assert abs(blocks[-1].time - moments.now()) < 0.55
        status, elapsed = source.status(), moments.now() - began
    assert 57.5 < elapsed < 60, "a second of the beginning, half a second ahead, and 1 % as fast as time may be"
    assert status.lost == pytest.approx((speed * elapsed - 60) * RATE, abs=0.1 * RATE)
    assert any(block.flags & AudioFlag.MISSING for block in blocks), "it is told where parts are left out"
    assert status.rate is None, "the rate that time follows is not that of the samples"
    assert sum("faster than audio.rate_hz = 16000" in record.message for record in caplog.records) == 1


class FasterLater:
    """Loses 1.9 s of sound after 3 s, and is a tenth too fast from 60 s on."""

    alive = True

    def __init__(self, on_samples, clock):
        begin, frames = clock.now(), np.full((HOP, 2), 0.25, np.float32)

        def call():
            age = clock.now() - begin
            if not 3 < age < 4.9:
                on_samples(frames)
            clock.at(clock.now() + (0.01 if age < 60 else 0.01 / 1.1), call)

        clock.at(begin + 0.01, call)

    def close(self):
        pass


def test_what_comes_too_fast_long_after_a_gap_is_told(moments, caplog):
    """The zeros of a gap stand for what may still come, but not for the sound of a minute later."""
    source = LiveSource(
        lambda on_samples: FasterLater(on_samples, moments), RATE, ChannelMap.of(Audio()), 10.0, moments
    )
    with source:
        read(source, 59)
        assert source.status().lost / RATE == pytest.approx(1.9, abs=0.03)
        blocks = read(source, 31)
    assert source.status().lost / RATE == pytest.approx(1.9 + 3.0 - 0.5, abs=0.1), "0.5 s ahead"
    assert any(block.flags & AudioFlag.MISSING for block in blocks)
    assert sum("faster than audio.rate_hz = 16000" in record.message for record in caplog.records) == 1


def test_what_a_card_has_kept_while_nobody_looked_for_long_is_not_too_fast(listen, make_card, moments, caplog):
    card = make_card()
    with listen(card, buffer=60.0) as source:
        begin = moments.now() + 3
        card.blocked = (begin, begin + 37, True)
        read(source, 3.8)
        moments.sleep(40)
        read(source, 60)
    assert source.status().lost / RATE == pytest.approx(0.3, abs=0.1), "zeros until nobody looked"
    assert "faster than" not in caplog.text


class Flood:
    """Gives a second of sound, then a minute of it every tenth of a second: more than there is room for."""

    alive = True

    def __init__(self, on_samples, clock):
        def pour():
            for _ in range(600):
                on_samples(np.full((10 * HOP, 2), 0.25, np.float32))
            clock.at(clock.now() + 0.1, pour)

        for step in range(1, 101):
            clock.at(clock.now() + step / 100, lambda: on_samples(np.full((HOP, 2), 0.25, np.float32)))
        clock.at(clock.now() + 1.01, pour)

    def close(self):
        pass


def test_what_has_no_room_because_it_comes_too_fast_does_not_move_time(moments):
    source = LiveSource(lambda on_samples: Flood(on_samples, moments), RATE, ChannelMap.of(Audio()), 10.0, moments)
    with source:
        begin = moments.now()
        blocks = read(source, 10)
        assert moments.now() - begin == pytest.approx(10, abs=1.2)
        assert blocks[-1].time - moments.now() < 0.55
        assert source.status().lost > 0


def test_a_gap_does_not_spoil_the_measured_rate(listen, make_card, moments):
    card = make_card(ppm=100)
    with listen(card) as source:
        read(source, 41)
        begin = moments.now() + 1
        card.blocked = (begin, begin + 1.5, False)
        read(source, 5)
        assert source.status().rate / RATE - 1 == pytest.approx(100e-6, abs=20e-6)
        read(source, 40)  # until the rate since the gap is told
        assert source.status().rate / RATE - 1 == pytest.approx(100e-6, abs=20e-6)


@pytest.mark.parametrize("length", [0.4, *in_soak(0.08, 1.5)])
def test_a_gap_that_no_driver_tells_of_becomes_zeros_of_its_length(listen, make_card, moments, errors, length):
    card = make_card(jitter=0.004)
    with listen(card) as source:
        begin = moments.now() + 3
        card.blocked = (begin, begin + length, False)
        blocks = read(source, 8)
    assert missing(blocks) / RATE == pytest.approx(length - 0.01, abs=0.02)
    assert source.status().lost == missing(blocks)
    assert np.abs(errors(blocks, card)).max() < 2 * NEAR
    assert all(bool(block.flags & AudioFlag.MISSING) == bool(np.any(block.samples[1] == 0)) for block in blocks)


def out_of_place(blocks):
    """How many of the samples that came are not where counting from the first puts them."""
    samples = np.concatenate([block.samples for block in blocks], axis=1)
    counts = np.rint(samples[0] * 2.0**23) - np.arange(samples.shape[1])
    return int(np.sum((counts != counts[0]) & (samples[1] != 0)))


@pytest.mark.parametrize(
    "stall", [(0.45, 2.0), (0.9, np.inf), *in_soak((0.45, np.inf), (0.45, 5.0), (0.9, 5.0), (0.9, 2.0))]
)
def test_a_stall_that_catches_up_costs_only_what_was_already_given_as_zeros(listen, make_card, moments, errors, stall):
    card = make_card(jitter=0.004)
    length, card.speed = stall
    with listen(card) as source:
        begin = moments.now() + 3
        card.blocked = (begin, begin + length, True)
        blocks = read(source, 8)
    assert missing(blocks) / RATE == pytest.approx(max(length - 0.5, 0.0), abs=0.05)
    assert source.status().lost == missing(blocks)
    assert out_of_place(blocks) == 0
    assert np.abs(errors(blocks, card)).max() < 2 * NEAR


@pytest.mark.parametrize("stall", [(2.0, 2.0), *in_soak((1.0, 1.5), (1.5, 2.0), (0.6, 1.5))])
def test_zeros_for_what_comes_after_all_however_slowly_are_taken_back(listen, make_card, moments, errors, stall):
    """As from microphones behind a busy network: what waited there comes only a little faster than it is heard."""
    card = make_card(jitter=0.004)
    length, card.speed = stall
    with listen(card) as source:
        begin = moments.now() + 3
        card.blocked = (begin, begin + length, True)
        blocks = read(source, 14)
        assert blocks[-1].time + HOP / RATE < moments.now(), "nothing is heard before its time"
    assert np.abs(errors(blocks[-300:], card)).max() < 0.02  # of 0.04 s that are left, the loop has pulled in half
    assert source.status().lost == missing(blocks)


@pytest.mark.parametrize("speed", [np.inf, 5.0])
@pytest.mark.parametrize("length", [0.6, *in_soak(0.3, 1.0, 2.5)])
def test_a_pause_of_the_whole_computer_costs_nothing_that_comes_afterwards(listen, make_card, moments, length, speed):
    card = make_card(jitter=0.004)
    card.speed = speed
    with listen(card) as source:
        begin = moments.now() + 3
        card.blocked = (begin, begin + length + 0.2, True)  # whoever listens runs again before what it hears
        moments.at(begin, lambda: moments.pause(length))
        blocks = read(source, 10)
    assert (source.status().lost, source.status().reopened, out_of_place(blocks)) == (0, 0, 0)


def test_what_never_came_in_a_pause_of_the_whole_computer_is_still_missing(listen, make_card, moments, errors):
    card = make_card(jitter=0.004)
    with listen(card) as source:
        begin = moments.now() + 3
        card.blocked = (begin, begin + 0.8, False)
        moments.at(begin, lambda: moments.pause(0.6))
        blocks = read(source, 8)
    assert source.status().lost == missing(blocks) == pytest.approx(0.8 * RATE, abs=0.03 * RATE)
    assert np.abs(errors(blocks, card)).max() < 2 * NEAR


def test_a_reader_that_computes_for_less_than_the_buffer_misses_nothing(listen, make_card, moments, errors):
    card = make_card()
    with listen(card, buffer=10.0) as source:
        blocks = read(source, 1)
        moments.sleep(9.0)
        assert source.status().waiting == pytest.approx(9.0, abs=0.1)
        blocks += read(source, 15)
    assert missing(blocks) == 0
    assert np.abs(errors(blocks, card)).max() < NEAR


def test_a_reader_that_computes_for_longer_finds_zeros_where_samples_had_no_room(listen, make_card, moments, errors):
    card = make_card()
    with listen(card, buffer=2.0) as source:
        blocks = read(source, 1)
        moments.sleep(5.0)
        blocks += read(source, 10)
    assert missing(blocks) / RATE == pytest.approx(3.0, abs=0.05)
    assert source.status().lost == missing(blocks)
    assert np.abs(errors(blocks, card)).max() < NEAR


def test_a_card_that_is_pulled_out_and_comes_back_is_opened_again_in_step_with_time(listen, make_card, moments, errors):
    card = make_card()
    with listen(card) as source:
        moments.at(moments.now() + 2, card.unplug)
        moments.at(moments.now() + 9, lambda: card.plug("Other", "Card: USB Audio (hw:2,0)"))
        begin = moments.now()
        blocks = read(source, 5)
        assert moments.now() - begin == pytest.approx(5.0, abs=0.7)  # the mission's clock goes on
        assert "no microphones named 'card'; there are: none at all" in source.status().trouble
        blocks += read(source, 15)
        assert source.status().trouble == ""
    assert source.status().reopened == 1
    assert np.abs(errors(blocks[-300:], card)).max() < 2 * NEAR
    assert 7.0 < missing(blocks) / RATE < 12.0


def test_a_card_comes_back_also_where_the_system_had_no_thread_left_to_open_it(make_card, moments, caplog):
    """It ended the mission."""
    card, asked = make_card(), []

    def start(call):
        asked.append(moments.now())
        if len(asked) < 4:
            raise RuntimeError("can't start new thread")
        return at_once(call)

    audio = Audio()
    opener = SoundCard("card", audio, ChannelMap.of(audio), card)
    with LiveSource(opener, audio.rate_hz, ChannelMap.of(audio), 10.0, moments, start=start) as source:
        moments.at(moments.now() + 1, card.unplug)
        moments.at(moments.now() + 2, lambda: card.plug("Card"))
        read(source, 20)
        assert (source.status().reopened, source.status().trouble) == (1, "")
    assert len(asked) == 4
    assert "the microphones cannot be opened again: can't start new thread" in caplog.messages


def test_each_change_is_logged_once(listen, make_card, moments, caplog):
    card = make_card()
    with caplog.at_level("INFO"), listen(card) as source:
        moments.at(moments.now() + 1, card.unplug)
        moments.at(moments.now() + 8, lambda: card.plug("Card"))
        read(source, 20)
    said = [record.message for record in caplog.records]
    assert said[0] == "the microphones were disconnected"
    assert said[1].startswith("audio.source: no microphones named 'card'")
    assert said[2:] == ["the microphones recovered"]


class FeedOfOthers:
    """Gives a second of sound, then raises whatever is asked of it."""

    def __init__(self, on_samples, clock):
        self._clock, self._end = clock, clock.now() + 1
        for step in range(1, 101):
            clock.at(clock.now() + step / 100, lambda: on_samples(np.full((HOP, 2), 0.25, np.float32)))

    @property
    def alive(self):
        if self._clock.now() > self._end:
            raise OSError(19, "No such device")
        return True

    def close(self):
        if self._clock.now() > self._end:
            raise KeyError("gone")


def test_whatever_a_feed_of_others_raises_is_told_and_it_is_opened_again(moments, caplog):
    opened = []

    def opener(on_samples):
        opened.append(moments.now())
        if len(opened) == 2:
            raise ValueError("no such\ncard")
        return FeedOfOthers(on_samples, moments)

    source = LiveSource(opener, RATE, ChannelMap.of(Audio()), 10.0, moments, start=at_once)
    with source:
        blocks = read(source, 4)
    assert [record.message for record in caplog.records][:3] == [
        "the microphones were disconnected",
        "the microphones cannot be closed: KeyError: 'gone'",
        "the microphones cannot be opened: ValueError: no such card",
    ]
    assert source.status().reopened > 0
    assert not blocks[-1].flags & AudioFlag.MISSING


def test_attempts_to_open_become_rarer(listen, make_card, moments):
    card = make_card()
    with listen(card) as source:
        moments.at(moments.now() + 1, card.unplug)
        read(source, 60)
    assert 5 <= card.listings - 1 <= 10


def test_a_stream_that_says_it_is_active_but_gives_nothing_is_opened_again(listen, make_card, moments):
    card = make_card()
    with listen(card) as source:
        begin = moments.now() + 1
        card.blocked = (begin, begin + 1e6, False)
        moments.at(begin + 1, lambda: setattr(card, "blocked", (0.0, 0.0, False)))
        read(source, 10)
        assert source.status().reopened == 1
        assert not source.read(HOP).flags & AudioFlag.MISSING


def test_channels_gain_and_polarity_are_as_wired_and_raw_is_as_it_came(listen, make_card):
    card = make_card()
    card.channels = 6
    with listen(card, channels=(4, 2), gain_db=(6.0, 0.0), invert=(False, True)) as source:
        block = source.read(HOP)
    assert block.raw[:, 0] == pytest.approx([4 / 64, 2 / 64])
    assert block.samples[:, 0] == pytest.approx([4 / 64 * 10 ** (6 / 20), -2 / 64], abs=2**-23)


@pytest.mark.parametrize(
    ("name", "keys", "said"),
    [
        ("violin", {}, r"no microphones named 'violin'; there are: 'USB one' \(ALSA, 2 channels\), 'USB two'"),
        ("usb", {}, "'usb' matches more than one device: 'USB one' .* 'USB two'"),
        ("USB ONE", {"channels": (0, 3)}, r"'USB one' \(ALSA, 2 channels\) has no channel 3"),
        (
            "usb two",
            {"rate_hz": 44100},
            "does not record 2 channels at 44100 Hz: Invalid sample rate.*own rate is 48000",
        ),
    ],
)
def test_what_cannot_be_opened_gets_one_clear_line(listen, make_card, name, keys, said):
    card = make_card(names=("USB one", "USB two"))
    with pytest.raises(AudioError, match=said), listen(card, name=name, **keys):
        pass


def test_a_card_that_opens_at_another_rate_is_refused_and_closed(listen, make_card):
    card = make_card()
    card.opened_rate = 48000.0
    with pytest.raises(AudioError, match="expected it to open at 16000 Hz, got 48000 Hz"), listen(card):
        pass
    assert not card.streams[0].active


def test_a_card_that_stays_silent_is_told_after_some_seconds(listen, make_card):
    card = make_card()
    card.blocked = (0.0, 1e9, False)
    with pytest.raises(AudioError, match="gave no audio within 5 s"), listen(card):
        pass
    assert not card.streams[0].active


def test_the_default_device_is_the_systems(listen, make_card):
    card = make_card(names=("first", "second"))
    card.default.device[0] = 1
    with listen(card, name="default") as source:
        assert source.read(HOP).samples.any()


@pytest.mark.soak
def test_an_hour_of_drift_stalls_and_gaps_stays_in_step_and_every_lost_sample_is_counted(
    listen, make_card, moments, errors
):
    card = make_card(ppm=-70, jitter=0.015)
    generator, lost = np.random.default_rng(11), 0
    with listen(card) as source:
        for _ in range(360):
            begin, length, keeps = moments.now() + 3, generator.uniform(0.05, 1.5), bool(generator.integers(2))
            card.blocked = (begin, begin + length, keeps)
            blocks = read(source, 10)
            lost += missing(blocks)
            assert np.abs(errors(blocks[-100:], card)).max() < 2 * NEAR
        assert source.status().lost == lost
        assert source.status().waiting < 0.6
