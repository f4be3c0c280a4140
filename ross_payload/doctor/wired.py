"""The wires of an actuator, without the rest of the payload."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

from ross_payload.actuators.mavlink_gimbal.port import SCHEME, opener
from ross_payload.actuators.registry import checked_options
from ross_payload.clock import SystemClock
from ross_payload.config import Config
from ross_payload.interfaces import Services
from ross_payload.links import Links
from ross_payload.service.folders import state_folder

POLL = 0.010  # [s]


@contextmanager
def wired(config: Config) -> Iterator[Services]:
    """Give real time and real wires; the links are opened when the actuator is behind them.

    Raises
    ------
    RossError
        When a link cannot be opened.
    """
    clock = SystemClock()
    used = config.links if getattr(checked_options(config), "port", "") == SCHEME else ()
    with ExitStack() as stack:
        state = state_folder(config) if used else None
        links = stack.enter_context(Links.open(used, clock, system_id=config.telemetry.system_id, state=state))
        if used:
            stack.callback(clock.every(POLL, links.poll))
        yield Services(clock, opener(links, config.telemetry.component_id, clock))
