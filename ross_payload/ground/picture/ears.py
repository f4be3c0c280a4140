"""What is remembered of one component to understand its next packet."""

from __future__ import annotations

from collections import deque
from copy import deepcopy
from dataclasses import dataclass, field

from ross_payload.ground.picture.texts import Texts
from ross_protocols.values import Status

NEAR = 32  # frames missing in a row are lost; more are the numbers of another link, or a link that was down
WAYS = 4  # links that one component may be heard on, each with numbers of its own
BACKWARD = 1.0  # [s] by which a payload's time goes back when it has started anew
TWIN_SPAN, TWIN_TIMES = 10.0, 3  # so many steps back within so many seconds [s] are two payloads, not restarts
SPAN = 60  # seconds for which it is remembered in which of them somebody was heard
_ALL = (1 << SPAN) - 1


@dataclass(slots=True)
class Presence:
    """In which of the last seconds a component was heard.

    >>> presence = Presence()
    >>> [presence.heard(at) for at in (5.0, 5.9, 6.1, 20.0)]
    [True, False, True, True]
    >>> presence.seconds(20.0), presence.seconds(70.0), presence.seconds(90.0)
    (3, 1, 0)
    """

    _latest: int = 0  # second
    _heard: int = 0  # one bit for each second, the latest one lowest

    def heard(self, at: float) -> bool:
        """Learn that it is heard at a time [s]; return whether it is the first time in that second."""
        second = int(at)
        if self._heard and second <= self._latest:
            return False
        self._heard, self._latest = self._shifted(second) | 1, second
        return True

    def seconds(self, now: float) -> int:
        """Return in how many of the last `SPAN` seconds it was heard."""
        return self._shifted(int(now)).bit_count()

    def _shifted(self, second: int) -> int:
        return self._heard << min(max(second - self._latest, 0), SPAN) & _ALL


@dataclass(slots=True)
class Ear:
    """One component's."""

    frame: bytes = b""  # its latest
    heads: list[int] = field(default_factory=list)  # latest sequence number of every way, the latest way last
    status: Status | None = None  # its latest
    backs: deque[float] = field(default_factory=lambda: deque(maxlen=TWIN_TIMES))  # when its time went back [s]
    twin_at: float = -1e9  # when two senders of its id were noticed last [s]
    texts: Texts = field(default_factory=Texts)
    presence: Presence = field(default_factory=Presence)

    def copy(self) -> Ear:
        """Return another one that remembers the same."""
        return deepcopy(self)

    def missing(self, sequence: int) -> int:
        """Return how many frames are missing before one with this number.

        >>> ear = Ear()
        >>> [ear.missing(number) for number in (254, 255, 1, 100, 2, 103)]
        [0, 0, 1, 0, 0, 2]
        """
        ahead = [(sequence - head) % 256 for head in self.heads]
        if any(256 - gap < NEAR or not gap for gap in ahead):
            return 0  # late, or doubled
        gap = min(ahead, default=256)
        if gap <= NEAR:
            del self.heads[ahead.index(gap)]
        self.heads = [*self.heads, sequence][-WAYS:]
        return gap - 1 if gap <= NEAR else 0

    def went_back(self, status: Status, at: float) -> bool:
        """Whether a status is of a time before the latest one: its time stamp, or the audio that was heard."""
        before, self.status = self.status, status
        if before is None:
            return False
        stamped = (before.time_usec - status.time_usec) / 1e6 if before.time_unix == status.time_unix else 0.0
        back = max(stamped, before.mission_time - status.mission_time) > BACKWARD
        if back:
            self.backs.append(at)
        return back

    def is_twin(self, at: float) -> bool:
        """Whether time went back so often that two must be speaking."""
        return len(self.backs) == TWIN_TIMES and at - self.backs[0] < TWIN_SPAN
