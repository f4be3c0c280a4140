"""An autopilot that behaves like an ArduPilot as far as a payload notices: attitude, time, routing.

It flies nothing. It says where the vehicle points and how fast its rotors turn, answers TIMESYNC and requests for
message rates, passes messages between its links as `routing` tells, and may manage a gimbal. Commands that it does not
know it refuses; parameters and missions it has none.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from ross_payload.interfaces import Clock
from ross_payload.transport.ports import Transport
from ross_protocols.mavlink import gimbal_messages, rotor_speeds, vehicle
from ross_protocols.mavlink.codec import Decoder, Encoder, Packet
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.vehicle import AUTOPILOT, SystemTime, TimeSync, VehicleAttitude
from ross_sim.autopilot.mavlink_routing import RoutingTable
from ross_sim.autopilot.yaw import Yaw
from ross_sim.devices.far_end import End, wire
from ross_sim.devices.gimbal_device import STEP, Device, Servo
from ross_sim.devices.gimbal_manager import HANDLED, SET_ATTITUDE, ArduPilot

HEARTBEAT, SYSTEM_TIME, ATTITUDE, POSITION, TIMESYNC, GIMBAL_STATE = 0, 2, 30, 33, 111, 286  # message ids
PERIODS = {HEARTBEAT: 1.0, SYSTEM_TIME: 1.0, TIMESYNC: 10.0}  # [s], until somebody asks otherwise
ADJUSTABLE = frozenset((SYSTEM_TIME, ATTITUDE, POSITION, GIMBAL_STATE))
MANAGED = (
    gimbal_messages.MANAGER_INFORMATION,
    gimbal_messages.MANAGER_STATUS,
    gimbal_messages.DEVICE_INFORMATION,
    gimbal_messages.DEVICE_ATTITUDE,
)
OF_MANAGER = (*MANAGED, SET_ATTITUDE, mavlink.MAVLINK_MSG_ID_COMMAND_LONG)  # what its gimbal manager says by itself
EARLY = 1e-9  # [s], of rounding
ROTORS = {"esc_telemetry": rotor_speeds.TELEMETRY, "esc_status": (rotor_speeds.STATUS,), "rpm": (rotor_speeds.SENSORS,)}
BOOT = 100.0  # what its clock shows when its life begins here [s]

Rotors = Callable[[], Sequence[float]]  # how fast every rotor turns at this moment [1/s]

TICK = 2 * STEP  # [s] in which it lives
LATENCY, JITTER = 0.001, 0.002  # of the line between gimbal and autopilot [s]
SERVO = Servo(
    lower=math.radians(-202), upper=math.radians(202), max_speed=math.radians(108), max_acceleration=math.radians(225)
)  # a little more than the driver's defaults ask for

URL = "udpin:autopilot:1"  # names the link of the simulated autopilot; nothing is opened
POLL = 0.010  # [s]


@dataclass(slots=True)
class _Plug:
    """One link of the autopilot: its port, its decoder and encoder, and what is due there when."""

    port: Transport
    encoder: Encoder
    periods: dict[int, float]  # [s] by message id
    decoder: Decoder = field(default_factory=Decoder)
    due: dict[int, float] = field(default_factory=dict)

    def ready(self, now: float) -> list[int]:
        """Ids of the messages that are due at ``now`` [s]; what was missed is not made up for."""
        ready = [number for number in self.periods if now >= self.due.get(number, now) - EARLY]
        for number in ready:
            period = self.periods[number]
            missed = math.floor((now - self.due.get(number, now) + EARLY) / period)
            self.due[number] = self.due.get(number, now) + (missed + 1) * period
        return ready


class Autopilot:
    """Component 1 of a vehicle that yaws.

    Parameters
    ----------
    yaw
        How it turns.
    system_id
        Of the vehicle.
    attitude
        Period of ATTITUDE until somebody asks for another one [s].
    boot
        What its clock shows at time 0 [s].
    unix
        UNIX time at time 0 [s]; None: it has no GPS.
    silent
        From when to when it says nothing [s].
    manager
        Of a gimbal, which is on one of its links; None: it has none.
    height
        Above home, where it hovers [m].
    rotors
        Returns how fast every rotor turns at this moment [1/s]; None: it does not know.
    rotor_messages
        Which messages tell that, once somebody has asked for them: a key of `ROTORS`, or "none".
    """

    def __init__(
        self,
        yaw: Yaw,
        *,
        system_id: int = 1,
        attitude: float = 0.25,
        boot: float = BOOT,
        unix: float | None = None,
        silent: Iterable[tuple[float, float]] = (),
        manager: ArduPilot | None = None,
        height: float = 0.0,
        rotors: Rotors | None = None,
        rotor_messages: str = "esc_telemetry",
    ) -> None:
        self._yaw = yaw
        self._height = height
        self._rotors, told = rotors, ROTORS.get(rotor_messages, ())
        groups = -(-len(rotors()) // rotor_speeds.EACH) if rotors is not None else 0
        self._adjustable = ADJUSTABLE | frozenset(told[:groups])
        self._n_rotor_messages = 0  # sent so far
        self._system_id = system_id
        self._periods = PERIODS | {ATTITUDE: attitude}
        self._boot = boot
        self._unix = unix
        self._silent = tuple(silent)
        self._router = RoutingTable(system_id)
        self._manager = manager
        self._plugs: dict[str, _Plug] = {}

    def plug(self, name: str, port: Transport) -> None:
        """Add a link."""
        self._plugs[name] = _Plug(port, Encoder(self._system_id, AUTOPILOT), dict(self._periods))

    def advance(self, now: float) -> None:
        """Hear, pass on and say what is due at ``now`` [s]."""
        for name, plug in self._plugs.items():
            for data in plug.port.receive():
                for packet in plug.decoder.feed(data):
                    way = self._router.way(name, packet)
                    for other in way.links:
                        self._plugs[other].port.send(packet.frame)
                    if way.ours:
                        self._obey(self._plugs[name], packet, now)
        if any(begin <= now < end for begin, end in self._silent):
            return
        for plug in self._plugs.values():
            for number in plug.ready(now):
                self._send(plug, self._message(number, now))
        for message in self._manager.live(now) if self._manager is not None else ():
            if message.get_msgId() in OF_MANAGER:
                for name in self._router.toward(message):
                    self._send(self._plugs[name], message)

    def _obey(self, plug: _Plug, packet: Packet, now: float) -> None:
        message, said = packet.message, vehicle.read(packet.message)
        if isinstance(said, TimeSync) and said.answered is None:
            self._send(plug, vehicle.time_sync(TimeSync(said.asked, round(self._shown(now) * 1e9), packet.sender)))
        elif self._manager is not None and _for_manager(packet):
            for answer in self._manager.on_packet(packet, now):
                self._send(plug, answer)
        elif packet.name in ("COMMAND_LONG", "COMMAND_INT") and message.target_system == self._system_id:
            result = self._command(plug, message, now)
            whom = {"target_system": packet.system_id, "target_component": packet.component_id}
            self._send(plug, mavlink.MAVLink_command_ack_message(message.command, result, **whom))

    def _command(self, plug: _Plug, message: Any, now: float) -> int:
        number = int(message.param1) if math.isfinite(message.param1) else -1
        if message.command == mavlink.MAV_CMD_REQUEST_MESSAGE and number in (*self._adjustable, HEARTBEAT):
            self._send(plug, self._message(number, now))
        elif message.command == mavlink.MAV_CMD_SET_MESSAGE_INTERVAL and number in self._adjustable:
            self._rate(plug, number, message.param2)
        elif message.command == mavlink.MAV_CMD_REQUEST_MESSAGE:
            return int(mavlink.MAV_RESULT_FAILED)
        else:
            return int(mavlink.MAV_RESULT_UNSUPPORTED)
        return int(mavlink.MAV_RESULT_ACCEPTED)

    def _rate(self, plug: _Plug, number: int, interval: float) -> None:
        """Set an interval [us]; 0 means the usual one, -1 never."""
        plug.periods.pop(number, None)
        plug.due.pop(number, None)
        if interval > 0:
            plug.periods[number] = interval / 1e6
        elif interval == 0 and number in self._periods:
            plug.periods[number] = self._periods[number]

    def _message(self, number: int, now: float) -> Any:
        shown = self._shown(now)
        if number == SYSTEM_TIME:
            return vehicle.system_time(SystemTime(shown, None if self._unix is None else self._unix + now))
        if number == TIMESYNC:
            return vehicle.time_sync(TimeSync(round(shown * 1e9)))
        if number == POSITION:
            up = round(self._height * 1e3)
            yaw = round(math.degrees(-self._yaw.at(now)) % 360 * 100) % 36000
            return mavlink.MAVLink_global_position_int_message(round(shown * 1e3) % 2**32, 0, 0, up, up, 0, 0, 0, yaw)
        if number in (ATTITUDE, GIMBAL_STATE):
            at = VehicleAttitude(shown, self._yaw.at(now), 0.0, 0.0, self._yaw.rate(now))
            return vehicle.attitude(at) if number == ATTITUDE else vehicle.gimbal_state(at)
        if number not in (HEARTBEAT, TIMESYNC) and self._rotors is not None:
            return self._rotor_message(number, shown, self._rotors())
        kind, maker = mavlink.MAV_TYPE_QUADROTOR, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA
        return mavlink.MAVLink_heartbeat_message(kind, maker, 1, 0, mavlink.MAV_STATE_STANDBY, 3)

    def _rotor_message(self, number: int, shown: float, speeds: Sequence[float]) -> Any:
        if number == rotor_speeds.STATUS:
            return rotor_speeds.rotor_status(shown, speeds)
        if number == rotor_speeds.SENSORS:
            return rotor_speeds.rotor_sensors(speeds)
        self._n_rotor_messages += 1
        group = rotor_speeds.TELEMETRY.index(number)
        return rotor_speeds.rotor_telemetry(speeds[group * rotor_speeds.EACH :], group, self._n_rotor_messages)

    def _shown(self, now: float) -> float:
        """What its clock shows [s]."""
        return now + self._boot

    def _send(self, plug: _Plug, message: Any) -> None:
        plug.port.send(plug.encoder.encode(message))


def _for_manager(packet: Packet) -> bool:
    """Tell whether something is for the gimbal manager of an autopilot: what gimbals say, and orders for them."""
    if packet.name not in ("COMMAND_LONG", "COMMAND_INT"):
        return packet.name.startswith("GIMBAL_")
    asks = packet.message.command in (mavlink.MAV_CMD_REQUEST_MESSAGE, mavlink.MAV_CMD_SET_MESSAGE_INTERVAL)
    return packet.message.param1 in MANAGED if asks else packet.message.command in HANDLED


class CarriedGimbal:
    """A gimbal device (component 154), its line to the autopilot, and the autopilot's gimbal manager.

    Parameters
    ----------
    clock
        Tells when frames arrive.
    system_id
        Of the vehicle.
    vehicle
        Yaw of the vehicle [rad] at a time [s], counter-clockwise from north.
    up
        For how long the autopilot has been on when the life of the gimbal begins [s].
    """

    def __init__(self, clock: Clock, system_id: int, vehicle: Callable[[float], float], up: float) -> None:
        address = ComponentId(system_id, gimbal_messages.COMPONENTS[0])
        self.device = Device(address, SERVO, vehicle, earth=False)
        self.manager = ArduPilot(ComponentId(system_id, 1), address, SERVO, vehicle, up=up)
        self.port: End
        self.port, self._line = wire(clock, LATENCY, JITTER, seed=0)
        self._encoder, self._decoder = Encoder(*address), Decoder()
        self._ticks = 0

    def advance(self, now: float) -> None:
        """Let the gimbal hear, move and speak until ``now`` [s]."""
        for data in self._line.receive():
            for packet in self._decoder.feed(data):
                self._send(self.device.on_packet(packet, self._ticks * TICK))
        while (self._ticks + 1) * TICK <= now:
            self._ticks += 1
            self.device.move(self._ticks * TICK)
            self._send(self.device.live(self._ticks * TICK))

    def _send(self, messages: list[object]) -> None:
        for message in messages:
            self._line.send(self._encoder.encode(message))
