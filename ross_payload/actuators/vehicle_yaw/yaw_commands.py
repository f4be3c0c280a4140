"""How an autopilot is told to yaw: one way for each autopilot and mode, the same three words for the driver."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Protocol

from ross_payload.actuators.vehicle_yaw.flight_watch import FlightWatch, Place
from ross_protocols.mavlink import vehicle_control
from ross_protocols.mavlink.vehicle_control import ARDUPILOT

HASTE = 1.1  # times the rate of the plan: the autopilot is at a set-point when the next one comes
LEAST_RATE = math.radians(2)  # CONDITION_YAW takes no rate for its default [rad/s]


class YawCommands(Protocol):
    """The messages that turn one kind of autopilot."""

    period: float  # between set-points while it turns [s]
    streams: bool  # whether set-points must go on for ever, also at rest
    confirmed: bool  # whether a turn may begin only when the autopilot has acknowledged what comes before it

    def look(self, now: float) -> None:
        """Take in where the vehicle is; called before anything else is asked."""

    def missing(self, now: float) -> str:
        """Say what must be known before it can be turned; empty when nothing is missing."""

    def begin(self, now: float) -> list[Any]:
        """Return what comes before the first set-point of a turn."""

    def point(self, yaw: float, rate: float, now: float) -> list[Any]:
        """Return the set-point for a yaw [rad], to be reached at ``rate`` [rad/s]; none while something is missing."""

    def stop(self, yaw: float, now: float) -> list[Any]:
        """Return what ends a turn: the autopilot holds its yaw, about at ``yaw`` [rad]."""


@dataclass(slots=True)
class GuidedYaw:
    """ArduCopter in GUIDED: CONDITION_YAW, which leaves position and height to whoever guides the vehicle."""

    watch: FlightWatch
    period: float = 0.1
    streams: bool = False
    confirmed: bool = True

    def look(self, now: float) -> None:
        """Need no place: whoever guides the vehicle knows it."""

    def missing(self, now: float) -> str:
        """Say nothing: it needs nothing."""
        return ""

    def begin(self, now: float) -> list[Any]:
        """Hold first: only a relative turn begins where the vehicle points, whatever steered its yaw before.

        An absolute one without it begins at the heading of an earlier turn, anywhere, and no stop would end it there.
        """
        return [vehicle_control.hold_yaw(_whom(self.watch))]

    def point(self, yaw: float, rate: float, now: float) -> list[Any]:
        """Return the turn to a yaw."""
        return [vehicle_control.turn_to(_whom(self.watch), yaw, max(HASTE * rate, LEAST_RATE))]

    def stop(self, yaw: float, now: float) -> list[Any]:
        """Hold the yaw that its turn has come to."""
        return [vehicle_control.hold_yaw(_whom(self.watch))]


@dataclass(slots=True)
class HoldYaw:
    """PX4 in Hold: DO_REPOSITION with a yaw, at the altitude at which the turn began."""

    watch: FlightWatch
    period: float = 0.2
    streams: bool = False
    confirmed: bool = False
    _altitude: float = math.nan

    def look(self, now: float) -> None:
        """Need no place before a turn begins."""

    def missing(self, now: float) -> str:
        """Say that the altitude must be known, as it is now."""
        told = self.watch.position_at(now) is not None
        return "" if told else "the autopilot does not tell where it is (GLOBAL_POSITION_INT)"

    def begin(self, now: float) -> list[Any]:
        """Keep the altitude."""
        position = self.watch.position_at(now)
        self._altitude = math.nan if position is None else position.height
        return []

    def point(self, yaw: float, rate: float, now: float) -> list[Any]:
        """Return the turn to a yaw; PX4 has a rate of its own, MPC_YAWRAUTO_MAX."""
        return [vehicle_control.reposition(_whom(self.watch), yaw, self._altitude)]

    def stop(self, yaw: float, now: float) -> list[Any]:
        """Turn to where it can stop."""
        return self.point(yaw, 0.0, now)


@dataclass(slots=True)
class OffboardYaw:
    """PX4 in Offboard: a stream of a place and a yaw; the place is that in the air where Offboard began.

    Offboard that began without it is somebody else's: then there is no place, and no stream. Nor is there one on the
    ground: where its height wanders an armed PX4 is soon below its place, and would take off.
    """

    watch: FlightWatch
    period: float = 0.05
    streams: bool = True
    confirmed: bool = False
    _place: Place | None = None

    def look(self, now: float) -> None:
        """Before Offboard the place is wherever the vehicle flies; in it that stays."""
        if self.watch.mode != vehicle_control.OFFBOARD:
            self._place = self.watch.place_at(now) if self.watch.flies(now) else None

    def missing(self, now: float) -> str:
        """Say that the place must be known, and before Offboard begins."""
        if self._place is not None:
            return ""
        if self.watch.mode == vehicle_control.OFFBOARD:
            return (
                "Offboard began before the place was known, or for another program, or on the ground:"
                " leave it, and choose it again in the air"
            )
        return "the autopilot does not tell where it is (LOCAL_POSITION_NED)"

    def begin(self, now: float) -> list[Any]:
        """Need nothing: the stream goes on."""
        return []

    def point(self, yaw: float, rate: float, now: float) -> list[Any]:
        """Return a place and a yaw."""
        whom, place = _whom(self.watch), self._place
        return [] if place is None else [vehicle_control.position_target(whom, now, place, yaw)]

    def stop(self, yaw: float, now: float) -> list[Any]:
        """Stay, at a yaw."""
        return self.point(yaw, 0.0, now)


def commands_of(watch: FlightWatch) -> YawCommands | None:
    """Return how the autopilot that was heard is turned; None: there is none that can be."""
    if watch.missing():
        return None
    if watch.kind == ARDUPILOT:
        return GuidedYaw(watch)
    return OffboardYaw(watch) if watch.options.px4_mode == "offboard" else HoldYaw(watch)


def _whom(watch: FlightWatch) -> Any:
    return watch.whom
