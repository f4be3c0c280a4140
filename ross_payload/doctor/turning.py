"""Checks of what turns the array; it is made, never opened: nothing moves."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NoReturn

from ross_payload.actuators.registry import checked_options, describe, open_actuator
from ross_payload.config import Config
from ross_payload.doctor.finding import Finding, fail, ok, warn
from ross_payload.doctor.machine import Machine
from ross_payload.errors import ActuatorError, RossError
from ross_payload.interfaces import Capabilities, Clock, Services

NOWHERE = "pulses:recording"  # the wire that ends in memory


def actuator(config: Config, machine: Machine, clock: Clock) -> Iterator[Finding]:
    """Whether the back end is there, its options are right, and its limits let the array reach every axis."""
    kind = config.actuator.kind
    try:
        capabilities = open_actuator(config, Services(clock, _closed)).capabilities
    except RossError as error:
        yield fail("actuator", str(error), "see `ross actuators` and docs/reference/configuration")
        return
    origin = next((row.origin for row in describe() if row.name == kind), "")
    if getattr(checked_options(config), "port", "") == NOWHERE:
        yield warn("actuator", f"{kind} keeps its pulses in memory: nothing will turn", "name a wire: options.port")
    elif origin.startswith("ross_sim."):
        yield warn("actuator", f"{kind} is simulated: nothing will turn", "choose another actuator.kind")
    else:
        yield ok("actuator", f"{kind}, feedback {capabilities.feedback}")
    yield from _travel(config, capabilities)


def start(config: Config, machine: Machine) -> Iterator[Finding]:
    """Whether something turns without being asked."""
    if config.service.autostart == "nothing":
        yield ok("autostart", "nothing turns until it is commanded")
    else:
        found = f"'{config.service.autostart}' at every start, also after a crash, unless it was stopped by a command"
        yield warn("autostart", found, "service.autostart = 'nothing', where people may stand near the array")


def _closed(url: str) -> NoReturn:
    raise ActuatorError(f"the doctor does not open wires, got '{url}'")


def _travel(config: Config, capabilities: Capabilities) -> Iterator[Finding]:
    """An array of two microphones has an axis and no front: half a turn reaches every alignment."""
    travel = capabilities.upper - capabilities.lower
    found = f"{math.degrees(travel):.0f} deg of travel"
    if travel < math.pi - 1e-6:
        todo = "widen guard.lower_deg and upper_deg to 180 deg in all, or some alignments are out of reach"
        yield warn("limits", found, todo)
    else:
        yield ok("limits", f"{found}: every axis can be reached")
    longest = _duration(travel, capabilities)
    if longest > config.guard.max_move_s:
        todo = "raise guard.max_move_s, or the longest move ends as a fault"
        yield fail("limits", f"the longest move takes {longest:.1f} s, max_move_s = {config.guard.max_move_s:g}", todo)


def _duration(angle: float, capabilities: Capabilities) -> float:
    """Rest to rest along a trapezoid [s]: angle / v + v / a, or 2 sqrt(angle / a) when v is never reached."""
    speed, acceleration = capabilities.max_speed, capabilities.max_acceleration
    if angle < speed**2 / acceleration:
        return 2 * math.sqrt(angle / acceleration)
    return angle / speed + speed / acceleration
