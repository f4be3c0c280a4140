"""Which microphone was tapped, the only way to see that two of them are swapped; and waiting for microphones."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import click
import numpy as np

from ross_payload.audio.channel_map import ChannelMap
from ross_payload.audio.open_source import open_source
from ross_payload.clock import SystemClock
from ross_payload.config import Config
from ross_payload.errors import AudioError
from ross_payload.interfaces import AudioSource, Clock, Real, Samples

BACKGROUND = 100  # blocks whose median is the background
LEARNT = 30  # blocks until the background is known
SUDDEN = 8.0  # a tap is so many times louder than the background
LEAST = 0.01  # and at least so loud, re full scale
LENGTH = 10  # blocks that a tap rings
CLEAR_DB = 3.0  # between both microphones


@dataclass(frozen=True, slots=True)
class Tap:
    """One tap."""

    microphone: int  # 1 or 2
    margin_db: float  # by how much it was louder there

    @property
    def clear(self) -> bool:
        """Whether it tells one microphone from the other."""
        return self.margin_db >= CLEAR_DB


class TapFinder:
    """Takes blocks of equal length, about 10 ms each, and tells of every tap."""

    def __init__(self) -> None:
        self._background: deque[float] = deque(maxlen=BACKGROUND)
        self._peaks: list[Real] = []
        self._last = np.zeros((2, 1), np.float32)

    def listen(self, samples: Samples) -> Tap | None:
        """Take the next block (2, n); returns a tap when one is over."""
        steps = np.diff(samples, axis=1, prepend=self._last)  # a tap is sharp; hum and rumble are not
        self._last = samples[:, -1:]
        peaks = np.abs(steps).max(axis=1).astype(np.float64)
        known = len(self._background) >= LEARNT
        sudden = max(LEAST, SUDDEN * float(np.median(self._background))) if known else np.inf
        if not self._peaks and peaks.max() < sudden:
            self._background.append(float(peaks.max()))
            return None
        self._peaks.append(peaks)
        return self._end() if len(self._peaks) == LENGTH else None

    def _end(self) -> Tap:
        peaks = np.maximum(np.max(self._peaks, axis=0), 1e-9)
        self._peaks.clear()
        louder = int(np.argmax(peaks))
        return Tap(louder + 1, float(20 * np.log10(peaks[louder] / peaks[1 - louder])))


TAP_TIMEOUT_S = 20.0  # for each tap
RETRY_PERIOD_S = 1.0  # [s]


def tap(config: Config) -> None:
    """Ask for a tap on each microphone, and say whether they are swapped.

    Raises
    ------
    AudioError
        When the microphones cannot be opened, or no clear tap is heard.
    """
    with open_source(config, SystemClock()) as source:
        heard = []
        for microphone in (1, 2):
            click.echo(f"Tap microphone {microphone} once with a fingernail.")
            heard.append(_wait(source, config.hop))
            click.echo(f"  heard at microphone {heard[-1].microphone}, {heard[-1].margin_db:.0f} dB louder there")
    click.echo(verdict(config, *heard))


def wait(config: Config, clock: Clock) -> None:
    """Wait until the source of a configuration can be opened: at boot a sound card may come late, or be plugged in.

    Says what it waits for, and again when that changes.

    Raises
    ------
    ConfigError
        At once, when the configuration is wrong: that does not pass.
    """
    told = ""
    while True:
        try:
            with open_source(config, clock):
                return
        except AudioError as error:
            if str(error) != told:
                told = str(error)
                click.echo(f"waiting for the microphones: {told}", err=True)
        clock.sleep(RETRY_PERIOD_S)


def _wait(source: AudioSource, hop: int) -> Tap:
    finder = TapFinder()
    for _ in range(round(TAP_TIMEOUT_S * source.rate / hop)):
        tap = finder.listen(source.read(hop).samples)
        if tap is None:
            continue
        if tap.clear:
            return tap
        click.echo(f"  equally loud at both ({tap.margin_db:.1f} dB apart): tap again, nearer to one of them")
    raise AudioError(f"no clear tap within {TAP_TIMEOUT_S:g} s; check the levels with `ross doctor`")


def verdict(config: Config, first: Tap, second: Tap) -> str:
    """Say what taps on microphone 1 and then 2 mean, and what to write into the configuration."""
    order = (first.microphone, second.microphone)
    if order == (1, 2):
        return "Microphones 1 and 2 are as configured."
    if order == (2, 1):
        channels = ChannelMap.of(config.audio).channels
        return f"The microphones are swapped: write channels = [{channels[1]}, {channels[0]}] in [audio]."
    return f"Both taps were heard at microphone {order[0]}: is the other one connected? Try again."
