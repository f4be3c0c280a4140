"""How fast simulated time goes: as asked for, and in real time while somebody listens."""

from __future__ import annotations

import math
from collections.abc import Callable

from ross_payload.clock import SystemClock
from ross_payload.interfaces import Input
from ross_payload.streams import StreamStatus
from ross_sim.paced_clock import Pacer
from ross_sim.sitl.mission_view import MissionView


class ListenedSpeed:
    """A `Speed`: as asked for, and 1 while a stream is on.

    Parameters
    ----------
    speed
        Times real time; None: as fast as the computer can, in lock-step, where no file is written too slowly.

    Attributes
    ----------
    streams
        Tells how the streams are; to be set when there are any.
    """

    def __init__(self, speed: float | None) -> None:
        self._speed = math.inf if speed is None else speed
        self.streams: Callable[[], tuple[StreamStatus, ...]] = tuple

    @property
    def listened(self) -> bool:
        """Whether a stream is on that needs real time."""
        lockstep = math.isinf(self._speed)
        return any(stream.on and not (lockstep and stream.keeps) for stream in self.streams())

    def __call__(self) -> float:
        """Return it."""
        return 1.0 if self.listened else self._speed


def speed_words(speed: float | None) -> str:
    """Say how fast simulated time goes to who may listen; empty where that is as expected.

    >>> speed_words(4.0)
    'Simulated time runs at 4 times real time, and at real time while a stream is on.'
    >>> speed_words(1.0)
    ''
    """
    if speed == 1:
        return ""
    how = "as fast as this computer can" if speed is None else f"at {speed:g} times real time"
    return f"Simulated time runs {how}, and at real time while a stream is on."


class Pace(MissionView):
    """Holds a mission in lock-step back to a speed: it is an observer that waits."""

    def __init__(self, speed: Callable[[], float]) -> None:
        self._clock = SystemClock()
        self.pacer = Pacer(speed, self._clock)

    def on_input(self, hop: Input) -> None:
        """Wait until the hop would have begun."""
        delay = self.pacer.delay(hop.block.time)
        if delay > 0:
            self._clock.sleep(delay)
