"""Makes one consecutive stream of what arrives: gaps become zeros, so that counting samples is counting time.

Drivers do not tell of gaps: a callback that was blocked raises no flag. They are found by counting frames against the
Clock. A piece that arrives late is held back until it is clear what it is: when later ones catch up, something on the
way was late and nothing is missing; when none is less late than those before for 0.3 s, the earliest tells how much is
missing before the first. Of what comes faster than it can be heard as much is left out, or time would run ahead.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from ross_payload.audio.ring import Piece
from ross_payload.audio.sample_clock import SampleClock
from ross_payload.interfaces import Samples

LATE_S = 0.040  # [s] behind the Clock: held back
CAUGHT_UP_S = 0.020  # [s] behind the Clock: nothing is missing
EARLY_S = 0.040  # [s] before it can have been heard: zeros stand for more than was missing
AHEAD_S = 0.5  # [s] before it can have been heard: what arrives is no sound in real time at this rate
DECISION_TIMEOUT_S = 0.3  # [s] until what does not catch up is a gap
CATCH_UP_S = 0.03  # [s] that later pieces are less late, within that time
HOLD_TIMEOUT_S = 1.5  # [s] that anything is held back
PAUSE_S = 0.1  # [s] without a look, or without a piece: something was held up, and now deserves patience
SILENCE_TIMEOUT_S = 0.5  # without a sample until zeros take their place
EXPECTED_S = 30.0  # [s] after the latest zeros, or the latest of what they stand for, in which that may still come
WARM_UP_S = 0.5  # [s] at the start, in which the clock is learnt


@dataclass(frozen=True, slots=True)
class Stretch:
    """Consecutive samples."""

    samples: Samples  # (2, n)
    time: float  # of the first, on the Clock [s]
    missing: int  # samples that never came, zeros in their place
    spliced: bool = False  # whether samples that came too fast were left out within, or right before


class GapFiller:
    """Takes pieces, gives consecutive samples; belongs to the reader.

    Parameters
    ----------
    rate
        Of what arrives [Hz].
    settling
        What nobody hears at the start [s], at most `WARM_UP_S`: sample 0 is the first after it.
    """

    def __init__(self, rate: int, settling: float = 0.0) -> None:
        self._rate = rate
        self._unheard = round(settling * rate)
        self._clock: SampleClock | None = None
        self._held: list[Piece] = []
        self._earliest = math.inf  # of those held: how late it is, were nothing missing [s]
        self._best = math.inf  # how late those held were when patience began [s]
        self._since = -math.inf  # when patience began [s]
        self._expected = 0  # frames offered so far
        self._ready: deque[Samples | int] = deque()  # samples, or how many zeros; none: where samples were left out
        self._index = 0  # of the next sample to give
        self._end = 0  # behind all that is ready
        self._owed = 0  # zeros given in advance while nothing came
        self._guessed = 0  # zeros for what may still come, late
        self._expected_until = -math.inf  # when that is not to be expected any more [s]
        self.missing = 0  # samples that never came, since the start
        self.left_out = 0  # samples that came faster than they can be heard, since the start

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
            self._guessed -= given
            size = piece.samples.shape[1]
            room = round((piece.arrived + AHEAD_S - self._clock.ahead(self._end)) * self._rate) - size
            replaced = min(refused - given, max(room, 0))
            self._zeros(replaced)
            self._leave_out(refused - given - replaced)
        if piece.arrived > self._expected_until:
            self._guessed = min(self._guessed, self._owed)  # what nothing has come instead of yet may still come
        self._hold(piece, self._clock)
        in_time = self._earliest < (LATE_S if len(self._held) == 1 else CAUGHT_UP_S)
        patient = (
            piece.arrived - self._since < DECISION_TIMEOUT_S and piece.arrived - self._held[0].arrived < HOLD_TIMEOUT_S
        )
        if in_time or not patient:
            self._resolve(self._clock)

    def wait(self, now: float, resumed: float = -math.inf) -> None:
        """Nothing more has arrived by ``now`` [s]: decide about what is held, and go on with zeros.

        The reader was held up until ``resumed`` [s]: so may have been what hears, and silence counts only from there.
        """
        if self._clock is None:
            return
        if self._held and now - max(self._since, resumed) >= DECISION_TIMEOUT_S:
            self._resolve(self._clock)
        silent = round((now - SILENCE_TIMEOUT_S - self._clock.ahead(self._end)) * self._rate)
        patient = not self._owed and now - resumed < SILENCE_TIMEOUT_S
        if not self._held and silent > 0 and not patient:
            if not self._owed:
                self._clock.coast(self._end)
            self._owed += silent
            self._guess(silent, now)

    def read(self, n: int) -> Stretch:
        """Give the next ``n`` samples; there must be as many."""
        if self._clock is None or self.available < n:
            raise ValueError(f"expected a request for at most {self.available} samples, got {n}")
        samples, missing = np.zeros((2, n), np.float32), 0
        done, spliced = 0, False
        while done < n:
            head = self._ready.popleft()
            size = head if isinstance(head, int) else head.shape[1]
            spliced = spliced or size == 0
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
        return Stretch(samples, time, missing, spliced)

    def _warm_up(self, piece: Piece) -> None:
        self._held.append(piece)
        if piece.arrived - self._held[0].arrived < WARM_UP_S:
            return
        end, earliest = 0, math.inf
        for held in self._held:
            end += held.samples.shape[1]
            earliest = min(earliest, held.arrived - end / self._rate)
        self._clock = SampleClock(self._rate, earliest + self._unheard / self._rate)
        begun = np.concatenate([held.samples for held in self._held], axis=1)
        self._append(begun[:, self._unheard :])
        self._held.clear()

    def _hold(self, piece: Piece, clock: SampleClock) -> None:
        began = piece.arrived - (self._held[-1].arrived if self._held else -math.inf) > PAUSE_S
        self._held.append(piece)
        late = piece.arrived - clock.ahead(self._end - self._owed + self.held)
        self._earliest = min(self._earliest, late)
        if began or late < self._best - CATCH_UP_S:
            self._since, self._best = piece.arrived, late

    def _resolve(self, clock: SampleClock) -> None:
        """Let go of what is held, after zeros for what is missing and without what zeros stand for already."""
        if not self._held:
            return
        gap = round(self._earliest * self._rate) if self._earliest > LATE_S else 0
        if gap > self._owed:
            clock.coast(self._end)
        now = self._held[-1].arrived
        self._guess(gap - self._owed, now)
        early = round(-self._earliest * self._rate) if self._earliest < -EARLY_S else 0
        too_fast = self._earliest < -AHEAD_S
        surplus = max(self._owed - gap, 0) + (early if too_fast else min(early, self._guessed))
        for piece in self._held:
            cut = min(surplus, piece.samples.shape[1])
            surplus -= cut
            taken_back = min(cut, self._guessed)
            self._guessed -= taken_back
            if taken_back:
                self._expected_until = now + EXPECTED_S
            self._leave_out(cut - taken_back)
            self._append(piece.samples[:, cut:])
        if len(self._held) == 1:
            clock.observe(self._end, self._held[0].arrived)
        else:
            clock.ignore(self._end)
        self._held.clear()
        self._earliest, self._best, self._owed = math.inf, math.inf, surplus

    def _append(self, samples: Samples) -> None:
        if samples.shape[1]:
            self._ready.append(samples)
            self._end += samples.shape[1]

    def _leave_out(self, n: int) -> None:
        if n > 0:
            self._ready.append(0)
            self.left_out += n

    def _guess(self, n: int, now: float) -> None:
        if n > 0:
            self._guessed += n
            self._expected_until = now + EXPECTED_S
            self._zeros(n)

    def _zeros(self, n: int) -> None:
        if n > 0:
            self._ready.append(n)
            self._end += n
            self.missing += n
