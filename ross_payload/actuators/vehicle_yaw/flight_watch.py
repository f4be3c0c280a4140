"""What the autopilot tells of the flight, and whether the vehicle may be turned now.

It remembers what it has heard and says which messages must be asked for; it sends nothing itself.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from ross_payload.actuators.driver_shell import HELD_UP_S
from ross_payload.actuators.vehicle_yaw.options import Options
from ross_protocols.mavlink import vehicle, vehicle_control
from ross_protocols.mavlink.codec import Packet
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.vehicle import AUTOPILOT, Position
from ross_protocols.mavlink.vehicle_control import (
    ARDUPILOT,
    ATTITUDE,
    CURRENT_MODE,
    EXTENDED_SYS_STATE,
    GLOBAL_POSITION,
    GUIDED,
    HEARTBEAT,
    HOLD,
    IN_AIR,
    LOCAL_POSITION,
    MANUAL_CONTROL,
    OFFBOARD,
    PX4,
    RC_CHANNELS,
)  # fmt: skip

MAX_PAUSE_S = 0.45  # [s]; after a longer one nobody knows what the pilot has done meanwhile
ASK_PERIOD_S = 1.0  # between two looks whether messages flow
ENOUGH = 0.6  # of the rate that was asked for: it is not asked for again
STICK_STALE_S = 0.3  # a stick that is told more seldom proves nothing
PLACE_STALE_S = 1.5  # nor a place or a height: nobody is sent back there
LANDED_STALE_S = 1.5  # nor whether it flies
MODE_STALE_S = {ARDUPILOT: 0.3, PX4: 1.2}  # nor a mode; PX4 tells a new one at once, and the same one twice a second
RATES: dict[int, dict[int, float]] = {  # by autopilot: how often it must tell what [Hz]
    ARDUPILOT: {ATTITUDE: 50.0, HEARTBEAT: 10.0, RC_CHANNELS: 20.0,  # it tells a new mode at once, too
                EXTENDED_SYS_STATE: 5.0},
    PX4: {ATTITUDE: 50.0, CURRENT_MODE: 20.0, RC_CHANNELS: 20.0, MANUAL_CONTROL: 20.0,
          EXTENDED_SYS_STATE: 5.0, GLOBAL_POSITION: 5.0, LOCAL_POSITION: 10.0},
}  # fmt: skip
GROUNDED = {  # why a vehicle is not turned, by MAV_LANDED_STATE
    common.MAV_LANDED_STATE_ON_GROUND: "the vehicle is on the ground: it is turned only in the air",
    common.MAV_LANDED_STATE_TAKEOFF: "the vehicle is taking off: it is turned only when it has",
    common.MAV_LANDED_STATE_LANDING: "the vehicle is landing: it is turned only in the air",
}
Place = tuple[float, float, float]  # north, east, down [m]


@dataclass(slots=True)
class FlightWatch:
    """The latest that the autopilot has told, component 1 of our vehicle."""

    options: Options
    whom: ComponentId | None = None  # the autopilot
    kind: int = -1  # MAV_AUTOPILOT
    multicopter: bool = True
    armed: bool = False
    mode: int = -1
    _landed: tuple[float, int] = (-math.inf, common.MAV_LANDED_STATE_UNDEFINED)  # when it was told [s], and which state
    _position: tuple[float, Position] | None = None  # when it was told [s], and which
    _place: tuple[float, Place] | None = None  # the same
    _mode_times: tuple[float, float] = (-math.inf, -math.inf)  # of the last two reports of the mode [s]
    _stick: float = math.nan  # from its centre [us]
    _stick_times: tuple[float, float] = (-math.inf, -math.inf)  # of the last two reports of the stick [s]
    _counts: dict[int, int] = field(default_factory=dict)  # messages since the last look
    _looked: float = -math.inf  # [s]
    _read_at: float = -math.inf  # when what arrives was read last [s]
    _excused: tuple[float, float] = (-math.inf, -math.inf)  # the last times of mode and stick moved by a pause [s]

    @property
    def wanted_mode(self) -> int:
        """The flight mode in which the vehicle may be turned."""
        if self.kind == ARDUPILOT:
            return GUIDED
        return OFFBOARD if self.options.px4_mode == "offboard" else HOLD

    @property
    def grounded(self) -> str:
        """Why the vehicle is not turned where it is, as was told last; empty in the air, and when it was not told."""
        return GROUNDED.get(self._landed[1], "")

    def on_packet(self, packet: Packet, now: float) -> None:
        """Take in what somebody of our vehicle says."""
        if packet.component_id != AUTOPILOT:
            return
        message = packet.message
        status = vehicle_control.flight_status(message)
        if status is not None and (self.whom is not None or status.autopilot in RATES):
            self.whom, self.kind, self.multicopter = packet.sender, status.autopilot, status.multicopter
            self.armed, self.mode = status.armed, status.mode
        if packet.name == ("HEARTBEAT" if self.kind == ARDUPILOT else "CURRENT_MODE"):
            self._mode_times = (self._mode_times[1], now)
        number = message.get_msgId()
        self._counts[number] = self._counts.get(number, 0) + 1
        stick = vehicle_control.yaw_stick(message, self.options.yaw_channel or 1, self.options.stick_centre_us)
        if stick is not None:
            self._stick, self._stick_times = stick, (self._stick_times[1], now)
        if packet.name == "CURRENT_MODE":
            self.mode = message.custom_mode
        elif packet.name == "LOCAL_POSITION_NED":
            self._place = now, (message.x, message.y, message.z)
        landed = vehicle_control.landed_state(message)
        if landed is not None:
            self._landed = now, landed
        position = vehicle.position_of(message)
        if position is not None:
            self._position = now, position

    def on_read(self, now: float) -> None:
        """Call nothing late that could not arrive while nobody read: in a pause of the whole computer.

        Only the first pause since a report excuses the next one: who reads seldom is not held up.
        """
        pause, self._read_at = now - self._read_at, now
        if not HELD_UP_S < pause <= MAX_PAUSE_S:
            return
        if self._mode_times[1] != self._excused[0]:
            self._mode_times = self._mode_times[0] + pause, self._mode_times[1] + pause
        if self._stick_times[1] != self._excused[1]:
            self._stick_times = self._stick_times[0] + pause, self._stick_times[1] + pause
        self._excused = self._mode_times[1], self._stick_times[1]

    def position_at(self, now: float) -> Position | None:
        """Return where on earth the vehicle is; None: that was not told lately."""
        return self._position[1] if self._position is not None and now - self._position[0] <= PLACE_STALE_S else None

    def place_at(self, now: float) -> Place | None:
        """Return where the vehicle is from where its autopilot counts; None: that was not told lately."""
        return self._place[1] if self._place is not None and now - self._place[0] <= PLACE_STALE_S else None

    def flies(self, now: float) -> bool:
        """Tell whether the vehicle is in the air, neither taking off nor landing, as was told lately."""
        return self._landed[1] == IN_AIR and now - self._landed[0] <= LANDED_STALE_S

    def due(self, now: float) -> list[Any]:
        """Return the requests for messages that come too seldom."""
        passed = now - self._looked
        if self.whom is None or passed < ASK_PERIOD_S:
            return []
        counts, self._counts, self._looked = self._counts, {}, now
        rates = RATES.get(self.kind, {})
        seldom = [number for number, rate in rates.items() if not counts.get(number, 0) >= ENOUGH * rate * passed]
        return [vehicle_control.interval(self.whom, number, rates[number]) for number in seldom]

    def missing(self) -> str:
        """Say which autopilot is missing; empty when it is there."""
        if self.whom is None:
            return "no heartbeat received from an autopilot: expected ArduPilot or PX4"
        if not self.multicopter or self.kind not in RATES:
            return "the autopilot does not fly a multicopter with ArduPilot or PX4: it cannot be turned"
        return ""

    def objection(self) -> str:
        """Say why the vehicle may not be turned, as far as it was told; empty when it may."""
        if not self.armed:
            return "the vehicle is not armed: it is turned only while it is armed"
        wanted, name = self.wanted_mode, vehicle_control.mode_name
        if self.mode != wanted:
            return (
                f"the flight mode is {name(self.kind, self.mode)}: the vehicle is turned only in"
                f" {name(self.kind, wanted)}"
            )
        if self.options.yaw_channel and abs(self._stick) > self.options.stick_dead_band_us:
            return f"the pilot moves the yaw stick ({self._stick:+.0f} us): the vehicle is the pilot's"
        return self.grounded

    def ignorance(self, now: float) -> str:
        """Say what is not told often enough to turn the vehicle; empty when all is."""
        before, last = self._mode_times
        stale = MODE_STALE_S[self.kind]
        seldom = self.kind == ARDUPILOT and last - before > stale  # a heartbeat a second is told from none
        if now - last > stale or seldom:
            name = "HEARTBEAT" if self.kind == ARDUPILOT else "CURRENT_MODE"
            return f"the autopilot does not send {name} every {stale:g} s: another mode would be noticed too late"
        channel = self.options.yaw_channel
        before, last = self._stick_times
        seldom = now - last > STICK_STALE_S or last - before > STICK_STALE_S
        if channel and (seldom or math.isnan(self._stick)):
            return (
                f"the autopilot does not tell the pilot's yaw stick (RC_CHANNELS, channel {channel}):"
                " yaw_channel = 0 if nobody holds one"
            )
        return "" if self.flies(now) else "the autopilot does not tell whether the vehicle flies (EXTENDED_SYS_STATE)"
