"""What the clock in a gimbal's reports tells: which are news, how late they come, who has restarted, who is two."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

RESTART = 1.0  # [s] by which a clock goes back when its device has restarted
LASTING = 1.0  # [s] in which clashes count together
CLASHES = 3  # between two clocks, until they are no accident
DRIFT = 1e-3  # by which two clocks may go apart [s/s]


class Verdict(Enum):
    """What a report is, as its clock tells."""

    NEWS = "news"
    OLD = "old"  # it proves nothing
    RESTARTED = "restarted"  # news of a device that has booted
    TWO = "two"  # two devices report under one name


@dataclass(slots=True)
class SenderClock:
    """Follows the clock of one sender.

    A clock that has gone back is believed when the next report confirms it; when the next one goes on as before,
    somebody else reports under the same name.

    >>> clock = SenderClock()
    >>> [clock.judge(boot, 0.02 * n).value for n, boot in enumerate((50.0, 50.02, 50.02, 0.1, 0.12))]
    ['news', 'news', 'old', 'old', 'restarted']
    """

    _latest: float = -math.inf  # [s]
    _other: float | None = None  # a clock that went back, not confirmed yet [s]
    _clashes: int = 0
    _clash: float = -math.inf  # when the last one was [s]
    _way: float = math.inf  # the least between making and arrival, on two clocks [s]
    _heard: float = 0.0  # when that was judged last [s]

    def judge(self, boot: float, now: float) -> Verdict:
        """Judge a report made at ``boot`` on its own clock [s] that arrives at ``now`` [s]."""
        if boot < self._latest - RESTART:
            if self._other is None or not self._other < boot < self._other + RESTART:
                self._other = boot
                return Verdict.OLD
            self._latest, self._other, self._way = boot, None, math.inf
            return Verdict.RESTARTED
        if boot <= self._latest:
            return Verdict.OLD
        clashing, self._other, self._latest = self._other is not None, None, boot
        return Verdict.TWO if clashing and self._clashed(now) else Verdict.NEWS

    def lateness(self, boot: float, now: float) -> float:
        """Return by how much longer than the fastest a report was on its way [s]."""
        way = now - boot
        self._way = min(way, self._way + DRIFT * (now - self._heard))
        self._heard = now
        return way - self._way

    def _clashed(self, now: float) -> bool:
        self._clashes = self._clashes + 1 if now - self._clash < LASTING else 1
        self._clash = now
        return self._clashes >= CLASHES
