"""Finding a home switch: a procedure that sees the switch and says how to move.

Fast towards the switch until it closes, stop, back until it is open, stop, slowly towards it again: where it closes
then is the place. One that is closed at the start is backed off first.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator
from dataclasses import dataclass

from ross_payload.actuators.driver_shell import Move, Request
from ross_payload.actuators.tb6600.pulse_segments import Level
from ross_payload.errors import ActuatorFault

DEBOUNCE_S = 0.015  # a level that stays for so long is no bounce [s]
SWITCH_TIMEOUT_S = 0.5  # of the wire about its switch, at most [s]
MEASURING_SHARE = 0.1  # of the search's speed, to measure


@dataclass(frozen=True, slots=True)
class SearchOptions:
    """Where and how to look."""

    sign: int  # +1 counter-clockwise, -1 clockwise
    speed: float  # [rad/s]
    travel: float  # no farther [rad]


@dataclass(frozen=True, slots=True)
class SwitchView:
    """What is known at one moment; angles are the driver's, whose zero means nothing yet."""

    closed: bool  # the switch, bounces taken out
    closed_at: float  # angle where that began, at the first contact [rad]
    angle: float  # [rad]
    still: bool


class Debouncer:
    """Takes the bounces out of a switch: believes a level that has stayed for 15 ms, since it began.

    >>> debouncer = Debouncer()
    >>> [debouncer.update(closed, time) for closed, time in [(False, 0.0), (True, 1.0), (False, 1.01), (True, 1.02)]]
    [False, False, False, False]
    >>> debouncer.update(True, 1.04), debouncer.since
    (True, 1.02)
    """

    def __init__(self) -> None:
        self._level: bool | None = None  # None: nothing believed yet
        self._latest = False
        self._began = math.nan
        self.since = math.nan  # the beginning of what is believed [s]

    @property
    def known(self) -> bool:
        """Whether any level has stayed long enough."""
        return self._level is not None

    def update(self, closed: bool, time: float) -> bool:
        """Take in a level at ``time`` [s]; whether the switch is closed, as far as is known."""
        if closed != self._latest or math.isnan(self._began):
            self._latest, self._began = closed, time
        if closed != self._level and time - self._began >= DEBOUNCE_S:
            self._level, self.since = closed, self._began
        return bool(self._level)


Homing = Generator[Move | Request | None, SwitchView, float]


def homing(search: SearchOptions) -> Homing:
    """Find the switch: yields what to do (None: go on so), is sent what is seen, returns where it closes [rad].

    Raises
    ------
    ActuatorFault
        When the switch does not close, or does not open, within the travel.
    """
    sight = yield None
    if sight.closed:
        sight = yield from _until(False, sight, search, -search.sign, search.speed)
    sight = yield from _until(True, sight, search, search.sign, search.speed)
    sight = yield from _until(False, sight, search, -search.sign, search.speed)
    sight = yield from _until(True, sight, search, search.sign, search.speed * MEASURING_SHARE)
    return sight.closed_at


def _until(
    closed: bool, sight: SwitchView, search: SearchOptions, sign: int, speed: float
) -> Generator[Move | Request | None, SwitchView, SwitchView]:
    """Turn until the switch is closed, or open, and stop; what was seen when it became so."""
    sight = yield Move(sight.angle + sign * search.travel, speed)
    while sight.closed != closed:
        if sight.still:
            found = "stays open" if closed else "stays closed"
            raise ActuatorFault(f"the home switch {found} over {math.degrees(search.travel):g} deg")
        sight = yield None
    seen, sight = sight, (yield Request.HALT)
    while not sight.still:
        sight = yield None
    return SwitchView(seen.closed, seen.closed_at, sight.angle, still=True)


class SwitchSearch:
    """Runs the procedure on what the wire reports of its switch.

    Parameters
    ----------
    search : SearchOptions
        Where and how to look.
    closed : bool
        Level of the line while the switch is closed.
    """

    def __init__(self, search: SearchOptions, closed: bool) -> None:
        self._search = search
        self._level = closed
        self._debouncer = Debouncer()
        self._closed = False
        self._reported_at = -math.inf  # last report [s]
        self._procedure: Homing | None = None
        self.found: float | None = None  # where the switch closes [rad]

    @property
    def active(self) -> bool:
        """Whether it is looking."""
        return self._procedure is not None

    def update(self, report: Level) -> None:
        """Take in a report of the switch."""
        self._closed = self._debouncer.update(report.level == self._level, report.time)
        self._reported_at = report.time

    def begin(self, now: float) -> None:
        """Look for the switch from now on [s]."""
        self.found, self._debouncer, self._reported_at = None, Debouncer(), now
        self._procedure = homing(self._search)
        next(self._procedure)

    def end(self) -> None:
        """Look no more."""
        self._procedure = None

    def step(self, angle_at: Callable[[float], float], now: float, still: bool) -> Move | Request | None:
        """Say what to do at ``now`` [s]; None: go on so, or `found`.

        Raises
        ------
        ActuatorFault
            When the search fails or the wire does not tell of a switch.
        """
        if now - self._reported_at > SWITCH_TIMEOUT_S:
            raise ActuatorFault(f"no state of the home switch received for {now - self._reported_at:.2f} s")
        if self._procedure is None or not self._debouncer.known:
            return None
        try:
            return self._procedure.send(SwitchView(self._closed, angle_at(self._debouncer.since), angle_at(now), still))
        except StopIteration as result:
            self.found, self._procedure = result.value, None
            return None
