"""What the frames of a bus give away beside what they say: two nodes with one id, damage, a full bus, a bad encoder."""

from __future__ import annotations

import math
from collections import Counter, deque
from itertools import pairwise

TRANSFER_IDS = 32  # transfers are counted modulo this
WINDOW_S = 0.5  # in which damage and traffic are judged [s]
MAX_DAMAGED = 6  # transfers in a window
FULL_BUS_FRAMES_S = 3000.0  # frames a second: what a bus at 500 kbit/s takes, and half of one at 1 Mbit/s
LATE_REPORT_S = 0.3  # without a report on a full bus [s]
TURNING_POINTS, OF_PAIRS = 4, 10  # by which it is judged whether a position trembles
MAX_NOISE_RAD = math.radians(0.3)  # of a bad encoder: at rest a good one stands still, in a move it goes one way [rad]


class DuplicateIdDetector:
    """Notices that two nodes count their messages under one id: their counts alternate.

    >>> duplicates = DuplicateIdDetector()
    >>> [duplicates.update(count) for count in (5, 20, 6, 21)]
    [False, False, False, True]
    """

    def __init__(self) -> None:
        self._counts: deque[int] = deque(maxlen=4)

    def update(self, count: int) -> bool:
        """Take the count of a message; tell whether two nodes have sent the last four."""
        self._counts.append(count)
        if len(self._counts) < 4:
            return False
        first, second, third, fourth = self._counts
        after = (first + 1) % TRANSFER_IDS
        return third == after != second and fourth == (second + 1) % TRANSFER_IDS


class PositionNoise:
    """Measures how a position trembles: the way back and forth [rad] that four of ten pairs of steps exceed.

    Steps are from report to report. Whatever goes one way does not tremble, be it in stairs.

    >>> noise = PositionNoise()
    >>> [round(noise.update(step % 2 + 0.1 * step, step), 1) for step in range(12)][-2:]
    [0.0, 0.9]
    """

    def __init__(self) -> None:
        self._joints: deque[float] = deque(maxlen=OF_PAIRS + 2)
        self._next = 0

    def update(self, joint: float, count: int) -> float:
        """Take a joint angle [rad] and the count of its report; a lost report starts again."""
        if count != self._next:
            self._joints.clear()
        self._next = (count + 1) % TRANSFER_IDS
        self._joints.append(joint)
        if len(self._joints) < OF_PAIRS + 2:
            return 0.0
        steps = [after - before for before, after in pairwise(self._joints)]
        ways = [min(abs(one), abs(other)) if one * other < 0 else 0.0 for one, other in pairwise(steps)]
        return sorted(ways)[-TURNING_POINTS]


class BusTraffic:
    """Counts the frames of the last half second, and those transfers of the servo that broke."""

    def __init__(self) -> None:
        self._frames: deque[tuple[float, Counter[int]]] = deque()
        self._breaks: deque[tuple[float, int]] = deque()

    def update(self, now: float, frames: Counter[int], broken: int) -> None:
        """Take the frames heard at ``now`` [s], by node, and how many of the servo's transfers have broken by then."""
        self._frames.append((now, frames))
        self._breaks.append((now, broken))
        while self._frames[0][0] <= now - WINDOW_S:
            self._frames.popleft()
        while self._breaks[0][0] < now - WINDOW_S:
            self._breaks.popleft()

    @property
    def damage(self) -> str:
        """That the servo's frames come damaged, in words."""
        broken = self._breaks[-1][1] - self._breaks[0][1]
        return f"{broken} reports of the servo came damaged in {WINDOW_S:g} s" if broken >= MAX_DAMAGED else ""

    @property
    def full(self) -> str:
        """That the bus is full, in words."""
        total: Counter[int] = Counter()
        for _, frames in self._frames:
            total.update(frames)
        rate = total.total() / WINDOW_S
        if rate < FULL_BUS_FRAMES_S:
            return ""
        node, _ = total.most_common(1)[0]
        return f"the bus is full: {rate:.0f} frames a second, most of them from node {node}"
