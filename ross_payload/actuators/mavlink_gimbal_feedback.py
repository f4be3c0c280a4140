"""Where a MAVLink gimbal says it is, as a joint angle."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ross_payload.angles import wrap
from ross_protocols.gimbal import GimbalAttitude
from ross_protocols.vehicle import VehicleAttitude

FRESH = 0.5  # [s]: a vehicle's attitude that is older turns no yaw into a joint angle
RESTART = 1.0  # [s] by which a clock goes back when its device has restarted
LASTING = 1.0  # [s] after a report of the device itself in which its manager's are not needed


@dataclass(slots=True)
class GimbalFeedback:
    """The latest report. Yaws wrap, joint angles do not: each report continues the last one on the shorter way."""

    lower: float  # travel [rad]
    upper: float
    angle: float = 0.0  # joint angle [rad]
    rate: float = 0.0  # [rad/s]
    time: float = -math.inf  # of arrival [s]; minus infinity: none yet
    failures: int = 0  # flags
    restarted: bool = False  # since somebody looked
    lost_vehicle: bool = False  # a yaw from north came and nobody told where the vehicle points
    _boot: float = -math.inf  # of the last report, on the sender's clock [s]
    _own: float = -math.inf  # when the device itself reported last [s]
    _vehicle: tuple[float, VehicleAttitude] | None = None
    _known: bool = False  # a turn was chosen

    def turned(self, vehicle: VehicleAttitude, now: float) -> None:
        """Remember where the vehicle points."""
        self._vehicle = now, vehicle

    def report(self, said: GimbalAttitude, now: float, *, own: bool) -> None:
        """Take in a report of the device itself (``own``) or of its manager; one that is not newer proves nothing."""
        if not own and now - self._own < LASTING:
            return
        if own and now - self._own >= LASTING:
            self._boot = -math.inf  # the clock of another sender
        if self._boot - RESTART < said.boot <= self._boot:
            return
        self.restarted = self.restarted or said.boot < self._boot
        base = self._base(now) if said.earth else (0.0, 0.0)
        self.lost_vehicle = base is None
        self.failures, self._boot = said.failures, said.boot
        self._own = now if own else self._own
        if base is not None:
            self._take(said.yaw - base[0], None if said.rate is None else said.rate - base[1], now)

    def forget(self) -> None:
        """Believe no report that came before."""
        self.time = self._boot = self._own = -math.inf
        self.restarted = self.lost_vehicle = False

    def _base(self, now: float) -> tuple[float, float] | None:
        """Yaw [rad] and its rate [rad/s] of the vehicle at ``now`` [s]; None when nobody knows."""
        if self._vehicle is None or now - self._vehicle[0] > FRESH:
            return None
        time, vehicle = self._vehicle
        return vehicle.yaw + vehicle.yaw_rate * (now - time), vehicle.yaw_rate

    def _take(self, yaw: float, rate: float | None, now: float) -> None:
        angle = self.angle + wrap(yaw - self.angle) if self._known else self._first(wrap(yaw))
        passed = now - self.time
        self.rate = (angle - self.angle) / passed if rate is None and 0 < passed < FRESH else rate or 0.0
        self.angle, self.time, self._known = angle, now, True

    def _first(self, yaw: float) -> float:
        """Choose a turn inside the travel; where two are, the one near zero."""
        turns = (yaw, yaw - 2 * math.pi, yaw + 2 * math.pi)
        return next((turn for turn in turns if self.lower <= turn <= self.upper), yaw)
