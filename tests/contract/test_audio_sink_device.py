"""A voice on a sound output: played in time, through gaps, other crystals and a plug that is pulled."""

from __future__ import annotations

from contextlib import suppress
from types import SimpleNamespace

import numpy as np
import pytest

from examples import in_soak
from ross_payload.audio.channel_map import ChannelMap
from ross_payload.audio.shared_portaudio import SELDOM
from ross_payload.audio.sinks import info_of
from ross_payload.audio.sinks.device_sink import DeviceOptions, DeviceSink
from ross_payload.audio.sound_card import SoundCard
from ross_payload.config import Audio
from ross_payload.errors import AudioError
from ross_payload.interfaces import VoiceBlock
from sink_bench import HOP, RATE, blocks, services, voice

pytestmark = pytest.mark.process


class FakeOutput:
    """What the device sink uses of the module sounddevice, and the card behind it, which plays when it is told to."""

    PortAudioError = type("PortAudioError", (Exception,), {})

    def __init__(self):
        self.names = ["HDA Analog", "USB Headphones"]
        self._listed = list(self.names)
        self.default = SimpleNamespace(device=[-1, 0])
        self.streams = []

    def query_hostapis(self):
        return [{"name": "ALSA"}]

    def query_devices(self):
        common = {"hostapi": 0, "max_input_channels": 2, "max_output_channels": 2, "default_samplerate": 48000.0}
        return [{"name": name, **common} for name in self._listed]

    def check_input_settings(self, **settings):
        pass

    def _terminate(self):
        for stream in self.streams:
            stream.freed = True
        self._listed = []

    def _initialize(self):
        self._listed = list(self.names)

    def OutputStream(self, **settings):  # noqa: N802 - its name
        if self._listed[settings["device"]] not in self.names:
            raise self.PortAudioError("Device unavailable [PaErrorCode -9985]")
        self.streams.append(FakeStream(**settings))
        return self.streams[-1]

    def InputStream(self, **settings):  # noqa: N802 - its name
        return self.OutputStream(**settings)

    def play(self, n):
        """Let the card take so many samples; return them."""
        stream = self.streams[-1]
        out = np.full((n, stream.channels), 9.0, np.float32)
        stream.callback(out, n, None, None)
        assert np.array_equal(out[:, 0], out[:, 1])
        return out[:, 0]

    def unplug(self):
        self.names = []
        for stream in self.streams:
            stream.runs = False


class FakeStream(SimpleNamespace):
    """A stream, whose memory is nobody's any more when PortAudio was terminated."""

    runs = freed = False

    @property
    def active(self):
        assert not self.freed
        return self.runs

    def start(self):
        self.runs = True

    def close(self, ignore_errors=True):
        assert not self.freed
        self.runs = False


class AtOnce:
    def __init__(self, call):
        call()

    def join(self, timeout):
        pass


@pytest.fixture
def card():
    return FakeOutput()


@pytest.fixture
def headphones(card, tmp_path):
    return DeviceSink(DeviceOptions(device="usb", latency_ms=100), services(tmp_path), card, AtOnce)


def test_what_is_written_is_played_once_enough_waits(card, headphones):
    samples = voice(0.5)
    with headphones:
        assert card.streams[-1].device == 1
        headphones.write(VoiceBlock(samples[:HOP], 0, 0.0))
        assert not card.play(100).any()
        for block in blocks(samples[HOP : 8 * HOP], HOP):
            headphones.write(block)
        played = np.concatenate([card.play(128) for _ in range(4)])
    assert np.array_equal(played, samples[:512])
    assert headphones.lost == 0
    assert info_of(headphones).address == "USB Headphones"


def test_a_voice_that_comes_too_late_is_silence_and_counted(card, headphones):
    with headphones:
        for block in blocks(voice(0.128)):
            headphones.write(block)
        card.play(2000)
        late = card.play(100)
    assert not late[-52:].any()
    assert headphones.lost == 52


@pytest.mark.parametrize("share", [1.003, *in_soak(0.997)])
def test_a_card_with_another_crystal_neither_runs_dry_nor_falls_behind(card, headphones, share):
    samples, played = 0.5 * np.sin(2 * np.pi * 200 / RATE * np.arange(60 * RATE)).astype(np.float32), []
    with headphones:
        for block in blocks(samples):
            headphones.write(block)
            taken = round((block.index + HOP) * share) - sum(map(len, played))
            played.append(card.play(taken))
    assert headphones.lost == 0
    heard = np.concatenate(played)[RATE:]
    assert np.abs(np.diff(heard)).max() < 1.1 * 0.5 * 2 * np.pi * 200 / RATE  # no click


def test_what_a_card_did_not_take_in_time_is_left_out_instead_of_a_delay(card, headphones):
    samples, stopped, after = voice(3.0), RATE // 2, None
    with headphones:
        for block in blocks(samples):
            headphones.write(block)
            if block.index < RATE or block.index >= RATE + stopped:
                after = card.play(HOP)
        waiting = headphones._ring.waiting
        assert waiting <= 0.1 * RATE + HOP
        assert np.isin(after, samples[-waiting - 2 * HOP :]).all(), "it plays what was written lately"
        assert headphones.lost == pytest.approx(stopped, abs=2 * HOP)


def test_what_waits_while_a_card_is_opened_is_no_delay(card, headphones):
    samples = voice(1.0)
    with headphones:
        for block in blocks(samples):
            headphones.write(block)
        wanted = round(0.1 * RATE)
        assert np.array_equal(card.play(HOP), samples[-wanted:][:HOP])
        assert headphones.lost == len(samples) - wanted


def test_a_device_that_is_unplugged_is_a_fault_and_opened_again_when_it_is_back(card, headphones):
    with headphones:
        every = blocks(voice(60.0))
        headphones.write(next(every))
        card.unplug()
        headphones.write(next(every))
        assert headphones.fault == "the sound output 'USB Headphones' was disconnected"
        assert headphones.lost == HOP
        card.names = ["USB Headphones"]
        headphones.write(next(every))
        assert headphones.fault  # not tried again at once
        headphones._clock.ahead += 5.0
        headphones.write(next(every))
        assert headphones.fault == ""
        headphones.write(next(every))
        assert headphones.lost == 3 * HOP
        assert len(card.streams) == 2


def test_a_device_that_is_not_there_is_told_with_those_that_are(card, tmp_path):
    sink = DeviceSink(DeviceOptions(device="bluetooth"), services(tmp_path), card)
    expected = "device: no sound output named 'bluetooth'; there are: 'HDA Analog' (ALSA, 2 channels), 'USB Headphones'"
    with pytest.raises(AudioError) as error, sink:
        pass
    assert str(error.value).startswith(expected)


def test_silence_before_a_device_was_unplugged_stays_counted(card, headphones):
    with headphones:
        every = blocks(voice(60.0))
        while headphones._ring.waiting < 0.1 * RATE:
            headphones.write(next(every))
        card.play(2 * headphones._ring.waiting)
        silent = headphones.lost
        assert silent > 0
        card.unplug()
        headphones.write(next(every))
        assert headphones.lost == silent + HOP


def test_it_plays_again_after_the_microphones_were_opened_again(card, headphones):
    audio = Audio()
    microphones = SoundCard("analog", audio, ChannelMap.of(audio), card)
    with headphones:
        first = microphones(len)
        every = blocks(voice(60.0))
        headphones.write(next(every))
        assert len(card.streams) == 2, "nothing was ended to open the microphones for the first time"
        first.close()
        second = microphones(len)
        headphones.write(next(every))
        assert second.alive
        headphones._clock.ahead += 5.0
        while headphones._ring.waiting < 0.1 * RATE:
            headphones.write(next(every))
        assert card.play(HOP).any()
        assert second.alive, "microphones outlive the opening of headphones"
        assert headphones.fault == ""
        second.close()


def test_headphones_that_come_late_are_found_while_nothing_else_is_open(card, headphones):
    card.names = ["HDA Analog"]
    card._initialize()
    with pytest.raises(AudioError, match="no sound output named 'usb'"), headphones:
        pass
    card.names = ["USB Headphones"]
    for _ in range(SELDOM):  # attempts of who drives the sink
        with suppress(AudioError), headphones:
            assert info_of(headphones).listeners == 1
    assert card.streams
