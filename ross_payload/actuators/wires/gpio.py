"""Pulses on the pins of this computer: segments as waves of lgpio, which a thread of that library times.

A wave is a list of (levels, which pins, microseconds until the next). Waves follow one another without a gap while one
waits. The first begins when the thread of the library wakes up next, up to 20 ms after it was handed over, so all edges
of a move come that much after the plan. What has been handed over cannot be taken back.
"""

from __future__ import annotations

import contextlib
import importlib
import os
import tempfile
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ross_payload.actuators.tb6600 import pulse_segments
from ross_payload.errors import ConfigError, LinkError, PluginError
from ross_payload.interfaces import Clock
from ross_payload.plugins import install_line

SCHEME = "pulses:lgpio:"
AHEAD = 0.040  # most that may wait at the library: nobody can take it back [s]
WAKING = 0.020  # between two looks of the library's idle thread for new waves [s]
LATE = 0.001  # after its start, a segment that continues another comes too late [s]
URGENCY = 20  # real-time priority of the library's thread, above the pump's
DRAIN_MARGIN_S = 0.5  # beyond what still has to be played, when closing [s]

Pulse = tuple[int, int, int]  # levels, mask, delay until the next [us]


@dataclass(frozen=True, slots=True)
class Pins:
    """Which lines of which chip; ``home`` is None where there is no switch."""

    chip: int
    step: int
    direction: int
    enable: int
    home: int | None = None


def pins_of(url: str) -> Pins:
    """Read ``pulses:lgpio:CHIP:STEP,DIRECTION,ENABLE[,HOME]``.

    >>> pins_of("pulses:lgpio:0:17,27,22")
    Pins(chip=0, step=17, direction=27, enable=22, home=None)

    Raises
    ------
    ConfigError
        When the URL is malformed or names a line twice.
    """
    chip, _, lines = url.removeprefix(SCHEME).partition(":")
    numbers = lines.split(",")
    if not (chip.isdecimal() and len(numbers) in (3, 4) and all(number.isdecimal() for number in numbers)):
        raise ConfigError(f"pulse port '{url}': expected {SCHEME}CHIP:STEP,DIRECTION,ENABLE[,HOME], all numbers")
    if len(set(map(int, numbers))) < len(numbers):
        raise ConfigError(f"pulse port '{url}': expected different lines, got one twice")
    return Pins(int(chip), *map(int, numbers))


def wave(segment: pulse_segments.Segment, origin: float, written: int) -> tuple[list[Pulse], int]:
    """Turn a segment into the pulses of a wave; also where it ends, in whole microseconds since ``origin`` [s].

    Every time is rounded by itself, so that errors do not add up; ``written`` is where the wave before has ended. Two
    edges that are a whole number of microseconds apart, or more, stay so far apart.
    """
    times = np.rint((segment.start - origin + segment.edges["time"]) * 1e6).astype(np.int64)
    end = max(round((segment.end - origin) * 1e6), written, *times[-1:].tolist())
    moments, first = np.unique(times, return_index=True)
    masks = 1 << segment.edges["line"].astype(np.int64)
    levels = np.where(segment.edges["level"], masks, 0)
    if not len(moments):
        return [(0, 0, end - written)], end
    delays = np.diff(np.append(moments, end)).tolist()
    together = np.bitwise_or.reduceat(levels, first).tolist(), np.bitwise_or.reduceat(masks, first).tolist()
    lead = int(moments[0]) - written
    return ([(0, 0, lead)] if lead > 0 else []) + list(zip(*together, delays, strict=True)), end


class GpioPulses:
    """A pulse port on pins.

    The outputs are claimed by the first segment, with the level that it wants on ENABLE, so that no other level is ever
    there. Closing waits until the last edge is out and gives the lines back.

    Parameters
    ----------
    gpio
        The module lgpio.
    pins : Pins
        The lines.
    clock : Clock
        Tells when inputs are read.
    """

    def __init__(self, gpio: Any, pins: Pins, clock: Clock) -> None:
        self._gpio, self._pins, self._clock = gpio, pins, clock
        self._waiting: deque[tuple[float, list[Pulse]]] = deque()  # ends [s], waves for which there was no room
        self._playing: deque[float] = deque()  # ends of the waves that the library has [s]
        self._reports: list[pulse_segments.Report] = []
        self._capacity = 0  # waves, once claimed
        self._origin = 0.0  # of the microseconds of this stream [s]
        self._written = 0  # where the stream ends [us]
        self._end = 0.0  # of the last segment [s]
        self._handle: int | None = self._opened()
        if pins.home is not None:
            try:
                self._call(gpio.gpio_claim_input, self._handle, pins.home, gpio.SET_PULL_UP)
            except LinkError:
                self._release()
                raise

    def send(self, frame: Any) -> None:
        """Hand over one Segment, or report that it came too late.

        Raises
        ------
        LinkError
            When the library refuses.
        """
        segment: pulse_segments.Segment = frame
        if self._handle is None:
            raise LinkError(f"{self._name}: closed")
        if not self._capacity:
            self._claim(segment)
        self._take_stock()
        dry = not (self._playing or self._waiting)
        continues = abs(segment.start - self._end) < 1e-9
        self._end = segment.end
        too_late = continues and self._clock.now() > segment.start + LATE
        if dry and too_late and pulse_segments.takes_steps(segment):
            self._reports.append(pulse_segments.RanOut(segment.end))
            segment = pulse_segments.without_steps(segment)
        if dry:
            self._origin, self._written = segment.start, 0
        pulses, self._written = wave(segment, self._origin, self._written)
        self._waiting.append((segment.end, pulses))
        self._hand_over()

    def receive(self) -> list[Any]:
        """Return what has been played since, and the level of the switch."""
        if self._handle is None:
            return []
        self._take_stock()
        self._hand_over()
        if self._pins.home is not None:
            high = bool(self._call(self._gpio.gpio_read, self._handle, self._pins.home))
            self._reports.append(pulse_segments.Level(pulse_segments.PulseLine.HOME, high, self._clock.now()))
        reports, self._reports = self._reports, []
        return reports

    def close(self) -> None:
        """Wait until all is out, and give the lines back; idempotent."""
        if self._handle is None:
            return
        try:
            self._drain()
        finally:
            self._release()

    @property
    def _name(self) -> str:
        return f"/dev/gpiochip{self._pins.chip}"

    def _opened(self) -> int:
        try:
            with _urgent():
                return int(self._call(self._gpio.gpiochip_open, self._pins.chip))
        except LinkError as error:
            raise LinkError(f"{error}: does it exist, and is this user in its group (gpio)?") from error

    def _claim(self, segment: pulse_segments.Segment) -> None:
        """Take the outputs; STEP and DIRECTION low."""
        switches = segment.edges[segment.edges["line"] == pulse_segments.PulseLine.ENABLE]
        levels = [0, 0, int(len(switches) > 0 and bool(switches["level"][0]))]
        outputs = [self._pins.step, self._pins.direction, self._pins.enable]  # bits 0 to 2: the order of Line
        self._call(self._gpio.group_claim_output, self._handle, outputs, levels)
        self._capacity = self._room()

    def _room(self) -> int:
        return int(self._call(self._gpio.tx_room, self._handle, self._pins.step, self._gpio.TX_WAVE))

    def _take_stock(self) -> None:
        """Report the waves that the library has no more."""
        if self._playing:
            there = self._capacity - self._room()
            while len(self._playing) > there:
                self._reports.append(pulse_segments.Played(self._playing.popleft()))

    def _hand_over(self) -> None:
        while self._waiting and len(self._playing) < self._capacity:
            end, pulses = self._waiting.popleft()
            self._call(self._gpio.tx_wave, self._handle, self._pins.step, [self._gpio.pulse(*p) for p in pulses])
            self._playing.append(end)

    def _drain(self) -> None:
        until = max(self._clock.now(), self._end) + WAKING + DRAIN_MARGIN_S
        while (self._playing or self._waiting) and self._clock.now() < until:
            with contextlib.suppress(
                RuntimeError
            ):  # somebody else's call died; the motor must come to rest all the same
                self._clock.sleep(WAKING / 4)
            self._take_stock()
            self._hand_over()

    def _release(self) -> None:
        handle, self._handle = self._handle, None
        self._call(self._gpio.gpiochip_close, handle)

    def _call(self, function: Callable[..., Any], *arguments: Any) -> Any:
        try:
            return function(*arguments)
        except self._gpio.error as error:
            raise LinkError(f"{self._name}: {error.value}") from error


def open_pins(url: str, clock: Clock) -> GpioPulses:
    """Open the pins that a URL names.

    Raises
    ------
    ConfigError
        When the URL is malformed or lgpio is missing.
    LinkError
        When there is no such chip, or a line is taken.
    """
    pins = pins_of(url)
    return GpioPulses(_lgpio(url), pins, clock)


@contextlib.contextmanager
def _urgent() -> Iterator[None]:
    """Give threads that are born here real-time priority where the system allows it: edges wait for nobody."""
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    with contextlib.suppress(OSError):  # no right to it
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(URGENCY))
    try:
        yield
    finally:
        os.sched_setscheduler(0, *before)


def _lgpio(url: str) -> Any:
    """Import lgpio in a folder that goes away: it leaves a pipe where it is imported."""
    try:
        with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
            return importlib.import_module("lgpio")
    except ModuleNotFoundError as error:
        raise PluginError(
            f"'{url}' needs the package lgpio: {install_line('gpio')} (CPython up to 3.12), or Debian's python3-lgpio"
        ) from error
    except OSError as error:
        raise LinkError(f"'{url}': lgpio does not start: {error}") from error
