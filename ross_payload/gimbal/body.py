"""The gimbal's body: where the array points, what it can do, what ails it."""

from __future__ import annotations

import math

from ross_payload import __version__
from ross_payload.angles import wrap
from ross_payload.config import Config
from ross_payload.gimbal.pose import axis_of, failures_of, pose_of
from ross_payload.interfaces import Actuator, Input, Mount
from ross_protocols.own_gimbal import Aim, Axis, Pose


class Body:
    """The actuator and the base under it. ``heard`` belongs to the mission's thread, the rest to the pump."""

    def __init__(self, config: Config, actuator: Actuator, mount: Mount) -> None:
        self._config = config
        self._actuator = actuator
        self._mount = mount
        self._latest: Input | None = None

    def heard(self, heard: Input) -> None:
        """Keep what was heard last: it tells how the joint stands to the base, also after a slip."""
        self._latest = heard

    @property
    def park(self) -> float:
        """Joint angle of the parking position [rad]."""
        return math.radians(self._config.guard.park_deg)

    def offset(self) -> float:
        """Return where the array points at joint angle 0, from the nose of the vehicle [rad]."""
        heard = self._latest
        if heard is None:
            return wrap(self._config.offset)
        base = self._mount.attitude(heard.block.time + heard.block.samples.shape[1] / self._config.audio.rate_hz)
        if base.known != heard.attitude.known:
            return wrap(self._config.offset)
        return wrap(heard.heading_end - heard.joint - base.yaw)

    def axis(self) -> Axis:
        """Return what the gimbal is."""
        mount = self._config.mount
        earth = mount.source == "autopilot" or mount.yaw_deg is not None
        travel, model = self._actuator.capabilities, self._config.actuator.kind
        return axis_of(travel, wrap(self._config.offset), model, __version__, earth=earth)

    def pose(self, now: float, aim: Aim | None, failures: int) -> Pose:
        """Return where the array points; ``failures`` are known from elsewhere."""
        state, failures = self._actuator.state(), failures | self.failures(now)
        return pose_of(state, self._mount, now, self.offset(), aim=aim, failures=failures)

    def failures(self, now: float) -> int:
        """Return the failure flags of the actuator."""
        patience = self._config.guard.watchdog_s
        return failures_of(self._actuator.state(), self._actuator.capabilities, now, patience)

    def unable(self, aim: Aim, now: float) -> str:
        """Return why the array cannot follow an aim at present; empty when it can."""
        state = self._actuator.state()
        if not state.healthy:
            return state.fault or "the actuator reports a fault"
        if not state.homed:
            return "the zero is not known: home first"
        unknown = aim.earth and not self._mount.attitude(now).known
        return "the attitude of the vehicle is not known" if unknown else ""
