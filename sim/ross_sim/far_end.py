"""What stands at the far end of an actuator's wire: the simulated device and the mechanics behind it."""

from __future__ import annotations

from typing import Any, Protocol

from ross_payload import plugins
from ross_payload.actuators.registry import checked_options
from ross_payload.config import Config
from ross_payload.interfaces import Port


class FarEnd(Protocol):
    """A simulated device with real dynamics; it knows where it *is*, not where it was told to be."""

    port: Port  # the payload's end of the wire

    def advance(self, now: float) -> None:
        """Let the device and its mechanics live until ``now`` [s]."""

    def angle(self) -> float:
        """Return the true joint angle [rad] at the time of the last ``advance``."""

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
    plugin: FarEndPlugin = plugins.load("ross_sim.far_ends", config.actuator.kind)
    return plugin.make(checked_options(config))
