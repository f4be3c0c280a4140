"""What the clock in a gimbal's reports tells: which are news, how late they come, who has restarted, who is two."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

REORDER_S = 0.4  # [s]: what is no older than this may have come by a longer way, what is older is of another clock
MAX_LEAD_S = 1.0  # [s] by which a clock may be ahead of the time that has passed
CLASH_WINDOW_S = 1.0  # [s] in which clashes count together
MIN_CLASHES = 3  # between two clocks, until they are no accident
MAX_DRIFT = 1e-3  # by which two clocks may go apart [s/s]


class Verdict(Enum):
    """What a report is, as its clock tells."""

    NEWS = "news"
    OLD = "old"  # it proves nothing
    RESTARTED = "restarted"  # news of a device that has booted
    TWO = "two"  # two devices report under one name


@dataclass(frozen=True, slots=True)
class BootTime:
    """The latest report of one clock, and since when it has been looked out for."""

    boot: float  # on that clock [s]
    heard_at: float  # [s]
    since: float  # [s]

    def precedes(self, boot: float, now: float) -> bool:
        """Tell whether a report is a later one of the same clock."""
        return 0.0 < boot - self.boot <= now - self.heard_at + MAX_LEAD_S


@dataclass(slots=True)
class SenderClock:
    """Follows the clock of one sender.

    A report with another clock is believed when the next one goes on from there: the device has restarted. When the
    first clock goes on as well, two devices report under one name, and only the first is believed.

    >>> clock = SenderClock()
    >>> [clock.judge(boot, 0.02 * n).value for n, boot in enumerate((50.0, 50.02, 50.02, 0.1, 0.12))]
    ['news', 'news', 'old', 'old', 'restarted']
    """

    _latest: BootTime | None = None
    _other: BootTime | None = None
    _clashes: int = 0
    _clash: float = -math.inf  # when the last one was [s]
    _way: float = math.inf  # the least between making and arrival, on two clocks [s]
    _judged: float = 0.0  # when that was [s]

    def judge(self, boot: float, now: float) -> Verdict:
        """Judge a report made at ``boot`` on its own clock [s] that arrives at ``now`` [s]."""
        latest, other = self._latest, self._other
        if latest is None or latest.precedes(boot, now):
            self._latest = BootTime(boot, now, now)
            return Verdict.NEWS
        if -REORDER_S <= boot - latest.boot <= 0.0:
            return Verdict.OLD
        self._other = BootTime(boot, now, now)
        if other is None or not other.precedes(boot, now):
            return Verdict.OLD
        if latest.heard_at > other.since:  # the first clock goes on too
            return Verdict.TWO if self._clashed(now) else Verdict.OLD
        self._latest, self._other, self._way = self._other, BootTime(latest.boot, latest.heard_at, now), math.inf
        return Verdict.RESTARTED if boot < latest.boot else Verdict.NEWS

    def lateness(self, boot: float, now: float) -> float:
        """Return by how much longer than the fastest a report was on its way [s]."""
        way = now - boot
        self._way = min(way, self._way + MAX_DRIFT * (now - self._judged))
        self._judged = now
        return way - self._way

    def forget_lateness(self) -> None:
        """Call the next report as fast as any: its clock may have stood still, as that of a simulated device can."""
        self._way = math.inf

    def _clashed(self, now: float) -> bool:
        self._clashes = self._clashes + 1 if now - self._clash < CLASH_WINDOW_S else 1
        self._clash = now
        return self._clashes >= MIN_CLASHES
