"""Makes one consecutive stream of what arrives: gaps become zeros, so that counting samples is counting time.

Drivers do not tell of gaps: a callback that was blocked raises no flag. They are found by counting frames against the
Clock. A piece that arrives late is held back until it is clear what it is: when later ones catch up, the thread was
late and nothing is missing; when none has after 0.3 s, the earliest tells how much is missing before the first.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from ross_payload.audio.ring import Piece
from ross_payload.audio.sample_clock import SampleClock
from ross_payload.interfaces import Samples

LATE = 0.040  # [s] behind the Clock: held back
CAUGHT_UP = 0.020  # [s] behind the Clock: nothing is missing
DECIDE = 0.3  # [s] until what did not catch up is a gap
SILENCE_TIMEOUT_S = 0.5  # without a sample until zeros take their place
WARM_UP = 0.5  # [s] at the start, in which the clock is learnt


@dataclass(frozen=True, slots=True)
class Stretch:
    """Consecutive samples."""

    samples: Samples  # (2, n)
    time: float  # of the first, on the Clock [s]
    missing: int  # samples that never came, zeros in their place


class GapFiller:
    """Takes pieces, gives consecutive samples; belongs to the reader.

    Parameters
    ----------
    rate
        Of what arrives [Hz].
    settling
        What nobody hears at the start [s], at most `WARM_UP`: sample 0 is the first after it.
    """

    def __init__(self, rate: int, settling: float = 0.0) -> None:
        self._rate = rate
        self._unheard = round(settling * rate)
        self._clock: SampleClock | None = None
        self._held: list[Piece] = []
        self._earliest = math.inf  # residual of those held [s]
        self._expected = 0  # frames offered so far
        self._ready: deque[Samples | int] = deque()  # samples, or how many zeros
        self._index = 0  # of the next sample to give
        self._end = 0  # behind all that is ready
        self._owed = 0  # zeros given in advance while nothing came
        self.missing = 0  # samples that never came, since the start

    @property
    def started(self) -> bool:
        """Whether the warm-up is over."""
        return self._clock is not None

    @property
    def available(self) -> int:
        """Samples that can be given."""
        return self._end - self._index

    @property
    def held(self) -> int:
        """Samples that are held back."""
        return sum(piece.samples.shape[1] for piece in self._held)

    @property
    def rate(self) -> float | None:
        """Measured against the Clock [Hz]; None until it is known."""
        return None if self._clock is None else self._clock.rate

    def add(self, piece: Piece) -> None:
        """Take what one callback brought."""
        refused, self._expected = piece.offered - self._expected, piece.offered + piece.samples.shape[1]
        if self._clock is None:
            self._warm_up(piece)
            return
        if refused:
            self._resolve(self._clock)
            given = min(refused, self._owed)
            self._owed -= given
            self._zeros(refused - given)
        self._held.append(piece)
        behind = piece.arrived - self._clock.ahead(self._end + self.held)
        self._earliest = min(self._earliest, behind)
        in_time = behind < (LATE if len(self._held) == 1 else CAUGHT_UP)
        if (in_time and not self._owed) or piece.arrived - self._held[0].arrived >= DECIDE:
            self._resolve(self._clock)

    def wait(self, now: float) -> None:
        """Nothing more has arrived by ``now`` [s]: decide about what is held, and go on with zeros."""
        if self._clock is None:
            return
        if self._held and now - self._held[0].arrived >= DECIDE:
            self._resolve(self._clock)
        silent = round((now - SILENCE_TIMEOUT_S - self._clock.ahead(self._end)) * self._rate)
        if not self._held and silent > 0:
            if not self._owed:
                self._clock.coast(self._end)
            self._owed += silent
            self._zeros(silent)

    def read(self, n: int) -> Stretch:
        """Give the next ``n`` samples; there must be as many."""
        if self._clock is None or self.available < n:
            raise ValueError(f"expected a request for at most {self.available} samples, got {n}")
        samples, missing = np.zeros((2, n), np.float32), 0
        done = 0
        while done < n:
            head = self._ready.popleft()
            size = head if isinstance(head, int) else head.shape[1]
            used = min(size, n - done)
            if isinstance(head, int):
                missing += used
            else:
                samples[:, done : done + used] = head[:, :used]
            if used < size:
                self._ready.appendleft(head - used if isinstance(head, int) else head[:, used:])
            done += used
        time = self._clock.time(self._index)
        self._index += n
        return Stretch(samples, time, missing)

    def _warm_up(self, piece: Piece) -> None:
        self._held.append(piece)
        if piece.arrived - self._held[0].arrived < WARM_UP:
            return
        end, earliest = 0, math.inf
        for held in self._held:
            end += held.samples.shape[1]
            earliest = min(earliest, held.arrived - end / self._rate)
        self._clock = SampleClock(self._rate, earliest + self._unheard / self._rate)
        begun = np.concatenate([held.samples for held in self._held], axis=1)
        self._append(begun[:, self._unheard :])
        self._held.clear()

    def _resolve(self, clock: SampleClock) -> None:
        """Let go of what is held, after zeros for what is missing or without what zeros stand for already."""
        if not self._held:
            return
        off = round(self._earliest * self._rate)
        if self._earliest > LATE:
            clock.coast(self._end)
            self._zeros(off)
        surplus = min(max(-off, 0), self._owed)
        for piece in self._held:
            cut = min(surplus, piece.samples.shape[1])
            surplus -= cut
            self._append(piece.samples[:, cut:])
            clock.observe(self._end, piece.arrived)
        self._held.clear()
        self._earliest, self._owed = math.inf, 0

    def _append(self, samples: Samples) -> None:
        if samples.shape[1]:
            self._ready.append(samples)
            self._end += samples.shape[1]

    def _zeros(self, n: int) -> None:
        if n > 0:
            self._ready.append(n)
            self._end += n
            self.missing += n
