"""Whether a task could hear at all: that nobody was found tells something only where both microphones gave sound."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from scipy.fft import rfft

from ross_payload.health import DEAD_DB, DEAD_FROM_HZ, are_identical
from ross_payload.interfaces import UNHEARD, AudioFlag, Samples

SHARE = 0.25  # of a task without sound, from which it cannot tell who is there
LATELY_S = 2.0  # without sound at its end, from which it cannot either
PIECE_S = 0.1  # of sound, which is judged
BRIEFLY_S = 0.3  # one that gave no sound for less, before neither did, had its noise gate close first
SATURATED = 0.03  # of the samples of a piece at full scale: from there on its phases tell of no direction
CLOSE = 2.0**-14  # to the loudest sample: as loud; 16 bits end at 1 - 2**-15
SOFT = 2.0**-31  # power that 16 bits may not resolve: of sound no louder than it one microphone may give zeros alone


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
    samples: int = 0  # in pieces
    missing: _Without = field(default_factory=_Without)
    quiet: int = 0  # samples of them that are zeros without a flag, since the last sound
    dead: tuple[_Without, _Without] = field(default_factory=lambda: (_Without(), _Without()))
    deaf: bool = False  # in the latest piece one was dead or saturated, both were one, or nothing came: no direction
    _piece: list[Samples] = field(default_factory=list)  # the next one
    _length: int = 0  # of it [samples]
    _gone: int = 0  # samples of it that never came
    _clipped: bool = False  # some of it was at full scale

    def add(self, samples: Samples, rate: int, flags: AudioFlag = AudioFlag.NONE) -> None:
        """Take a hop (2, n); zeros stand for samples that never came.

        Those without a flag are a quiet room when sound follows: behind a noise gate, or softer than 16 bits resolve.
        """
        n = samples.shape[1]
        self._piece.append(samples)
        self._length += n
        if flags and flags & UNHEARD and not samples.any():
            self._gone += n
        if flags and flags & AudioFlag.CLIPPED:
            self._clipped = True
        if self._length >= PIECE_S * rate:
            self.rate = rate
            piece = np.concatenate(self._piece, axis=1)
            self._judge(piece, self._gone)
            lately = self._gone == piece.shape[1] or any(dead.lately for dead in self.dead)
            self.deaf = lately or (self._clipped and saturated(piece)) or identical(piece)
            self._piece.clear()
            self._length, self._gone, self._clipped = 0, 0, False

    def _judge(self, piece: Samples, gone: int) -> None:
        n, sound = piece.shape[1], bool(piece.any())
        self.samples += n
        self.missing.add(n, sound=sound)
        if sound:
            self.missing.samples += gone - self.quiet
            self.quiet = 0
        else:
            self.quiet += n - gone
        first = math.ceil(DEAD_FROM_HZ * n / self.rate)
        spectrum = rfft(piece * _window(n))[:, first:]
        power = np.einsum("ij,ij->i", spectrum, spectrum.conj()).real
        soft = SOFT * float(np.sum(_window(n) ** 2)) * spectrum.shape[1]
        if power.max() <= soft:  # of a quiet room neither tells whether it is dead
            for silent in self.dead:
                silent.lately = silent.lately if silent.lately >= BRIEFLY_S * self.rate else 0
            return
        for microphone, other in ((0, 1), (1, 0)):
            dead = power[microphone] * 10 ** (DEAD_DB / 10) < power[other] and power[other] > soft
            self.dead[microphone].add(n, sound=not dead)

    def dead_for(self, seconds: float) -> int | None:
        """Return which microphone, 1 or 2, has been dead for so long [s] until now; None: neither."""
        lately = (number for number, dead in enumerate(self.dead, start=1) if dead.lately >= seconds * self.rate)
        return next(lately, None)

    def fault(self) -> str:
        """Return why nobody would have been heard, in words; empty when there is no reason."""
        kinds = (
            ("no audio came", self.missing),
            *((f"microphone {number} was dead", dead) for number, dead in enumerate(self.dead, start=1)),
        )
        for what, without in kinds:
            if without.samples > SHARE * self.samples:
                return f"{what} for {100 * without.samples / self.samples:.0f} % of the time"
            if without.lately >= LATELY_S * self.rate:
                return f"{what} for the last {without.lately / self.rate:.0f} s"
        return ""


def saturated(piece: Samples) -> bool:
    """Whether too many samples of a microphone are at full scale in a piece (2, n) that has clipped.

    >>> tone = np.sin(np.arange(1600) / 5)
    >>> [saturated(np.clip(gain * np.stack([tone, 0.1 * tone]), -1, 1)) for gain in (1.001, 2.0)]
    [False, True]
    """
    size = np.abs(piece)
    full = (1 - CLOSE) * size.max(axis=1, keepdims=True)
    return bool(np.any(np.mean(size >= full, axis=1) > SATURATED))


def identical(piece: Samples) -> bool:
    """Whether both channels of a piece (2, n) are one microphone, as loud or not.

    >>> one, other = np.random.default_rng(1).standard_normal((2, 1600))
    >>> [identical(np.stack([one, 0.5 * one])), identical(np.stack([one, one + 0.01 * other]))]
    [True, False]
    """
    moving = piece.astype(np.float64) - piece.mean(axis=1, dtype=np.float64, keepdims=True)
    (first, product), (_, second) = moving @ moving.T / piece.shape[1]
    return are_identical(float(first), float(second), float(product))


@lru_cache(maxsize=4)
def _window(n: int) -> Samples:
    return np.asarray(np.hanning(n), dtype=np.float32)
