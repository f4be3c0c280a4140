"""An autopilot that flies a multicopter, as far as its yaw goes: what it says on the wire, and how it answers."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import cycle
from typing import Any

from ross_payload.angles import wrap
from ross_protocols.mavlink import vehicle
from ross_protocols.mavlink.codec import Packet
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common, ross
from ross_protocols.mavlink.field_converters import clockwise
from ross_protocols.mavlink.vehicle import TimeSync, VehicleAttitude
from ross_protocols.mavlink.vehicle_control import (
    ARMED,
    ATTITUDE,
    CURRENT_MODE,
    EXTENDED_SYS_STATE,
    GLOBAL_POSITION,
    HEARTBEAT,
    IN_AIR,
    LOCAL_POSITION,
    MANUAL_CONTROL,
    RC_CHANNELS,
)  # fmt: skip
from ross_sim.autopilot.flight_modes import CENTRE, OTHER_MODE, Copter, Px4
from ross_sim.autopilot.yaw_dynamics import STEP
from ross_sim.devices.gimbal_device import STAMP_LAGS

SYSTEM_TIME = 2  # message id
USUAL = {HEARTBEAT: 1.0, ATTITUDE: 0.25, RC_CHANNELS: 0.5, SYSTEM_TIME: 1.0}  # periods until somebody asks [s]
SHORTEST = 0.01  # of the periods that it can be asked for [s]
EARLY = 1e-9  # of rounding [s]
STATE_PERIOD_S = 0.5  # in which PX4 publishes its state when nothing has changed
BOOT = 100.0  # what its clock shows when its life begins here [s]
LATITUDE, LONGITUDE = 473977000, 85455000  # where it hovers, in 1e-7 degrees


class FlyingAutopilot:
    """Component 1 of a multicopter that hovers.

    `armed`, `landed`, `mute`, `trembling`, `altimeter_error` and the ``stick`` of ``modes`` may be set while it lives.

    Parameters
    ----------
    address
        Its own.
    modes
        What steers the yaw.
    """

    def __init__(self, address: ComponentId, modes: Copter | Px4) -> None:
        self.address = address
        self.modes = modes
        self.ardupilot = isinstance(modes, Copter)
        self.armed = True
        self.landed = IN_AIR  # MAV_LANDED_STATE, while it is armed
        self.mute = False
        self.trembling: Callable[[], float] | None = None  # error of its compass [rad]
        self.altimeter_error = 0.0  # [m]
        self._adjustable = {ATTITUDE, RC_CHANNELS, SYSTEM_TIME, GLOBAL_POSITION, LOCAL_POSITION, EXTENDED_SYS_STATE}
        self._adjustable |= {HEARTBEAT} if self.ardupilot else {CURRENT_MODE, MANUAL_CONTROL}
        self._periods = dict(USUAL)
        self._due: dict[int, float] = {}
        self._steps = 0
        self._said_mode = modes.mode
        self._mode_sent, self._mode_is_news = -math.inf, True  # by CURRENT_MODE of PX4
        self._lags = cycle(STAMP_LAGS)
        self._past: list[tuple[float, float]] = [(0.0, modes.body.yaw)]  # when [s], true yaw [rad]

    @property
    def yaw(self) -> float:
        """The true yaw [rad], counter-clockwise from north, unwrapped."""
        return self.modes.body.yaw

    @property
    def landed_state(self) -> int:
        """MAV_LANDED_STATE."""
        return int(self.landed if self.armed else common.MAV_LANDED_STATE_ON_GROUND)

    def withhold(self, number: int) -> None:
        """Never tell a message again, whoever asks for it."""
        self._adjustable.discard(number)
        self._periods.pop(number, None)

    def fly_by_hand(self, now: float) -> None:
        """Let the pilot choose another mode."""
        self.modes.enter(OTHER_MODE[self.ardupilot], now)

    def move(self, now: float) -> None:
        """Fly until ``now`` [s]."""
        self.modes.body.grounded = self.landed_state == common.MAV_LANDED_STATE_ON_GROUND
        while (self._steps + 1) * STEP <= now + EARLY:
            self._steps += 1
            self.modes.step(self._steps * STEP)
        self._past = [*self._past[-5:], (now, self.yaw)]

    def on_packet(self, packet: Packet, now: float) -> list[Any]:
        """Obey a command or a set-point, answer TIMESYNC; return the answers."""
        message, said = packet.message, vehicle.read(packet.message)
        if isinstance(said, TimeSync) and said.answered is None and said.target.includes(self.address):
            return [vehicle.time_sync(TimeSync(said.asked, round((now + BOOT) * 1e9), packet.sender))]
        if (getattr(message, "target_system", 0), getattr(message, "target_component", 0)) != self.address:
            return []
        if packet.name == "SET_POSITION_TARGET_LOCAL_NED":
            self.modes.on_set_point(message, now)
        if packet.name not in ("COMMAND_LONG", "COMMAND_INT"):
            return []
        result = self._command(message, now)
        whom = {"target_system": packet.system_id, "target_component": packet.component_id}
        return [common.MAVLink_command_ack_message(message.command, result, **whom)]

    def live(self, now: float) -> list[Any]:
        """Return what is due at ``now`` [s]."""
        ready = [number for number in self._periods if now >= self._due.get(number, now) - EARLY]
        changed, self._said_mode = self.modes.mode != self._said_mode, self.modes.mode
        if changed and self.ardupilot and HEARTBEAT not in ready:
            ready.append(HEARTBEAT)  # at once
        self._mode_is_news = self._mode_is_news or changed or now - self._mode_sent >= STATE_PERIOD_S - EARLY
        if CURRENT_MODE in ready and not self._mode_is_news:
            ready.remove(CURRENT_MODE)
        elif CURRENT_MODE in ready:
            self._mode_sent, self._mode_is_news = now, False
        for number in ready:
            self._due[number] = max(self._due.get(number, now) + self._periods[number], now)
        return [] if self.mute else [self._message(number, now) for number in ready]

    def _command(self, message: Any, now: float) -> int:
        if message.command == common.MAV_CMD_SET_MESSAGE_INTERVAL:
            number = int(message.param1) if math.isfinite(message.param1) else -1
            if number not in self._adjustable:
                return int(common.MAV_RESULT_DENIED)
            self._due.pop(number, None)
            self._periods[number] = (
                max(message.param2 / 1e6, SHORTEST) if message.param2 > 0 else USUAL.get(number, 1.0)
            )
            return int(common.MAV_RESULT_ACCEPTED)
        return self.modes.command(message, now)

    def _message(self, number: int, now: float) -> Any:
        milliseconds = round((now + BOOT) * 1e3)
        system = self.address.system
        stick = self.modes.stick
        pulses = [1500, 1500, 1500, round(stick), 1000, 1000, 1000, 1000] + [65535] * 10
        place, still = (1.0, 2.0, -10.0), (0.0, 0.0, 0.0)
        makers: dict[int, Callable[[], Any]] = {
            HEARTBEAT: self._heartbeat,
            SYSTEM_TIME: lambda: common.MAVLink_system_time_message(0, milliseconds),
            ATTITUDE: lambda: self._attitude(now),
            LOCAL_POSITION: lambda: common.MAVLink_local_position_ned_message(milliseconds, *place, *still),
            GLOBAL_POSITION: lambda: self._position(milliseconds),
            RC_CHANNELS: lambda: common.MAVLink_rc_channels_message(milliseconds, 8, *pulses, 200),
            MANUAL_CONTROL: lambda: common.MAVLink_manual_control_message(
                system, 0, 0, 500, round(2 * (stick - CENTRE)), 0
            ),
            EXTENDED_SYS_STATE: lambda: common.MAVLink_extended_sys_state_message(0, self.landed_state),
            CURRENT_MODE: lambda: ross.MAVLink_current_mode_message(0, self.modes.mode, 0),
        }
        return makers[number]()

    def _heartbeat(self) -> Any:
        maker = common.MAV_AUTOPILOT_ARDUPILOTMEGA if self.ardupilot else common.MAV_AUTOPILOT_PX4
        flags = common.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED | (ARMED if self.armed else 0)
        state = common.MAV_STATE_ACTIVE if self.armed else common.MAV_STATE_STANDBY
        return common.MAVLink_heartbeat_message(common.MAV_TYPE_QUADROTOR, maker, flags, self.modes.mode, state, 3)

    def _attitude(self, now: float) -> Any:
        """ATTITUDE of a few milliseconds ago, as it was."""
        lag = next(self._lags)
        then, before = self._past[-1], self._past[-2] if len(self._past) > 1 else self._past[-1]
        span = then[0] - before[0]
        share = min(lag / span, 1.0) if span > 0 else 0.0
        yaw = then[1] + share * (before[1] - then[1]) + (self.trembling() if self.trembling is not None else 0.0)
        return vehicle.attitude(VehicleAttitude(now + BOOT - lag, wrap(yaw), 0.0, 0.0, self.modes.body.rate))

    def _position(self, milliseconds: int) -> Any:
        altitude = self.modes.altitude if isinstance(self.modes, Px4) else 100.0
        height = round((altitude + self.altimeter_error) * 1e3)
        heading = round(math.degrees(clockwise(self.yaw)) % 360.0 * 100) % 36000
        return common.MAVLink_global_position_int_message(
            milliseconds, LATITUDE, LONGITUDE, height, 10_000, 0, 0, 0, heading
        )
