"""Where the base of the payload points."""

from __future__ import annotations

from dataclasses import dataclass

from ross_payload.interfaces import Attitude


@dataclass(frozen=True, slots=True)
class FixedMount:
    """A base that never turns; ``yaw`` [rad] in the earth frame, or None when nobody knows it."""

    yaw: float | None = None

    def attitude(self, time: float) -> Attitude:
        """Return the fixed attitude, flagged unknown (mount frame) when no yaw was given."""
        return Attitude(yaw=self.yaw or 0.0, known=self.yaw is not None)
