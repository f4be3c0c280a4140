"""How every back end notices every fault: within which time, and in which words."""

from __future__ import annotations

import re
from dataclasses import dataclass

from ross_sim.devices.far_end import Fault


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


NO_ATTITUDE = "no attitude received from the autopilot|does not send|does not tell"

# None: nothing on the wire tells of it, so that only the mission can notice.
DETECTIONS: dict[tuple[str, Fault], Detection | None] = {
    ("ideal", Fault.SILENT): Detection(0.6, r"no report for 0\.5"),
    ("ideal", Fault.STUCK): Detection(30.1, "not at rest at the goal after 30 s"),
    ("tb6600", Fault.STALL): None,
    ("tb6600", Fault.STUCK): None,
    ("tb6600", Fault.SLIP): None,
    ("tb6600", Fault.SILENT): Detection(0.6, r"no report for 0\.5"),
    ("tb6600", Fault.SATURATED): Detection(0.2, "pulse underrun"),
    ("tb6600:switch", Fault.STALL): None,
    ("tb6600:switch", Fault.STUCK): None,
    ("tb6600:switch", Fault.SLIP): None,
    ("tb6600:switch", Fault.SILENT): Detection(0.6, r"no report for 0\.5"),
    ("tb6600:switch", Fault.SATURATED): Detection(0.2, "pulse underrun"),
    ("mavlink_gimbal", Fault.STALL): Detection(4.0, "does not follow"),
    ("ideal", Fault.SLIP): None,
    ("mavlink_gimbal", Fault.STUCK): Detection(4.0, "does not follow"),
    ("mavlink_gimbal", Fault.SLIP): None,
    ("mavlink_gimbal", Fault.NOISY): Detection(1.0, "the gimbal's attitude jumps"),
    ("mavlink_gimbal", Fault.SILENT): Detection(0.7, "no attitude received from the gimbal"),
    ("mavlink_gimbal", Fault.REBOOT): Detection(4.0, "has restarted in the middle"),
    ("mavlink_gimbal", Fault.TAKEN): Detection(0.5, "component 190 of system 255 has taken control"),
    ("mavlink_gimbal", Fault.SATURATED): Detection(
        1.5, "s late: the link|no attitude received from the gimbal|no data from the autopilot", rest=2.0
    ),
    ("mavlink_gimbal", Fault.DUPLICATE): Detection(0.6, "two gimbals have the same component id"),
    ("mavlink_gimbal", Fault.CORRUPT): Detection(0.7, "no attitude received from the gimbal"),
    ("mavlink_gimbal:manager", Fault.STALL): Detection(4.0, "does not follow"),
    ("mavlink_gimbal:manager", Fault.STUCK): Detection(4.0, "does not follow"),
    ("mavlink_gimbal:manager", Fault.SLIP): None,
    ("mavlink_gimbal:manager", Fault.NOISY): Detection(1.0, "the gimbal's attitude jumps"),
    ("mavlink_gimbal:manager", Fault.SILENT): Detection(0.7, "no attitude received from the gimbal"),
    ("mavlink_gimbal:manager", Fault.REBOOT): Detection(4.0, "has restarted in the middle"),
    ("mavlink_gimbal:manager", Fault.TAKEN): Detection(0.3, "component 190 of system 255 manages the gimbal too"),
    ("mavlink_gimbal:manager", Fault.SATURATED): Detection(
        1.5, "s late: the link|no attitude received from the gimbal", rest=2.0
    ),
    ("mavlink_gimbal:manager", Fault.DUPLICATE): Detection(0.6, "two gimbals have the same component id"),
    ("mavlink_gimbal:manager", Fault.CORRUPT): Detection(0.7, "no attitude received from the gimbal"),
    ("dronecan_servo", Fault.STALL): Detection(4.0, "does not follow"),
    ("dronecan_servo", Fault.STUCK): Detection(4.0, "does not follow"),
    ("dronecan_servo", Fault.SLIP): None,
    ("dronecan_servo", Fault.NOISY): Detection(2.0, "is noisy"),
    ("dronecan_servo", Fault.SILENT): Detection(0.6, r"no report for 0\.5"),
    ("dronecan_servo", Fault.REBOOT): Detection(0.1, "restarted"),
    ("dronecan_servo", Fault.TAKEN): Detection(0.1, "node 99 commands actuator 1 too"),
    ("dronecan_servo", Fault.SATURATED): Detection(0.6, "the bus is full: .* from node 99"),
    ("dronecan_servo", Fault.DUPLICATE): Detection(0.2, "another node has the servo's id"),
    ("dronecan_servo", Fault.CORRUPT): Detection(1.0, "came damaged|no report for"),
    ("dronecan_servo:gimbal", Fault.STALL): Detection(4.0, "does not follow"),
    ("dronecan_servo:gimbal", Fault.STUCK): Detection(4.0, "does not follow"),
    ("dronecan_servo:gimbal", Fault.SLIP): None,
    ("dronecan_servo:gimbal", Fault.NOISY): Detection(2.0, "is noisy"),
    ("dronecan_servo:gimbal", Fault.SILENT): Detection(0.6, r"no report for 0\.5"),
    ("dronecan_servo:gimbal", Fault.REBOOT): Detection(0.1, "restarted"),
    ("dronecan_servo:gimbal", Fault.TAKEN): Detection(0.1, "node 99 commands actuator 0 too"),
    ("dronecan_servo:gimbal", Fault.SATURATED): Detection(0.6, "the bus is full: .* from node 99"),
    ("dronecan_servo:gimbal", Fault.DUPLICATE): Detection(0.2, "another node has the servo's id"),
    ("dronecan_servo:gimbal", Fault.CORRUPT): Detection(1.0, "came damaged|no report for"),
    ("dronecan_servo:model", Fault.STALL): None,
    ("dronecan_servo:model", Fault.STUCK): None,
    ("dronecan_servo:model", Fault.SLIP): None,
    ("dronecan_servo:model", Fault.SILENT): Detection(0.6, r"no report for 0\.5"),
    ("dronecan_servo:model", Fault.REBOOT): Detection(0.1, "restarted"),
    ("dronecan_servo:model", Fault.TAKEN): Detection(0.1, "node 99 commands actuator 1 too"),
    ("dronecan_servo:model", Fault.SATURATED): Detection(0.6, "the bus is full: .* from node 99"),
    ("dronecan_servo:model", Fault.DUPLICATE): Detection(0.2, "another node has the servo's id"),
    ("dronecan_servo:model", Fault.CORRUPT): Detection(1.0, "came damaged|no report for"),
    ("canopen_drive", Fault.STALL): Detection(0.6, "following error"),
    ("canopen_drive", Fault.STUCK): Detection(0.6, "following error"),
    ("canopen_drive", Fault.SLIP): None,
    ("canopen_drive", Fault.NOISY): Detection(2.5, "implausible position"),
    ("canopen_drive", Fault.SILENT): Detection(0.4, "node 5 has sent nothing"),
    ("canopen_drive", Fault.REBOOT): Detection(0.1, "node 5 has restarted"),
    ("canopen_drive", Fault.TAKEN): Detection(0.05, "another master on the bus commands node 5"),
    ("canopen_drive", Fault.SATURATED): Detection(0.4, "node 5 has sent nothing .* the bus is full"),
    ("canopen_drive", Fault.DUPLICATE): Detection(0.1, "two devices have node id 5"),
    ("canopen_drive", Fault.CORRUPT): Detection(0.3, "arrive damaged|implausible position"),
    ("grbl", Fault.STALL): None,
    ("grbl", Fault.STUCK): None,
    ("grbl", Fault.SLIP): None,
    ("grbl", Fault.SILENT): Detection(0.6, r"no report for 0\.5"),
    ("grbl", Fault.REBOOT): Detection(0.1, "has restarted"),
    ("grbl", Fault.TAKEN): Detection(1.5, "another controller"),
    ("grbl", Fault.CORRUPT): Detection(0.6, "serial line is noisy"),
    ("vehicle_yaw", Fault.STALL): Detection(4.0, "does not follow"),
    ("vehicle_yaw", Fault.NOISY): Detection(4.0, "the attitude of the vehicle jumps"),
    ("vehicle_yaw", Fault.SILENT): Detection(0.7, NO_ATTITUDE),
    ("vehicle_yaw", Fault.TAKEN): Detection(7.0, "does not follow", rest=3.0),
    ("vehicle_yaw", Fault.SATURATED): Detection(1.5, "s late: the link|" + NO_ATTITUDE, rest=2.0),
    ("vehicle_yaw", Fault.CORRUPT): Detection(0.7, NO_ATTITUDE),
    ("vehicle_yaw", Fault.PILOT): Detection(0.1, "the pilot moves the yaw stick"),
    ("vehicle_yaw", Fault.MODE): Detection(0.1, "the flight mode is LOITER: the vehicle is turned only in GUIDED"),
    ("vehicle_yaw", Fault.DISARMED): Detection(0.15, "the vehicle is not armed"),
    ("vehicle_yaw", Fault.LANDED): Detection(0.3, "the vehicle is on the ground"),
    ("vehicle_yaw:offboard", Fault.STALL): Detection(4.0, "does not follow"),
    ("vehicle_yaw:offboard", Fault.NOISY): Detection(4.0, "the attitude of the vehicle jumps"),
    ("vehicle_yaw:offboard", Fault.SILENT): Detection(0.7, NO_ATTITUDE),
    ("vehicle_yaw:offboard", Fault.SATURATED): Detection(1.5, "s late: the link|" + NO_ATTITUDE, rest=3.0),
    ("vehicle_yaw:offboard", Fault.CORRUPT): Detection(0.7, NO_ATTITUDE),
    ("vehicle_yaw:offboard", Fault.PILOT): Detection(0.1, "the pilot moves the yaw stick|the flight mode is Position"),
    ("vehicle_yaw:offboard", Fault.MODE): Detection(
        0.1, "the flight mode is Position: the vehicle is turned only in Offboard"
    ),
    ("vehicle_yaw:offboard", Fault.DISARMED): Detection(0.3, "the vehicle is not armed|the vehicle is on the ground"),
    ("vehicle_yaw:offboard", Fault.LANDED): Detection(0.3, "the vehicle is on the ground"),
}
