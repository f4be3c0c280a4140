"""What the payload uses of the module lgpio, and the thread behind it, on a clock that moves only when asked.

As in lgpio 0.2: an idle thread looks for new waves every 20 ms; waves that are queued follow without a gap; when the
last is over the stream has ended. Edges come exactly at their microsecond, as on a computer that is never busy.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Any

import numpy as np

from ross_payload.actuators.tb6600.pulse_segments import EDGE, PulseLine

WAKE = 20_000  # [us]
SLOTS = 10


class LgpioError(Exception):
    def __init__(self, value: str) -> None:
        super().__init__(value)
        self.value = value


@dataclass
class FakePulse:
    group_bits: int
    group_mask: int
    pulse_delay: int


class FakeLgpio:
    """One chip; `phase` [s] is when its thread looks for waves, `taken` are lines that somebody else has."""

    TX_WAVE = 1
    SET_PULL_UP = 32
    error = LgpioError
    pulse = FakePulse

    def __init__(self, clock: Any, phase: float = 0.0, taken: tuple[int, ...] = ()) -> None:
        self._clock = clock
        self._phase = round(phase * 1e6)
        self._taken = taken
        self._waves: deque[list[FakePulse]] = deque()
        self._position = 0
        self._due = 0  # [us]
        self._levels: dict[int, int] = {}
        self._outputs: list[int] = []
        self._played = 0  # edges given out by `new_edges`
        self.inputs: dict[int, int] = {}  # levels from outside
        self.flags: dict[int, int] = {}
        self.edges: list[tuple[int, int, int]] = []  # time [us], bit, level; changes only
        self.claimed: list[tuple[list[int], list[int]]] = []
        self.starts: list[int] = []  # of streams [us]
        self.most = 0  # waves that were there at once
        self.open_handles = 0

    def gpiochip_open(self, chip: int) -> int:
        if chip != 0:
            raise LgpioError("can not open gpiochip")
        self.open_handles += 1
        return 0

    def gpiochip_close(self, handle: int) -> int:
        self._run()
        self._waves.clear()
        self._outputs = []
        self.open_handles -= 1
        return 0

    def group_claim_output(self, handle: int, lines: list[int], levels: list[int]) -> int:
        if set(lines) & set(self._taken):
            raise LgpioError("GPIO busy")
        self._outputs = lines
        for bit, level in enumerate(levels):
            self._write(self._now(), bit, level)
        self.claimed.append((lines, levels))
        return 0

    def gpio_claim_input(self, handle: int, line: int, flags: int) -> int:
        if line in self._taken:
            raise LgpioError("GPIO busy")
        self.flags[line] = flags
        return 0

    def gpio_read(self, handle: int, line: int) -> int:
        return self.inputs.get(line, 1)

    def tx_room(self, handle: int, line: int, kind: int) -> int:
        assert (line, kind) == (self._outputs[0], self.TX_WAVE)
        self._run()
        return SLOTS - len(self._waves)

    def tx_wave(self, handle: int, line: int, pulses: list[FakePulse]) -> int:
        assert line == self._outputs[0]
        self._run()
        if len(self._waves) == SLOTS:
            raise LgpioError("TX queue full")
        if not self._waves:
            self._position = 0
            self._due = self._phase + (math.floor((self._now() - self._phase) / WAKE) + 1) * WAKE
            self.starts.append(self._due)
        self._waves.append(pulses)
        self.most = max(self.most, len(self._waves))
        return SLOTS - len(self._waves)

    def new_edges(self) -> np.ndarray:
        """Edges that have come out since the last call, times on the clock [s]."""
        self._run()
        new, self._played = self.edges[self._played :], len(self.edges)
        return np.array([(time * 1e-6, line, level) for time, line, level in new], dtype=EDGE)

    def _now(self) -> int:
        return round(self._clock.now() * 1e6)

    def _run(self) -> None:
        """Let the thread live until now."""
        now = self._now()
        while self._waves and self._due <= now:
            if self._position >= len(self._waves[0]):
                self._waves.popleft()
                self._position = 0
                continue
            pulse = self._waves[0][self._position]
            self._position += 1
            for bit in PulseLine.STEP, PulseLine.DIRECTION, PulseLine.ENABLE:
                if pulse.group_mask >> bit & 1:
                    self._write(self._due, bit, pulse.group_bits >> bit & 1)
            self._due += pulse.pulse_delay

    def _write(self, time: int, bit: int, level: int) -> None:
        if self._levels.get(bit) != level:
            self._levels[bit] = level
            self.edges.append((time, int(bit), level))
