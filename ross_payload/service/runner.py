"""The runner: read a hop, send an Input, obey the Output.

Audio is read late and asks where the array pointed when it was captured: reports of the actuator are kept.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from queue import SimpleQueue
from typing import Protocol

from ross_payload.actuators.guard import Guard
from ross_payload.computing import computing
from ross_payload.config import Config
from ross_payload.errors import ActuatorError
from ross_payload.events import Event
from ross_payload.interfaces import ActuatorState, AudioSource, Clock, Input, Mission, Mount, Output, Result
from ross_payload.orders import Cancel, Order, Shutdown, Stop
from ross_payload.pointing import BaseRate, Pointing
from ross_payload.transport.async_task import drained

POLL_PERIOD_S = 0.010  # [s] of the pump
ROUNDING_S = 1e-9  # [s], of rounding
EXTRAPOLATION_S = 0.1  # [s] beyond the newest report that its rate is trusted
MOST = 20_000  # reports kept at least, of the newest: more than three minutes of the pump
REST_TIMEOUT_S = 10.0  # [s] of audio that a decelerating motor may take at the end


class Observer(Protocol):
    """Watches a mission: telemetry, recorders, live views."""

    def on_input(self, hop: Input) -> None:
        """One hop was heard."""

    def on_event(self, event: Event, hop: Input) -> None:
        """The mission said something; this is the first hop after it."""


class OrderLog(Protocol):
    """Remembers orders beyond the end of this process."""

    def ordered(self, order: Order) -> None:
        """Note an order; from any thread, never waits."""


class JointHistory:
    """The latest reports of an actuator; written by the pump, read by the mission's thread.

    >>> history = JointHistory()
    >>> for time, angle in ((0.0, 0.0), (1.0, 0.5)):
    ...     history.note(ActuatorState(angle, 0.5, settled=False, homed=True, healthy=True, time=time))
    >>> history.angle(0.5), history.angle(1.1)
    (0.25, 0.55)
    """

    def __init__(self) -> None:
        self._kept: tuple[list[float], list[ActuatorState]] = ([], [])  # times [s] and reports; only ever appended to

    def note(self, report: ActuatorState) -> None:
        """Keep a report; one of the same time as the last one takes its place."""
        times, reports = self._kept
        if times and report.time <= times[-1]:
            reports[-1] = report
            return
        if len(times) >= 2 * MOST:  # others may be reading the old lists
            self._kept = times, reports = times[-MOST:], reports[-MOST:]
        reports.append(report)
        times.append(report.time)

    def angle(self, time: float) -> float | None:
        """Return the joint angle [rad] at ``time`` [s], interpolated; None when nothing was ever reported."""
        times, reports = self._kept
        count = len(times)
        if not count:
            return None
        after = bisect_right(times, time, 0, count)
        if after == count:
            newest = reports[count - 1]
            return newest.angle + newest.rate * min(time - times[count - 1], EXTRAPOLATION_S)
        if after == 0 or times[after - 1] == -math.inf:  # heard before the first report, which tells where it stood
            return reports[after].angle
        share = (time - times[after - 1]) / (times[after] - times[after - 1])
        return reports[after - 1].angle + share * (reports[after].angle - reports[after - 1].angle)

    def settled(self, begin: float, end: float) -> bool:
        """Tell whether all reports from ``begin`` to ``end`` [s], the last one before and the first after say settled.

        What is read late has a report after it: motion that began in between is seen there first.
        """
        times, reports = self._kept
        count = len(times)
        first = max(bisect_right(times, begin, 0, count) - 1, 0)
        last = min(bisect_left(times, end, 0, count), count - 1)
        return count > 0 and all(report.settled for report in reports[first : last + 1])


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
        self._rest_hops = math.ceil(REST_TIMEOUT_S * source.rate / config.hop)
        self._orders: SimpleQueue[Order] = SimpleQueue()
        self._stopping = False  # a stop is on its way to the mission
        self._braking = False  # a stop or a cancel is
        self._history = JointHistory()
        self._base_rate = BaseRate()
        self._asked = -math.inf  # when the last goal was given [s]: what was heard before knows nothing of it
        self._fault = ""
        self._slipped = 0.0  # [rad] that the reported joint angle is ahead of the true one
        self.observers: list[Observer] = []

    def order(self, order: Order) -> None:
        """Ask for something, from any thread or signal handler; a stop takes effect before the mission hears of it."""
        if isinstance(order, (Stop, Shutdown)):
            self._stopping = self._braking = True
            self._actuator.stop()
        elif isinstance(order, Cancel):
            self._braking = True
            self._actuator.halt()
        try:
            if self._latch is not None:  # after the brakes: no disk delays them
                self._latch.ordered(order)
        finally:
            self._orders.put(order)  # a mission that never hears of a stop takes itself for turning

    def poll(self) -> None:
        """Poll the actuator and remember where it is."""
        self._actuator.poll(self._clock.now())
        self._history.note(self._actuator.state())

    def located(self, begin: float, end: float) -> tuple[Pointing, bool]:
        """Return where the array pointed at ``end`` [s] on the Clock, and whether it was at rest since ``begin``.

        From any thread: it may be asked before the mission has heard what was heard then.
        """
        attitude, offset = self._mount.attitude(end), self._offset - self._slipped
        joint = self._joint(end, self._actuator.state())
        return Pointing(end, joint, attitude.yaw, offset, earth=attitude.known), self._history.settled(begin, end)

    def run(self) -> Result:
        """Run the mission to its end and the actuator to rest, `computing` on the thread that calls this."""
        with computing():
            result = self._run()
        self._rest()
        return result

    def _run(self) -> Result:
        output = next(self._mission)
        try:
            while True:
                self._move(output)
                hop = self._listen(output.goal)
                for event in output.events:
                    for observer in self.observers:
                        observer.on_event(event, hop)
                output = self._mission.send(hop)
        except StopIteration as end:
            result: Result = end.value
            return result
        except BaseException:
            self._actuator.stop()
            raise

    def _listen(self, goal: float | None) -> Input:
        block = self._source.read(self._hop)
        end = block.time + self._hop / self._source.rate
        state = self._actuator.state()
        braking = self._braking  # what it was sent to was refused or forgotten, and is not reached
        still = goal is None and block.time >= self._asked - ROUNDING_S and state.settled and not braking
        attitude, after = self._mount.attitude(block.time), self._mount.attitude(end)
        if after.known != attitude.known:  # one hop is in one frame
            after = attitude
        orders = tuple(drained(self._orders))
        if any(isinstance(order, (Stop, Shutdown)) for order in orders):
            self._stopping = False
        if any(isinstance(order, (Stop, Shutdown, Cancel)) for order in orders):
            self._braking = False
        pointing = Pointing(
            time=end,
            joint=self._joint(end, state),
            base=after.yaw,
            offset=self._offset - self._slipped,
            earth=after.known,
            base_rate=self._base_rate.update(end, after.yaw, earth=after.known),
        )
        hop = Input(
            block=block,
            heading_start=attitude.yaw + self._joint(block.time, state) + pointing.offset,
            pointing=pointing,
            settled=still and self._history.settled(block.time, end),
            attitude=attitude,
            fault=self._fault or ("" if state.healthy else state.fault or "the actuator reports a fault"),
            orders=orders,
        )
        for observer in self.observers:
            observer.on_input(hop)
        return hop

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
                self._actuator.command(output.goal, output.rate)
                self._asked = self._clock.now()  # not before: the pump may have noted a report meanwhile
        except ActuatorError as error:
            if not (self._actuator.stopped and self._stopping):  # else the mission is about to hear of the stop
                self._fault = str(error)

    def _rest(self) -> None:
        """Keep hearing until the motor stands still, so that what is recorded includes its deceleration."""
        for _ in range(self._rest_hops):
            if self._actuator.state().rate == 0.0:
                return
            self._listen(None)

    def _joint(self, time: float, state: ActuatorState) -> float:
        angle = self._history.angle(time)
        return state.angle if angle is None else angle
