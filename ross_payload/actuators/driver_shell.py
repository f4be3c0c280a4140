"""What every driver does alike: requests cross threads, the pump obeys them and publishes a state, closing brakes.

A `DriverShell` is the actuator that the guard sees. It owns a `Driver`, which knows one kind of device and nothing of
threads: only the pump calls it. `DriverBackend` is what an entry point of ``ross_payload.actuators`` names.
"""

from __future__ import annotations

import logging
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from enum import Enum
from queue import SimpleQueue
from typing import Annotated, Any, Self

from pydantic import Field

from ross_payload.errors import ActuatorFault, LimitError, LinkError, NotHomed, TimeStandsStill
from ross_payload.interfaces import Actuator, ActuatorState, Capabilities, Clock, Feedback, Port, Services
from ross_payload.transport.async_task import drained

CLOSING_PERIOD_S = 0.010  # between two polls while a device comes to rest before it is closed
HELD_UP_S = 0.1  # longer between two polls, and this program, or its computer, was held up [s]
MAX_CATCH_UP_S = 0.5  # so long at most what is simulated here may take to make up for a pause [s]
TIME_TOLERANCE_S = 1e-6  # so much before its time something is due, for every driver
NodeId = Annotated[int, Field(ge=1, le=127)]  # on a CAN bus, for CANopen and DroneCAN
log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Move:
    """Go to an angle."""

    goal: float  # [rad]
    rate: float  # [rad/s]


class Request(Enum):
    """Requests without arguments."""

    HALT = "halt"
    HOME = "home"
    RELEASE = "release"
    TAKE_CONTROL = "take control"
    RELEASE_CONTROL = "release control"
    BRAKE = "decelerate a motion of another controller"


class Driver(ABC):
    """One kind of device on its wire, with defaults for what few need.

    After `open`, a poll is `read`, `obey` for every request, `write`, `snapshot`.
    """

    capabilities: Capabilities
    forgets_zero = False  # whether `home` and `release` make the position unknown at once
    plays_on = False  # whether what was sent before it was closed goes on, and the state with it

    @property
    def identity(self) -> str:
        """What the device says of itself; empty while it has not."""
        return ""

    def goal(self, angle: float) -> float:
        """Return the joint angle [rad] nearest to ``angle`` that the device can be sent to.

        Raises
        ------
        LimitError
            When the device itself does not allow it.
        """
        return angle

    @abstractmethod
    def open(self, port: Port, now: float) -> None:
        """Begin on a port; nothing moves."""

    @abstractmethod
    def read(self, now: float) -> None:
        """Take in what has arrived, and what is wrong with it."""

    @abstractmethod
    def obey(self, request: Move | Request, now: float) -> None:
        """Begin what is asked for."""

    def write(self, now: float) -> None:  # noqa: B027  # some devices are told all in `obey`
        """Go on with what is under way: send what is due."""

    @abstractmethod
    def snapshot(self, now: float) -> ActuatorState:
        """Return the state at ``now`` [s]."""

    def link_lost(self, error: LinkError) -> bool:
        """Take in that the wire has failed; tell whether that is all, and requests that wait are void."""
        return False

    def leave(self, clock: Clock) -> Iterable[None]:
        """Begin to come to rest for good, and yield as long as that needs polls."""
        return ()

    @abstractmethod
    def close(self) -> None:
        """Give the wire back."""


def wait(clock: Clock, duration: float) -> None:
    """Wait [s] while a device comes to rest, also when a periodic call of somebody else has failed.

    Raises
    ------
    TimeStandsStill
        As in a simulation that has failed: nothing comes to rest any more.
    """
    begin = clock.now()
    try:
        clock.sleep(duration)
    except RuntimeError as error:
        if clock.now() <= begin:
            raise TimeStandsStill(str(error)) from error


class DriverShell:
    """An actuator made of a `Driver`: what is asked of it waits in a queue, and only `poll` acts.

    Parameters
    ----------
    driver : Driver
        Of the device.
    services : Services
        Clock and wires.
    url : str
        Of the wire.
    """

    def __init__(self, driver: Driver, services: Services, url: str) -> None:
        self._driver = driver
        self._services = services
        self._url = url
        self._requests: SimpleQueue[Move | Request] = SimpleQueue()
        self._is_open = False
        self._zero_given_up = False  # by a request that waits
        self._state = ActuatorState(0.0, 0.0, settled=False, homed=False, healthy=True, time=-math.inf)

    @property
    def capabilities(self) -> Capabilities:
        """Travel, speed, acceleration, resolution, feedback."""
        return self._driver.capabilities

    @property
    def identity(self) -> str:
        """What the device says of itself; empty while it has not, and while it is closed."""
        return self._driver.identity if self._is_open else ""

    def command(self, angle: float, rate: float | None = None) -> None:
        """Go to a joint angle [rad], at most at ``rate`` [rad/s]; replaces the goal."""
        able, state = self.capabilities, self.state()
        if not (math.isfinite(angle) and able.lower <= angle <= able.upper):
            raise LimitError(f"goal {math.degrees(angle):.2f} deg is outside the travel")
        if not state.healthy:
            raise ActuatorFault(state.fault or "the device has not reported yet")
        if not (self._is_open and state.homed):
            raise NotHomed("the zero is not known: home first")
        self._requests.put(Move(self._driver.goal(angle), min(rate or math.inf, able.max_speed)))

    def state(self) -> ActuatorState:
        """Return the state at the last poll; not settled while a request waits, nor homed if it gives up the zero."""
        if self._requests.empty():
            return self._state
        return replace(self._state, settled=False, homed=self._state.homed and not self._zero_given_up)

    def stop(self) -> None:
        """Decelerate to rest; the next poll begins it."""
        self._requests.put(Request.HALT)

    def home(self) -> None:
        """Clear a fault, and find or declare the zero where the device does not know it."""
        self._zero_given_up = self._driver.forgets_zero
        self._requests.put(Request.HOME)

    def release(self) -> None:
        """Remove the torque, where the device can."""
        self._zero_given_up = self._driver.forgets_zero
        self._requests.put(Request.RELEASE)

    def poll(self, now: float) -> None:
        """Read the wire, obey requests, send what is due, publish the state at ``now`` [s]."""
        if not self._is_open:
            self._state = self._driver.snapshot(now) if self._driver.plays_on else self._state
            return
        try:
            self._driver.read(now)
            for request in drained(self._requests):
                self._driver.obey(request, now)
                self._zero_given_up = self._zero_given_up and request not in (Request.HOME, Request.RELEASE)
            self._driver.write(now)
        except LinkError as error:
            if not self._driver.link_lost(error):
                raise
            list(drained(self._requests))
        finally:
            self._state = self._driver.snapshot(now)

    def __enter__(self) -> Self:
        """Open the wire; nothing moves, and no report made before counts."""
        self._driver.open(self._services.open_port(self._url), self._services.clock.now())
        self._state = replace(self._state, settled=False, homed=False, healthy=True, time=-math.inf, fault="")
        self._is_open = True
        return self

    def __exit__(self, *error: object) -> None:
        """Come to rest, which may take its time, and close the wire; requests that wait are dropped; idempotent."""
        if not self._is_open:
            return
        clock = self._services.clock
        list(drained(self._requests))
        try:
            for n, _ in enumerate(self._driver.leave(clock)):
                if n:
                    wait(clock, CLOSING_PERIOD_S)
                self.poll(clock.now())
        except LinkError as lost:
            log.warning("%s", lost)
        finally:
            self._is_open = False
            self._driver.close()


@dataclass(frozen=True)
class DriverBackend:
    """A back end whose options name their wire ``port``."""

    about: str  # in a list of back ends
    Config: type[Any]  # of [actuator.options]
    driver: Callable[[Any], Driver]  # of such options
    shell: Callable[[Any, Services, str], Actuator] = DriverShell  # of such a driver, its services and its wire

    def open(self, config: Any, services: Services) -> Actuator:
        """Make the actuator; nothing moves."""
        return self.shell(self.driver(config), services, config.port)


def capabilities_of(
    options: Any, resolution: float, feedback: Feedback, *, endless: bool = False, finds_zero: bool = False
) -> Capabilities:
    """Return what options with caps in degrees, and ends of the travel unless it is endless, ask of a device.

    Parameters
    ----------
    options : Any
        With ``max_speed_deg_s`` and ``max_acceleration_deg_s2``, and ``lower_deg`` and ``upper_deg`` unless endless.
    resolution : float
        [rad].
    """
    return Capabilities(
        lower=-math.inf if endless else math.radians(options.lower_deg),
        upper=math.inf if endless else math.radians(options.upper_deg),
        max_speed=math.radians(options.max_speed_deg_s),
        max_acceleration=math.radians(options.max_acceleration_deg_s2),
        resolution=resolution,
        continuous=endless,
        feedback=feedback,
        finds_zero=finds_zero,
    )


def check_geared_node(options: Any) -> None:
    """Refuse ends of a travel, ids on a CAN bus, or a gear that cannot be.

    Raises
    ------
    ValueError
        Which of them, and its value.
    """
    if options.lower_deg >= options.upper_deg:
        raise ValueError(f"expected lower_deg below upper_deg, got {options.lower_deg:g} and {options.upper_deg:g}")
    if options.node_id == options.own_node_id:
        raise ValueError(f"node_id and own_node_id are both {options.node_id}")
    if abs(options.gear_ratio) < 0.001:
        raise ValueError(f"gear_ratio = {options.gear_ratio:g} is too near to 0")
