"""A switch that a cam on the array closes near its home."""

from __future__ import annotations

import math

from ross_payload.actuators.tb6600.pulses import Level, Line


class HomeSwitch:
    """Closed while the array is within the cam, with hysteresis; chatters when it changes.

    Parameters
    ----------
    closes : float
        Joint angle at which it closes, turning towards it [rad].
    sign : int
        Of the direction in which it is approached: +1 counter-clockwise.
    high : bool
        Level of the line while it is closed.
    bounce : float
        How long it chatters [s].
    width : float
        Of the cam [rad]: half a disc and a little tells on which side the array stands.
    """

    HYSTERESIS = math.radians(0.3)

    def __init__(
        self, closes: float, sign: int, *, high: bool = False, bounce: float = 0.0, width: float = math.radians(190)
    ) -> None:
        self._closes, self._sign, self._high, self._bounce, self._width = closes, sign, high, bounce, width
        self._closed = False
        self._changed = -math.inf
        self._shown = False

    def look(self, angle: float, now: float) -> Level:
        """Return the level of its line with the array at ``angle`` [rad]; a chatter alternates from look to look."""
        within = self._sign * (angle - self._closes)
        slack = self.HYSTERESIS if self._closed else 0.0
        closed = -slack <= within <= self._width + slack
        if closed != self._closed:
            self._closed, self._changed = closed, now
        self._shown = not self._shown if now - self._changed < self._bounce else closed
        return Level(Line.HOME, self._shown == self._high, now)
