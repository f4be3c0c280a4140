"""Whether a task could hear at all: that nobody was found tells something only where both microphones gave sound."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ross_payload.interfaces import Samples

LOWEST_HZ = 400.0  # of what is compared: below it hum and wind may be far louder at one microphone
FAR_LESS_DB = 30.0  # between a dead microphone and the other, as the health of the microphones has it
SHARE = 0.25  # of a task without sound, from which it cannot tell who is there
LATELY_S = 2.0  # without sound at its end, from which it cannot either


@dataclass(slots=True)
class _Without:
    """Hops without sound."""

    hops: int = 0
    lately: float = 0.0  # [s] until now

    def add(self, *, sound: bool, seconds: float) -> None:
        self.hops += not sound
        self.lately = 0.0 if sound else self.lately + seconds


@dataclass(slots=True)
class Hearing:
    """How much of what a task heard was no sound.

    >>> hearing, rate = Hearing(), 16000
    >>> tone = np.sin(2 * np.pi * 1000 / rate * np.arange(160))
    >>> for _ in range(100):
    ...     hearing.add(np.stack([tone, 0.01 * tone]).astype(np.float32), rate)
    >>> hearing.fault()
    'microphone 2 was dead for 100 % of the time'
    """

    hops: int = 0
    missing: _Without = field(default_factory=_Without)
    dead: tuple[_Without, _Without] = field(default_factory=lambda: (_Without(), _Without()))

    def add(self, samples: Samples, rate: int) -> None:
        """Take a hop (2, n); zeros stand for samples that never came."""
        self.hops += 1
        n = samples.shape[1]
        spectrum = np.fft.rfft(samples * np.hanning(n))[:, math.ceil(LOWEST_HZ * n / rate) :]
        power = np.sum(np.abs(spectrum) ** 2, axis=1)
        seconds, came, far = n / rate, bool(samples.any()), 10 ** (FAR_LESS_DB / 10)
        self.missing.add(sound=came, seconds=seconds)
        for microphone, other in ((0, 1), (1, 0)):
            dead = came and bool(power[microphone] * far < power[other])
            self.dead[microphone].add(sound=not dead, seconds=seconds)

    def fault(self) -> str:
        """Return why nobody would have been heard, in words; empty when there is no reason."""
        kinds = (
            ("no audio came", self.missing),
            *((f"microphone {number} was dead", dead) for number, dead in enumerate(self.dead, start=1)),
        )
        for what, without in kinds:
            if without.hops > SHARE * self.hops:
                return f"{what} for {100 * without.hops / self.hops:.0f} % of the time"
            if without.lately >= LATELY_S:
                return f"{what} for the last {without.lately:.0f} s"
        return ""
