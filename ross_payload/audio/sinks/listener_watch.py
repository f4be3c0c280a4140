"""Whether anybody takes what is sent over RTP: told by the reports that come back, and by the system that refuses.

Three things say that nobody does: the listener reports no more, though it did; it has said goodbye; or packets are
refused (ICMP: no receiver at this port, no such computer). A player that never says a word, and is not refused, may
listen. For how long nobody has to is what RFC 3550 has for participants, `ross_payload.streams.LISTENER_TIMEOUT_S`.
"""

from __future__ import annotations

import math

REFUSED_S = 3.0  # after the system said that nobody listens there, it still holds: it does not say so of every packet
LISTENS_S = 5.0  # after a listener's report, it still listens
PAUSE_S = 2.0  # without packets, in which nobody can be expected to report


class ListenerWatch:
    """Of one address; times are those of a monotonic clock [s]."""

    def __init__(self) -> None:
        self._sent_at = self._refused_at = -math.inf
        self._flowing_since = self._refused_since = -math.inf
        self._reported_at: float | None = None
        self._left = False

    def sent(self, now: float) -> None:
        """Note that a packet was sent."""
        if now > self._sent_at + PAUSE_S:
            self._flowing_since = now
        self._sent_at = now

    def refused(self, now: float) -> None:
        """Note that the system refuses packets."""
        if now > self._refused_at + REFUSED_S:
            self._refused_since = now
        self._refused_at = now

    def reported(self, now: float) -> None:
        """Note a report of the listener."""
        self._reported_at, self._left = now, False

    def left(self, now: float) -> None:
        """Note that the listener said goodbye."""
        self._reported_at, self._left = now, True

    def is_refused(self, now: float) -> bool:
        """Whether packets are refused at present."""
        return now < self._refused_at + REFUSED_S

    def reports(self, now: float) -> bool:
        """Whether a listener reports at present."""
        return self._reported_at is not None and not self._left and now < self._reported_at + LISTENS_S

    def may_listen(self, now: float) -> bool:
        """Whether somebody listens, or may without a word."""
        return self.reports(now) or not self.is_refused(now)

    def unheard(self, now: float) -> float:
        """Return for how long nobody has taken what was sent [s]; 0 while somebody does, or may, or nothing is sent.

        >>> watch = ListenerWatch()
        >>> for at in range(10):
        ...     watch.sent(at)
        ...     watch.refused(at)
        >>> watch.unheard(9.5)
        9.5
        """
        if self.reports(now) or now > self._sent_at + PAUSE_S:
            return 0.0
        signs = [self._refused_since] if self.is_refused(now) else []
        signs += [] if self._reported_at is None else [self._reported_at]
        return max(now - max(min(signs), self._flowing_since), 0.0) if signs else 0.0
