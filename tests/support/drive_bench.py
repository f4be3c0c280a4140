"""A guarded CANopen drive on a simulated bus, and every frame that the driver has sent."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from ross_payload.actuators.registry import checked_options, open_actuator
from ross_payload.config import Config
from ross_payload.errors import LinkError
from ross_payload.interfaces import ActuatorState, Services
from ross_protocols.can import CanFrame
from ross_protocols.canopen.cia402 import State
from ross_protocols.canopen.frames import Item
from ross_sim.clock import QUANTUM, SimClock
from ross_sim.devices.canopen_far_end import far_end

NODE, OWN = 5, 127
OPENING = 0.8  # in which a drive is set up [s]


class Wire:
    """The driver's end of the bus, which can lose frames and be told what to bring."""

    def __init__(self, port: Any, clock: SimClock) -> None:
        self._port, self._clock = port, clock
        self.sent: list[tuple[float, CanFrame]] = []
        self.brought: list[CanFrame] = []
        self.passes: Callable[[CanFrame], bool] = lambda frame: True
        self.down = False

    def send(self, frame: CanFrame) -> None:
        self.sent.append((self._clock.now(), frame))
        if self.passes(frame):
            self._port.send(frame)

    def receive(self) -> list[CanFrame]:
        if self.down:
            raise LinkError("the bus is down")
        arrived, self.brought = self._port.receive() + self.brought, []
        return [frame for frame in arrived if self.passes(frame)]

    def close(self) -> None:
        self._port.close()


class Bench:
    """A guarded driver and its drive; ``every`` is how often it is polled [s]."""

    def __init__(
        self, guard: dict[str, Any] | None = None, angle: float = 0.0, every: float = QUANTUM, **options: Any
    ) -> None:
        actuator = {"kind": "canopen_drive", "options": options}
        config = Config.model_validate({"actuator": actuator, "guard": guard or {}})
        self.options = checked_options(config)
        self.clock = SimClock()
        self.far_end = far_end.make(self.options, math.radians(angle))
        self.drive = self.far_end.node
        self.clock.before_calls(self.far_end.advance)
        self.wire = Wire(self.far_end.port, self.clock)
        self.actuator = open_actuator(config, Services(self.clock, lambda url: self.wire))
        self.cancel = self.clock.every(every, lambda: self.actuator.poll(self.clock.now()))

    def open(self) -> Bench:
        self.actuator.__enter__()
        self.clock.sleep(OPENING)
        return self

    def close(self) -> None:
        self.actuator.__exit__(None, None, None)

    def go(self, degrees: float, seconds: float = 0.0, rate: float | None = None) -> None:
        self.actuator.command(math.radians(degrees), None if rate is None else math.radians(rate))
        self.clock.sleep(seconds)

    def settle(self, within: float = 8.0) -> None:
        end = self.clock.now() + within
        while not self.state.settled:
            assert self.clock.now() < end, self.state
            self.clock.sleep(QUANTUM)

    def home(self, within: float = 30.0) -> None:
        self.actuator.home()
        end = self.clock.now() + within
        while not self.state.homed or not self.state.settled:
            assert self.clock.now() < end, self.state
            self.clock.sleep(QUANTUM)

    def set(self, item: Item, value: int) -> None:
        """Change what the drive has."""
        self.drive.objects[item] = value

    def frames(self, identifier: int, since: float = -math.inf) -> list[bytes]:
        return [frame.data for time, frame in self.wire.sent if frame.id == identifier and time >= since]

    @property
    def state(self) -> ActuatorState:
        return self.actuator.state()

    @property
    def fault(self) -> str:
        return self.state.fault

    @property
    def drive_state(self) -> State:
        return self.drive.axis.state

    @property
    def true_deg(self) -> float:
        return math.degrees(self.far_end.angle())
