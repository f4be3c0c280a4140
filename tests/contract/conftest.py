"""A sound card whose crystal, driver and plug can be told to misbehave, on a clock that moves only when asked."""

from __future__ import annotations

import heapq
import itertools
from types import SimpleNamespace

import numpy as np
import pytest

COUNTS = 2**22  # channel 0 counts the frames that the card has captured since the world began, re 2**23


class Moments:
    """A clock without quanta: calls run at their exact time."""

    def __init__(self):
        self._now = 100.0
        self._calls = []
        self._order = itertools.count()

    def now(self):
        return self._now

    def at(self, time, call):
        heapq.heappush(self._calls, (max(time, self._now), next(self._order), call))

    def sleep(self, duration):
        end = self._now + duration
        while self._calls and self._calls[0][0] <= end:
            time, _, call = heapq.heappop(self._calls)
            self._now = max(self._now, time)
            call()
        self._now = max(self._now, end)

    def pause(self, duration):
        """Go on so much later, as a computer does whose host had no time for it: what was due is overdue."""
        self._now += duration


class PortAudioError(Exception):
    pass


class FakePortAudio:
    """What the payload uses of the module sounddevice, and the card behind it.

    Every frame says when it was captured: channel 0 is its number by the card's crystal, channel c > 0 is c / 64.
    """

    PortAudioError = PortAudioError

    def __init__(self, clock, *, rate=16000, ppm=0.0, period=0.010, jitter=0.0, names=("Card: USB Audio (hw:1,0)",)):
        self.clock = clock
        self.rate = rate
        self.true_rate = rate * (1 + ppm * 1e-6)
        self.period, self.jitter = period, jitter
        self.names = list(names)
        self.channels = 2
        self.opened_rate = None  # a card that opens at another rate than it was asked for
        self.streams = []
        self.listings = 1
        self.blocked = (0.0, 0.0, False)  # from, until [s], and whether the driver keeps what nobody fetched
        self.speed = np.inf  # at which what was kept is handed on, re real time
        self.default = SimpleNamespace(device=[0, -1])
        self._generator = np.random.default_rng(5)
        self._listed = list(names)

    def query_hostapis(self):
        return [{"name": "ALSA"}]

    def query_devices(self):
        common = {"hostapi": 0, "max_input_channels": self.channels, "default_samplerate": 48000.0}
        return [{"name": name, **common} for name in self._listed]

    def check_input_settings(self, device, channels, dtype, samplerate):
        if samplerate != self.rate:
            raise PortAudioError("Invalid sample rate [PaErrorCode -9997]")

    def _terminate(self):
        self._listed = []

    def _initialize(self):
        self.listings += 1
        self._listed = list(self.names)

    def InputStream(self, **settings):  # noqa: N802 - its name
        if not self.names or settings["device"] >= len(self._listed):
            raise PortAudioError("Device unavailable [PaErrorCode -9985]")
        stream = FakeStream(self, settings)
        self.streams.append(stream)
        return stream

    def late(self):
        return self.jitter * self._generator.random()

    def unplug(self):
        self.names = []
        for stream in self.streams:
            stream.die()

    def plug(self, *names):
        self.names = list(names)


class FakeStream:
    def __init__(self, card, settings):
        self._card, self._channels = card, settings["channels"]
        self._callback, self._finished = settings["callback"], settings["finished_callback"]
        self.samplerate = card.opened_rate or float(settings["samplerate"])
        self.active = False
        self._count = 0

    def start(self):
        self.active = True
        self._count = self._captured(self._card.clock.now())
        self._next()

    def close(self, ignore_errors=True):
        self.active = False

    def die(self):
        if self.active:
            self.active = False
            self._finished()

    def _captured(self, time):
        return int(time * self._card.true_rate)

    def _next(self):
        due = self._card.clock.now() + self._card.period + self._card.late()
        begin, until, keeps = self._card.blocked
        blocked = begin <= due < until
        self._card.clock.at(until if blocked else due, lambda: self._call(blocked and not keeps))

    def _call(self, loses):
        if not self.active:
            return
        end = self._captured(self._card.clock.now())
        if np.isfinite(self._card.speed):
            end = min(end, self._count + round(self._card.speed * self._card.period * self._card.rate))
        if loses:  # the card overwrote what was not fetched but its last period
            self._count = end - round(self._card.period * self._card.rate)
        frames = np.empty((end - self._count, self._channels), np.float32)
        frames[:] = np.arange(self._channels) / 64
        frames[:, 0] = (np.arange(self._count, end) % COUNTS) / 2**23
        self._count = end
        for begin in range(0, len(frames), 160):
            self._callback(frames[begin : begin + 160], len(frames), None, None)
        self._next()


def captured(samples, near, rate):
    """When samples of channel 0 were captured [s], by what they count; ``near`` resolves the wrap."""
    numbers = np.asarray(samples, np.float64) * 2**23
    wraps = np.rint((near * rate - numbers) / COUNTS)
    return (numbers + wraps * COUNTS) / rate


@pytest.fixture
def moments():
    return Moments()


@pytest.fixture
def make_card(moments):
    return lambda **behaviour: FakePortAudio(moments, **behaviour)


@pytest.fixture
def captured_at():
    return captured
