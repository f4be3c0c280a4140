"""The runner: read a hop, send an Input, obey the Output."""

from __future__ import annotations

import math
from queue import Empty, SimpleQueue
from typing import Protocol

from ross_payload.actuators.guard import Guard
from ross_payload.config import Config
from ross_payload.errors import ActuatorError
from ross_payload.events import Event
from ross_payload.interfaces import ActuatorState, AudioSource, Clock, Input, Mission, Mount, Output, Result
from ross_payload.orders import Cancel, Order, Shutdown, Stop
from ross_payload.service.history import JointHistory

EARLY = 1e-9  # [s], of rounding
REST_TIMEOUT = 10.0  # [s] of audio that a decelerating motor may take at the end


class Observer(Protocol):
    """Watches a mission: telemetry, recorders, live views."""

    def heard(self, heard: Input) -> None:
        """One hop was heard."""

    def said(self, event: Event, heard: Input) -> None:
        """The mission said something; this is the first hop after it."""


class OrderLog(Protocol):
    """Remembers orders beyond the end of this process."""

    def ordered(self, order: Order) -> None:
        """Note an order; from any thread, never waits."""


class Runner:
    """Drives one mission with real or simulated parts; every order passes through it within one hop.

    `run` belongs to the mission's thread, `poll` to the pump, `order` to anybody.
    """

    def __init__(
        self,
        mission: Mission,
        source: AudioSource,
        actuator: Guard,
        mount: Mount,
        *,
        config: Config,
        clock: Clock,
        latch: OrderLog | None = None,
    ) -> None:
        self._mission = mission
        self._source = source
        self._actuator = actuator
        self._mount = mount
        self._clock = clock
        self._latch = latch
        self._hop = config.hop
        self._offset = config.offset
        self._rest_hops = math.ceil(REST_TIMEOUT * source.rate / config.hop)
        self._orders: SimpleQueue[Order] = SimpleQueue()
        self._history = JointHistory()
        self._asked = -math.inf  # when the last goal was given [s]: what was heard before knows nothing of it
        self._fault = ""
        self._slipped = 0.0  # [rad] that the reported joint angle is ahead of the true one
        self.observers: list[Observer] = []

    def order(self, order: Order) -> None:
        """Ask for something, from any thread or signal handler; a stop takes effect before the mission hears of it."""
        if isinstance(order, (Stop, Shutdown)):
            self._actuator.stop()
        elif isinstance(order, Cancel):
            self._actuator.halt()
        if self._latch is not None:  # after the brakes: no disk delays them
            self._latch.ordered(order)
        self._orders.put(order)

    def poll(self) -> None:
        """Poll the actuator and remember where it is."""
        self._actuator.poll(self._clock.now())
        self._history.note(self._actuator.state())

    def run(self) -> Result:
        """Run the mission to its end and the actuator to rest."""
        output = next(self._mission)
        try:
            while True:
                self._move(output)
                heard = self._listen(output.goal)
                self._tell(output, heard)
                output = self._mission.send(heard)
        except StopIteration as end:
            result: Result = end.value
        except BaseException:
            self._actuator.stop()
            raise
        self._rest()
        return result

    def _listen(self, goal: float | None) -> Input:
        block = self._source.read(self._hop)
        end = block.time + self._hop / self._source.rate
        state = self._actuator.state()
        joint = self._joint(end, state)
        still = goal is None and block.time >= self._asked - EARLY and state.settled
        attitude, after = self._mount.attitude(block.time), self._mount.attitude(end)
        if after.known != attitude.known:  # one hop is in one frame
            after = attitude
        offset = self._offset - self._slipped
        heard = Input(
            block=block,
            heading_start=attitude.yaw + self._joint(block.time, state) + offset,
            heading_end=after.yaw + joint + offset,
            joint=joint,
            settled=still and self._history.settled(block.time, end),
            attitude=attitude,
            fault=self._fault or ("" if state.healthy else state.fault or "the actuator reports a fault"),
            orders=self._drain(),
        )
        for observer in self.observers:
            observer.heard(heard)
        return heard

    def _move(self, output: Output) -> None:
        """Obey an Output; what cannot be obeyed is a fault until the payload is re-armed."""
        if output.stop:
            self._actuator.stop()
        if output.halt:
            self._actuator.halt()
        if output.hold is not None:
            (self._actuator.take_control if output.hold else self._actuator.release_control)()
        try:
            if output.rearm:
                self._fault = ""
                self._actuator.rearm()
            if output.slipped is not None and not self._actuator.capabilities.finds_zero:
                self._slipped += output.slipped
            elif output.home or output.slipped is not None:
                self._slipped = 0.0
                self._actuator.home()
            if output.goal is not None:
                self._asked = self._clock.now()
                self._actuator.command(output.goal, output.rate)
        except ActuatorError as error:
            if not (self._actuator.stopped and self._orders.qsize()):  # else the mission is about to hear of the stop
                self._fault = str(error)

    def _tell(self, output: Output, heard: Input) -> None:
        for event in output.events:
            for observer in self.observers:
                observer.said(event, heard)

    def _rest(self) -> None:
        """Keep hearing until the motor stands still, so that what is recorded includes its deceleration."""
        for _ in range(self._rest_hops):
            if self._actuator.state().rate == 0.0:
                return
            self._listen(None)

    def _joint(self, time: float, state: ActuatorState) -> float:
        angle = self._history.angle(time)
        return state.angle if angle is None else angle

    def _drain(self) -> tuple[Order, ...]:
        orders = []
        try:
            while True:
                orders.append(self._orders.get_nowait())
        except Empty:
            return tuple(orders)
