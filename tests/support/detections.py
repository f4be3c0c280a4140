"""How every back end notices every fault: within which time, and in which words."""

from __future__ import annotations

import re
from dataclasses import dataclass

from ross_sim.far_end import Fault


@dataclass(frozen=True, slots=True)
class Detection:
    """How a fault that begins in the middle of a move is noticed; one that begins at rest, with the next move."""

    within: float  # [s]
    words: str  # a regular expression that the fault matches
    at_rest: str = ""  # other words that it may match when it began at rest
    rest: float = 1.0  # in which it stands still after that, besides the time that braking takes [s]

    def matches(self, fault: str, *, began_at_rest: bool = False) -> bool:
        words = (self.words, self.at_rest) if began_at_rest and self.at_rest else (self.words,)
        return any(re.search(each, fault) for each in words)


# None: nothing on the wire tells of it, so that only the mission can notice.
DETECTIONS: dict[tuple[str, Fault], Detection | None] = {
    ("ideal", Fault.SILENT): Detection(0.6, r"no report for 0\.5"),
    ("ideal", Fault.STUCK): Detection(30.1, "not at rest at the goal after 30 s"),
    ("mavlink_gimbal", Fault.STALL): Detection(4.0, "does not follow"),
    ("ideal", Fault.SLIP): None,
    ("mavlink_gimbal", Fault.STUCK): Detection(4.0, "does not follow"),
    ("mavlink_gimbal", Fault.SLIP): None,
    ("mavlink_gimbal", Fault.NOISY): Detection(1.0, "jumps to and fro"),
    ("mavlink_gimbal", Fault.SILENT): Detection(0.7, "does not report its attitude|no report for 0.5"),
    ("mavlink_gimbal", Fault.REBOOT): Detection(4.0, "has restarted in the middle"),
    ("mavlink_gimbal", Fault.TAKEN): Detection(0.5, "component 190 of system 255 has taken control"),
    ("mavlink_gimbal", Fault.SATURATED): Detection(1.5, "s late: the link|does not report its attitude|no report for"),
    ("mavlink_gimbal", Fault.DUPLICATE): Detection(0.6, "two gimbals report with one component id"),
    ("mavlink_gimbal", Fault.CORRUPT): Detection(0.7, "does not report its attitude|no report for 0.5"),
    ("mavlink_gimbal:manager", Fault.STALL): Detection(4.0, "does not follow"),
    ("mavlink_gimbal:manager", Fault.STUCK): Detection(4.0, "does not follow"),
    ("mavlink_gimbal:manager", Fault.SLIP): None,
    ("mavlink_gimbal:manager", Fault.NOISY): Detection(1.0, "jumps to and fro"),
    ("mavlink_gimbal:manager", Fault.SILENT): Detection(0.7, "does not report its attitude|no report for 0.5"),
    ("mavlink_gimbal:manager", Fault.REBOOT): Detection(4.0, "has restarted in the middle"),
    ("mavlink_gimbal:manager", Fault.TAKEN): Detection(0.3, "component 190 of system 255 manages the gimbal too"),
    ("mavlink_gimbal:manager", Fault.SATURATED): Detection(
        1.5, "s late: the link|does not report its attitude|no report for"
    ),
    ("mavlink_gimbal:manager", Fault.DUPLICATE): Detection(0.6, "two gimbals report with one component id"),
    ("mavlink_gimbal:manager", Fault.CORRUPT): Detection(0.7, "does not report its attitude|no report for 0.5"),
    ("dronecan_servo", Fault.STUCK): Detection(4.0, "does not follow"),
    ("dronecan_servo", Fault.SILENT): Detection(0.6, r"no report for 0\.5"),
    ("dronecan_servo", Fault.REBOOT): Detection(1.1, "restarted"),
}
