"""How every back end notices every fault: within which time, and in which words."""

from __future__ import annotations

import re
from dataclasses import dataclass

from ross_sim.far_end import Fault


@dataclass(frozen=True, slots=True)
class Detection:
    """How a fault that begins in the middle of a move is noticed."""

    within: float  # [s]
    words: str  # a regular expression that the fault matches

    def matches(self, fault: str) -> bool:
        return re.search(self.words, fault) is not None


# None: nothing on the wire tells of it, so that only the mission can notice.
DETECTIONS: dict[tuple[str, Fault], Detection | None] = {
    ("ideal", Fault.SILENT): Detection(0.6, r"no report for 0\.5"),
    ("ideal", Fault.STUCK): Detection(30.1, "not at rest at the goal after 30 s"),
    ("mavlink_gimbal", Fault.STUCK): Detection(4.0, "does not follow"),
    ("mavlink_gimbal", Fault.SILENT): Detection(0.7, "does not report its attitude|no report for 0.5"),
    ("mavlink_gimbal", Fault.REBOOT): Detection(0.3, "has restarted in the middle"),
    ("mavlink_gimbal", Fault.TAKEN): Detection(0.5, "component 190 of system 255 has taken control"),
    ("mavlink_gimbal:manager", Fault.STUCK): Detection(4.0, "does not follow"),
    ("mavlink_gimbal:manager", Fault.SILENT): Detection(0.7, "does not report its attitude|no report for 0.5"),
    ("mavlink_gimbal:manager", Fault.REBOOT): Detection(0.3, "has restarted in the middle"),
    ("dronecan_servo", Fault.STUCK): Detection(4.0, "does not follow"),
    ("dronecan_servo", Fault.SILENT): Detection(0.6, r"no report for 0\.5"),
    ("dronecan_servo", Fault.REBOOT): Detection(1.1, "restarted"),
}
