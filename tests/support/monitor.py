"""Watches what an actuator says and what its far end truly does, every 10 ms, and compares with limits and caps."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, fields

from rigs import ACCELERATION, LOWER, UPPER, Rig
from ross_payload.interfaces import ActuatorState
from ross_sim.clock import QUANTUM

WINDOW = 0.1  # over which a true speed is taken, and after which the next [s]
AT_REST = math.radians(0.1)  # of movement within 200 ms
ROUNDING = 1e-3
LOOKS = round(WINDOW / QUANTUM)
# When the torque comes back a rotor snaps to its windings, at most two full steps off: 3.6 deg in 0.1 s.
SNAP = 2.2  # as a share of the cap, beyond it


@dataclass(frozen=True, slots=True)
class Excess:
    """By how much more than allowed: what is tolerated, or the most that was seen."""

    angle_deg: float = 0.0  # beyond a limit, true or reported
    speed_deg_s: float = 0.0  # true, a mean over 100 ms
    acceleration: float = 0.0  # true, between two such means, as a share of the cap
    report_deg_s: float = 0.0  # reported speed
    report_acceleration: float = 0.0  # between two reports, as a share of the cap

    def most(self, other: Excess) -> Excess:
        return Excess(*(max(getattr(self, name), getattr(other, name)) for name in NAMES))

    def within(self, tolerated: Excess) -> bool:
        return all(getattr(self, name) <= getattr(tolerated, name) + ROUNDING for name in NAMES)


NAMES = [field.name for field in fields(Excess)]
USUAL = Excess(angle_deg=0.5, speed_deg_s=1.0, acceleration=0.3)
# By back end, where it differs from USUAL.
TOLERATED = {
    "ideal": Excess(),
    "tb6600": Excess(angle_deg=0.5, speed_deg_s=1.0, acceleration=SNAP),
    "mavlink_gimbal": Excess(
        angle_deg=0.5, speed_deg_s=1.0, acceleration=0.2, report_deg_s=2.0, report_acceleration=1.0
    ),  # its own loop around a plan, its rate measured by itself
    "vehicle_yaw": Excess(
        angle_deg=0.5, speed_deg_s=2.0, acceleration=0.6, report_deg_s=2.0, report_acceleration=3.5
    ),  # the autopilot shapes what it is told, and brakes a stop by itself; at its goal it may swing by 5 deg/s
    "dronecan_servo": Excess(angle_deg=0.5, speed_deg_s=1.0, acceleration=0.5),  # set-points in steps of 20 ms
    "canopen_drive": Excess(
        angle_deg=0.5, speed_deg_s=1.0, acceleration=0.3, report_deg_s=1.0, report_acceleration=3.1
    ),  # its measured rate comes in a frame of its own: that of 40 ms may come within 10
    "grbl": Excess(
        angle_deg=0.5, speed_deg_s=1.0, acceleration=SNAP, report_acceleration=0.5
    ),  # speeds told by segments of 10 ms
}


def tolerated(kind: str) -> Excess:
    return TOLERATED.get(kind, TOLERATED.get(kind.partition(":")[0], USUAL))


class Monitor:
    """Looks at a rig; the truth is compared in the frame of its last homing."""

    def __init__(self, rig: Rig) -> None:
        self.worst = Excess()
        self._rig = rig
        self._true: deque[float] = deque(maxlen=2 * LOOKS + 1)
        self._before: ActuatorState | None = None
        self._coasting = False
        self._shift: float | None = None  # of the far end's zero [rad]; None: not known where it is

    def run(self, quanta: int) -> None:
        for _ in range(quanta):
            self._rig.clock.sleep(QUANTUM)
            self._look()

    def let_go(self) -> None:
        """Until it stands still, what comes next is no planned motion."""
        self._coasting = True
        self._true.clear()

    def lost(self) -> None:
        """Where it is must be seen again."""
        self._shift = None

    def _look(self) -> None:
        state, true = self._rig.state, self._rig.far_end.angle()
        self._true.append(true)
        if self._coasting:
            self._wait_for_rest()
        else:
            self.worst = self.worst.most(self._angles(state, true)).most(self._truth()).most(self._reports(state))
            self._before = state

    def _wait_for_rest(self) -> None:
        if len(self._true) > LOOKS and max(self._true) - min(self._true) < AT_REST:
            self._coasting, self._before = False, None
            self._true.clear()

    def _angles(self, state: ActuatorState, true: float) -> Excess:
        if not state.homed:
            self._shift = None
            return Excess()
        if self._shift is None:
            if not state.settled:
                return Excess()
            self._shift = true - state.angle
        beyond = max(max(LOWER - angle, angle - UPPER) for angle in (state.angle, true - self._shift))
        return Excess(angle_deg=math.degrees(beyond))

    def _truth(self) -> Excess:
        if len(self._true) < 2 * LOOKS + 1:
            return Excess()
        before, after = (self._true[LOOKS] - self._true[0]) / WINDOW, (self._true[-1] - self._true[LOOKS]) / WINDOW
        return Excess(
            speed_deg_s=math.degrees(abs(after) - self._rig.speed),
            acceleration=abs(after - before) / (WINDOW * ACCELERATION) - 1,
        )

    def _reports(self, state: ActuatorState) -> Excess:
        faster = math.degrees(abs(state.rate) - self._rig.speed)
        if self._before is None:
            return Excess(report_deg_s=faster)
        passed = max(state.time - self._before.time, QUANTUM)
        steeper = abs(state.rate - self._before.rate) / (passed * ACCELERATION) - 1
        return Excess(report_deg_s=faster, report_acceleration=steeper)
