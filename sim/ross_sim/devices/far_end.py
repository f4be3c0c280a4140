"""What stands at the far end of an actuator's wire: the simulated device and the mechanics behind it."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace
from enum import StrEnum
from typing import Any, Protocol

import numpy as np

from ross_payload import plugins
from ross_payload.actuators.registry import checked_options
from ross_payload.config import Config
from ross_payload.errors import PluginError, RossError
from ross_payload.interfaces import Clock, Port
from ross_payload.transport.ports import Counts


class Fault(StrEnum):
    """What a simulated device can be made to suffer from."""

    STALL = "stall"  # the motor loses its torque while turning; the load comes to rest
    STUCK = "stuck"  # the bearing is blocked
    SLIP = "slip"  # the load slips by 10 deg on its shaft, once; a sensor on the motor side does not see it
    NOISY = "noisy"  # the sensor is noisy by several degrees
    SILENT = "silent"  # it sends nothing any more, and continues as commanded
    REBOOT = "reboot"  # it reboots, once
    TAKEN = "taken"  # another controller commands it
    SATURATED = "saturated"  # other nodes saturate the bus
    DUPLICATE = "duplicate"  # another node on the bus uses an id that is taken
    CORRUPT = "corrupt"  # what it sends arrives damaged
    PILOT = "pilot"  # the pilot pushes the yaw stick for half a second
    MODE = "mode"  # the pilot chooses a flight mode in which only the stick turns the vehicle
    DISARMED = "disarmed"  # the vehicle is disarmed on the ground
    LANDED = "landed"  # the vehicle stands on the ground, armed


OF_VEHICLES = frozenset((Fault.PILOT, Fault.MODE, Fault.DISARMED, Fault.LANDED))  # what happens to vehicles that fly
OF_DEVICES = frozenset(Fault) - OF_VEHICLES

SLIP = math.radians(10)  # [rad]


class WireEnd:
    """The payload's end of an in-process wire, a `Port`: what it sends waits for the far end."""

    def __init__(self) -> None:
        self.sent: list[Any] = []
        self.arrived: list[Any] = []

    def send(self, frame: Any) -> None:
        """Send one frame."""
        self.sent.append(frame)

    def receive(self) -> list[Any]:
        """Return what has arrived since the last call."""
        arrived, self.arrived = self.arrived, []
        return arrived

    def close(self) -> None:
        """Return at once: an in-process wire holds nothing."""


class FarEnd(Protocol):
    """A simulated device with real dynamics; it knows where it *is*, not where it was told to be."""

    port: Port  # the payload's end of the wire
    faults: frozenset[Fault]  # those that make sense here

    def advance(self, now: float) -> None:
        """Let the device and its mechanics live until ``now`` [s]."""

    def angle(self) -> float:
        """Return the true joint angle [rad] at the time of the last ``advance``."""

    def afflict(self, fault: Fault, on: bool = True) -> None:
        """Let a fault begin, or end: any time between two advances.

        Raises
        ------
        ValueError
            When it makes no sense here.
        """

    def complaints(self) -> list[str]:
        """Return what went wrong so far, in words: steps lost, timing violated; empty when all is well."""


class FarEndPlugin(Protocol):
    """The object behind an entry point in ``ross_sim.far_ends``, under the same name as the actuator back end."""

    def make(self, config: Any) -> FarEnd:
        """Make the far end that fits a back end's ``Config``."""


def far_end_of(config: Config) -> FarEnd:
    """Make the simulated device for the actuator that a configuration names.

    Raises
    ------
    ConfigError
        When there is none, or an option is wrong.
    """
    options = checked_options(config)
    kind = config.actuator.kind
    plugin: FarEndPlugin = plugins.load("ross_sim.far_ends", kind)
    try:
        return plugin.make(options)
    except RossError:
        raise
    except Exception as error:  # of a plug-in: it may raise anything
        raise PluginError(f"far end '{kind}': make raised {error!r}") from error


def checked(fault: Fault, faults: frozenset[Fault]) -> Fault:
    """Return a fault that is among ``faults``.

    Raises
    ------
    ValueError
        When it is not.
    """
    if fault not in faults:
        raise ValueError(f"fault: expected one of {', '.join(sorted(faults)) or 'none'}, got '{fault}'")
    return fault


class End:
    """One end of the wire: a port of the router, or of a simulated autopilot."""

    def __init__(self, clock: Clock, latency: float, jitter: float, generator: np.random.Generator) -> None:
        self._clock = clock
        self._latency = latency
        self._jitter = jitter
        self._generator = generator
        self._other = self
        self._coming: deque[tuple[float, bytes]] = deque()  # when it arrives [s], what
        self.counts = Counts()

    def join(self, other: End) -> None:
        """Lead to another end, and back."""
        self._other, other._other = other, self

    def send(self, frame: bytes) -> None:
        """Send one frame; none overtakes another."""
        due = self._clock.now() + self._latency + self._jitter * self._generator.random()
        coming = self._other._coming
        coming.append((max(due, coming[-1][0]) if coming else due, frame))
        self.counts = replace(self.counts, sent=self.counts.sent + 1)

    def receive(self) -> list[bytes]:
        """Return what has arrived."""
        arrived, now = [], self._clock.now()
        while self._coming and self._coming[0][0] <= now:
            arrived.append(self._coming.popleft()[1])
        self.counts = replace(self.counts, received=self.counts.received + sum(map(len, arrived)))
        return arrived

    def close(self) -> None:
        """Return at once: an in-process wire holds nothing."""


def wire(clock: Clock, latency: float, jitter: float, seed: int) -> tuple[End, End]:
    """Make a wire that delays by ``latency`` [s] at least and up to ``jitter`` [s] more; return both its ends."""
    one, other = (
        End(clock, latency, jitter, np.random.Generator(np.random.PCG64(own)))
        for own in np.random.SeedSequence(seed).spawn(2)  # what one says does not change how the other is delayed
    )
    one.join(other)
    return one, other
