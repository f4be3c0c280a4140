"""Whether a task could hear at all: that nobody was found tells something only where both microphones gave sound."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ross_payload.interfaces import AudioFlag, Samples

LOWEST_HZ = 400.0  # of what is compared: below it hum and wind may be far louder at one microphone
FAR_LESS_DB = 30.0  # between a dead microphone and the other, as the health of the microphones has it
SHARE = 0.25  # of a task without sound, from which it cannot tell who is there
LATELY_S = 2.0  # without sound at its end, from which it cannot either
PIECE_S = 0.1  # of sound, whose microphones are compared
SOFT = 2.0**-31  # power that 16 bits may not resolve: of sound no louder than it one microphone may give zeros alone
NEVER_CAME = AudioFlag.MISSING | AudioFlag.INVALID


@dataclass(slots=True)
class _Without:
    """Samples without sound."""

    samples: int = 0
    lately: int = 0  # until now

    def add(self, samples: int, *, sound: bool) -> None:
        self.samples += 0 if sound else samples
        self.lately = 0 if sound else self.lately + samples


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

    rate: int = 1  # [Hz]
    samples: int = 0
    compared: int = 0  # samples, of them
    missing: _Without = field(default_factory=_Without)
    quiet: int = 0  # samples of them that are zeros without a flag, since the last sound
    dead: tuple[_Without, _Without] = field(default_factory=lambda: (_Without(), _Without()))
    _waiting: list[Samples] = field(default_factory=list)  # to be compared, once there is enough

    def add(self, samples: Samples, rate: int, flags: AudioFlag = AudioFlag.NONE) -> None:
        """Take a hop (2, n); zeros stand for samples that never came.

        Those without a flag are a quiet room when sound follows: behind a noise gate, or softer than 16 bits resolve.
        """
        self.rate = rate
        sound = bool(samples.any())
        self.samples += samples.shape[1]
        self.missing.add(samples.shape[1], sound=sound)
        if sound:
            self.missing.samples -= self.quiet
            self.quiet = 0
        elif not flags & NEVER_CAME:
            self.quiet += samples.shape[1]
        self._waiting.append(samples)
        if self.samples - self.compared >= PIECE_S * rate:
            piece = np.concatenate(self._waiting, axis=1)
            self._waiting.clear()
            self.compared = self.samples
            self._compare(piece)

    def _compare(self, piece: Samples) -> None:
        n = piece.shape[1]
        window = np.hanning(n)
        spectrum = np.fft.rfft(piece * window)[:, math.ceil(LOWEST_HZ * n / self.rate) :]
        power = np.sum(np.abs(spectrum) ** 2, axis=1)
        soft = SOFT * np.sum(window**2) * spectrum.shape[1]
        for microphone, other in ((0, 1), (1, 0)):
            dead = power[microphone] * 10 ** (FAR_LESS_DB / 10) < power[other] and power[other] > soft
            self.dead[microphone].add(n, sound=not dead)

    def fault(self) -> str:
        """Return why nobody would have been heard, in words; empty when there is no reason."""
        kinds = (
            ("no audio came", self.missing, self.samples),
            *((f"microphone {number} was dead", dead, self.compared) for number, dead in enumerate(self.dead, start=1)),
        )
        for what, without, whole in kinds:
            if without.samples > SHARE * whole:
                return f"{what} for {100 * without.samples / whole:.0f} % of the time"
            if without.lately >= LATELY_S * self.rate:
                return f"{what} for the last {without.lately / self.rate:.0f} s"
        return ""
