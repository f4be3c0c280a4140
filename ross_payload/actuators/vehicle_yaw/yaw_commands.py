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

    def missing(self) -> str:
        """Say what must be known before it can be turned; empty when nothing is missing."""

    def begin(self) -> list[Any]:
        """Return what comes before the first set-point of a turn."""

    def point(self, yaw: float, rate: float, now: float) -> Any:
        """Return the set-point for a yaw [rad], to be reached at ``rate`` [rad/s]."""

    def stop(self, yaw: float, now: float) -> Any:
        """Return what ends a turn: the autopilot holds its yaw, about at ``yaw`` [rad]."""


@dataclass(slots=True)
class GuidedYaw:
    """ArduCopter in GUIDED: CONDITION_YAW, which leaves position and height to whoever guides the vehicle."""

    watch: FlightWatch
    period: float = 0.1
    streams: bool = False

    def missing(self) -> str:
        """Say nothing: it needs nothing."""
        return ""

    def begin(self) -> list[Any]:
        """Hold first: only a relative turn begins where the vehicle points, whatever steered its yaw before."""
        return [vehicle_control.hold_yaw(_whom(self.watch))]

    def point(self, yaw: float, rate: float, now: float) -> Any:
        """Return the turn to a yaw."""
        return vehicle_control.turn_to(_whom(self.watch), yaw, max(HASTE * rate, LEAST_RATE))

    def stop(self, yaw: float, now: float) -> Any:
        """Hold the yaw that its turn has come to."""
        return vehicle_control.hold_yaw(_whom(self.watch))


@dataclass(slots=True)
class HoldYaw:
    """PX4 in Hold: DO_REPOSITION with a yaw, at the altitude at which the turn began."""

    watch: FlightWatch
    period: float = 0.2
    streams: bool = False
    _altitude: float = math.nan

    def missing(self) -> str:
        """Say that the altitude must be known."""
        return (
            "" if self.watch.position is not None else "the autopilot does not tell where it is (GLOBAL_POSITION_INT)"
        )

    def begin(self) -> list[Any]:
        """Keep the altitude."""
        position = self.watch.position
        self._altitude = math.nan if position is None else position.height
        return []

    def point(self, yaw: float, rate: float, now: float) -> Any:
        """Return the turn to a yaw; PX4 has a rate of its own, MPC_YAWRAUTO_MAX."""
        return vehicle_control.reposition(_whom(self.watch), yaw, self._altitude)

    def stop(self, yaw: float, now: float) -> Any:
        """Turn to where it can stop."""
        return self.point(yaw, 0.0, now)


@dataclass(slots=True)
class OffboardYaw:
    """PX4 in Offboard: a stream of a place and a yaw; the place is that where Offboard began."""

    watch: FlightWatch
    period: float = 0.05
    streams: bool = True
    _place: Place | None = None

    def missing(self) -> str:
        """Say that the place must be known."""
        return "" if self.watch.place is not None else "the autopilot does not tell where it is (LOCAL_POSITION_NED)"

    def begin(self) -> list[Any]:
        """Need nothing: the stream goes on."""
        return []

    def point(self, yaw: float, rate: float, now: float) -> Any:
        """Return a place and a yaw; before Offboard the place is wherever the vehicle is."""
        if self.watch.mode != vehicle_control.OFFBOARD or self._place is None:
            self._place = self.watch.place
        return vehicle_control.position_target(_whom(self.watch), now, self._place or (0.0, 0.0, 0.0), yaw)

    def stop(self, yaw: float, now: float) -> Any:
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
