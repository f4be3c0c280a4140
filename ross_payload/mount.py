"""Where the base of the payload points."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ross_payload.config import Config
from ross_payload.interfaces import Attitude, Mount


@dataclass(frozen=True, slots=True)
class FixedMount:
    """A base that never turns; ``yaw`` [rad] in the earth frame, or None when nobody knows it."""

    yaw: float | None = None

    def attitude(self, time: float) -> Attitude:
        """Return the fixed attitude, flagged unknown (mount frame) when no yaw was given."""
        return Attitude(yaw=self.yaw or 0.0, known=self.yaw is not None)


def mount_of(config: Config) -> Mount:
    """Make the mount that a configuration describes; a compass turns clockwise, we do not."""
    yaw = config.mount.yaw_deg
    return FixedMount(None if yaw is None else -math.radians(yaw))
