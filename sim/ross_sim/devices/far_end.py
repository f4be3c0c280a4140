"""What stands at the far end of an actuator's wire: the simulated device and the mechanics behind it."""

from __future__ import annotations

import math
from enum import StrEnum
from typing import Any, Protocol

from ross_payload import plugins
from ross_payload.actuators.registry import checked_options
from ross_payload.config import Config
from ross_payload.interfaces import Port


class Fault(StrEnum):
    """What a simulated device can be made to suffer from."""

    STALL = "stall"  # the motor loses its torque while it turns; what it turned comes to rest
    STUCK = "stuck"  # the bearing is blocked
    SLIP = "slip"  # what turns slips on its shaft by 10 deg, once; a sensor on the motor's side sees nothing of it
    NOISY = "noisy"  # the sensor trembles by degrees
    SILENT = "silent"  # it says nothing any more, and goes on as it was told
    REBOOT = "reboot"  # it boots, once
    TAKEN = "taken"  # another controller commands it
    SATURATED = "saturated"  # others fill the bus
    DUPLICATE = "duplicate"  # somebody else on the bus has an id that is taken
    CORRUPT = "corrupt"  # what it says arrives damaged


SLIP = math.radians(10)  # [rad]


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
    plugin: FarEndPlugin = plugins.load("ross_sim.far_ends", config.actuator.kind)
    return plugin.make(options)


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
