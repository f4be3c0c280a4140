"""Where the base of the payload points."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ross_payload.config import Config
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Attitude, Clock, Mount
from ross_payload.mavlink import Router
from ross_payload.mount.autopilot_attitude import AutopilotMount
from ross_payload.timebase import Timebase

__all__ = ["AutopilotMount", "FixedMount", "fixed_mount", "mount_of"]


@dataclass(frozen=True, slots=True)
class FixedMount:
    """A base that never turns; ``yaw`` [rad] in the earth frame, or None when nobody knows it."""

    yaw: float | None = None

    def attitude(self, time: float) -> Attitude:
        """Return the fixed attitude, flagged unknown (mount frame) when no yaw was given."""
        return Attitude(yaw=self.yaw or 0.0, known=self.yaw is not None)


def fixed_mount(config: Config) -> FixedMount:
    """Make the mount of a base that never turns; a compass turns clockwise, we do not."""
    yaw = config.mount.yaw_deg
    return FixedMount(None if yaw is None else -math.radians(yaw))


def mount_of(config: Config, clock: Clock, links: Router, timebase: Timebase) -> Mount:
    """Make the mount that a configuration describes.

    Raises
    ------
    ConfigError
        When the attitude is wanted from an autopilot and no link leads to one.
    """
    if config.mount.source == "fixed":
        return fixed_mount(config)
    if not any(link.role == "autopilot" for link in links.status()):
        raise ConfigError('mount.source = "autopilot": expected a [[links]] table with role = "autopilot", got none')
    component = links.component(config.telemetry.component_id)
    told = config.telemetry.system_id
    return AutopilotMount(component, clock, timebase, fresh=config.mount.fresh_s, system_id=told)
