"""What a driver is asked for: left by any thread, obeyed by the pump."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from queue import Empty, SimpleQueue

from ross_payload.actuators.motion import Trapezoid


@dataclass(frozen=True, slots=True)
class Move:
    """Go to an angle."""

    goal: float  # [rad]
    rate: float  # [rad/s]


class Ask(Enum):
    """Requests without arguments."""

    HALT = "halt"
    HOME = "home"
    RELEASE = "release"
    TAKE_CONTROL = "take control"
    RELEASE_CONTROL = "release control"
    BRAKE = "decelerate a motion of another controller"


class Requests:
    """Requests in the order in which they came.

    >>> requests = Requests()
    >>> requests.put(Move(1.0, 0.5))
    >>> requests.put(Ask.HALT)
    >>> [*requests.taken()], requests.empty
    ([Move(goal=1.0, rate=0.5), <Ask.HALT: 'halt'>], True)
    """

    def __init__(self) -> None:
        self._queue: SimpleQueue[Move | Ask] = SimpleQueue()

    @property
    def empty(self) -> bool:
        """Whether none waits."""
        return self._queue.empty()

    def put(self, request: Move | Ask) -> None:
        """Leave a request; from any thread."""
        self._queue.put(request)

    def taken(self) -> Iterator[Move | Ask]:
        """Take out one after the other until none waits."""
        while True:
            try:
                yield self._queue.get_nowait()
            except Empty:
                return


@dataclass(frozen=True, slots=True)
class Motion:
    """A plan and when it begins [s]."""

    plan: Trapezoid
    begin: float

    @property
    def end(self) -> float:
        """When it is over [s]."""
        return self.begin + self.plan.duration

    def at(self, time: float) -> tuple[float, float]:
        """Position [rad] and velocity [rad/s] at ``time`` [s]."""
        return self.plan.at(time - self.begin)
