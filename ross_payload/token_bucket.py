"""How much may be done, whoever asks for it: a bucket of tokens that fills at a steady rate."""

from __future__ import annotations


class TokenBucket:
    """Gives ``burst`` tokens at once, and ``rate`` [1/s] in the long run; it begins full.

    >>> bucket = TokenBucket(burst=500, rate=1000)
    >>> bucket.spend(0.0, 400), bucket.spend(0.0, 400), bucket.tokens(0.2)
    (True, False, 300.0)
    """

    def __init__(self, burst: float, rate: float) -> None:
        self.rate = rate  # infinite: there is always room
        self.burst = self._tokens = burst
        self._filled: float | None = None  # when it was filled up last [s]

    def tokens(self, now: float) -> float:
        """Return how many tokens there are at ``now`` [s]."""
        if self._filled is not None and now > self._filled:
            self._tokens = min(self._tokens + (now - self._filled) * self.rate, self.burst)
        self._filled = now
        return self._tokens

    def spend(self, now: float, tokens: float = 1.0) -> bool:
        """Spend ``tokens`` at ``now`` [s] if there are so many; tell whether there were."""
        if self.tokens(now) < tokens:
            return False
        self._tokens -= tokens
        return True
