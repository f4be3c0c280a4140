"""A rig around a real device: in real time, and with nothing but its own reports to tell where it is."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from rigs import CuttableWire, Rig
from ross_payload.actuators.guard import Guard
from ross_payload.actuators.registry import open_actuator
from ross_payload.config import load
from ross_payload.doctor.probe import open_services
from ross_payload.interfaces import Port
from ross_payload.service.runner import POLL_PERIOD_S
from ross_sim.devices.far_end import Fault

OPENING = 2.0  # of what boots when it is opened [s]
TIMEOUT_FACTOR = 4.0  # times that of the simulated


class Believed:
    """Stands for a far end that nobody sees: it is where it says."""

    faults: frozenset[Fault] = frozenset()

    def __init__(self, port: Port, actuator: Guard) -> None:
        self.port = port
        self._actuator = actuator

    def advance(self, now: float) -> None:
        """It lives by itself."""

    def angle(self) -> float:
        return self._actuator.state().angle

    def afflict(self, fault: Fault, on: bool = True) -> None:
        raise ValueError("a real device is broken by hand")

    def complaints(self) -> list[str]:
        return []


@contextmanager
def device_rig(file: Path) -> Iterator[Rig]:
    """Open the actuator of a payload's file, and bring it to its zero."""
    config, wire = load(file), CuttableWire()
    with open_services(config) as services:

        def open_port(url: str) -> Port:
            wire.plug(services.open_port(url))
            return wire

        actuator = open_actuator(config, replace(services, open_port=open_port))
        cancel = services.clock.every(POLL_PERIOD_S, lambda: actuator.poll(services.clock.now()))
        speed = actuator.capabilities.max_speed
        rig = Rig(services.clock, Believed(wire, actuator), wire, actuator, speed=speed, opening=OPENING)
        rig.patience = TIMEOUT_FACTOR
        try:
            rig.open()
            actuator.command(0.0)
            rig.settle(within=5.0)
            yield rig
        finally:
            cancel()
            actuator.__exit__(None, None, None)
