"""When a packet is played: late enough for nearly all of them, no later; and how this moves with the clocks.

A *lead* is a timestamp minus the time [s]: of a packet when it arrives, of the sample to be played next when samples
are taken. Both fall or rise together when the clocks of the two computers differ, and so do their quantiles: what
follows the arrivals compensates drift, and adapts to the network, by the same rule.
"""

from __future__ import annotations

from collections import deque

import numpy as np

KEPT = 400  # arrivals that are looked at: 8 s of packets of 20 ms
FEWEST = 10  # before anything is concluded
TOO_LATE = 0.005  # share of packets that may come too late, adaptive
SAFETY_MARGIN_S = 0.005  # [s] by which the others come earlier than needed
INITIAL_DELAY_S = 0.06  # delay before anything is known, adaptive [s]
MAX_DELAY_S = 0.5  # [s]
EARLY, LATE = 0.003, 0.008  # errors that are left, adaptive: playing too early, playing too late [s]
TOLERANCE_S = 0.01  # either way, from a fixed delay: the median of few arrivals moves, too [s]
TAKEN = 25  # times that samples were taken which are looked at


class PlayoutDelay:
    """Decides how long packets wait.

    Parameters
    ----------
    fixed
        How long a packet of median delay waits [s]; 0: as short as the arrivals allow.
    """

    def __init__(self, fixed: float = 0.0) -> None:
        self._fixed = fixed
        self._arrivals: deque[float] = deque(maxlen=KEPT)
        self._taken: deque[float] = deque(maxlen=TAKEN)

    @property
    def first(self) -> float:
        """How long the first packet waits [s]."""
        return self._fixed or INITIAL_DELAY_S

    def arrived(self, lead: float) -> None:
        """Note the lead of a packet that came [s]."""
        self._arrivals.append(lead)

    def taken(self, lead: float) -> None:
        """Note the lead of the sample that is to be played next, after some were taken [s]."""
        self._taken.append(lead)

    def shifted(self, change: float) -> None:
        """Note that so much sound was put in, or below 0 left out, before what is to be played [s]."""
        self._taken = deque((lead - change for lead in self._taken), TAKEN)

    def correction(self) -> float:
        """Return how much sound is to be put in, or below 0 to be left out [s]; 0 while it is good as it is."""
        if len(self._arrivals) < FEWEST or len(self._taken) < FEWEST:
            return 0.0
        error = max(self._taken) - self._wanted()
        early, late = (TOLERANCE_S, TOLERANCE_S) if self._fixed else (EARLY, LATE)
        return error if error > early or error < -late else 0.0

    @property
    def delay(self) -> float:
        """How long a packet of median delay waits [s]."""
        if not self._arrivals or not self._taken:
            return self.first
        return float(np.median(self._arrivals)) - max(self._taken)

    def _wanted(self) -> float:
        arrivals = np.array(self._arrivals)
        middle = float(np.median(arrivals))
        if self._fixed:
            return middle - self._fixed
        return max(float(np.quantile(arrivals, TOO_LATE)) - SAFETY_MARGIN_S, middle - MAX_DELAY_S)
