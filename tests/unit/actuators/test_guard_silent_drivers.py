"""Drivers that never answer, that end the program, or that have no capabilities: a stop reaches them all the same."""

from __future__ import annotations

import math
import threading
from typing import Any

import pytest

from guard_bench import Device, bench
from ross_payload import config
from ross_payload.actuators.guard import Guard
from ross_payload.errors import ActuatorFault, ConfigError, LinkError
from ross_payload.interfaces import ActuatorState
from ross_sim.clock import SimClock

FAST = f"{math.radians(225):.2f}"


class Shared(Device):
    def take_control(self) -> None:
        self._ask("take", "take")

    def release_control(self) -> bool:
        self._ask("give", "give")
        return True

    def brake(self) -> None:
        self._ask("brake", "brake")


@pytest.mark.parametrize(("device", "stop"), [(Device(), ["stop"]), (Shared(), ["stop", "brake"])])
def test_a_stop_reaches_a_driver_that_does_not_say_where_it_is(device: Device, stop: list[str]) -> None:
    on, told = bench(device), threading.Event()
    on.guard.command(1.0)
    now = on.device.now

    def waits() -> ActuatorState:
        told.wait()
        return now

    on.device.state = waits  # type: ignore[method-assign]
    stopping = threading.Thread(target=on.guard.stop, daemon=True)
    stopping.start()
    stopping.join(0.2)
    assert on.device.asked == [f"go 1.00 at {FAST}", *stop]
    told.set()
    stopping.join()


@pytest.mark.parametrize("method", ["stop", "brake"])
@pytest.mark.parametrize("error", [ZeroDivisionError("bug"), LinkError("gone"), SystemExit("no licence")])
def test_a_stop_of_what_others_turn_never_raises_and_is_tried_again(method: str, error: BaseException) -> None:
    on = bench(Shared())
    on.device.raises[method] = error  # type: ignore[assignment]
    on.guard.stop()
    assert on.guard.state().fault.startswith("the stop failed: ")
    assert on.device.asked == [{"stop": "brake", "brake": "stop"}[method]]
    on.device.raises.clear()
    on.device.asked.clear()
    on.clock.sleep(0.1)
    assert on.device.asked == {"stop": ["stop"], "brake": ["stop", "brake"]}[method]
    on.guard.rearm()
    on.guard.halt()
    assert on.device.asked[-1] == "stop", "what others turn is told of a stop alone"


@pytest.mark.parametrize("error", [ZeroDivisionError("bug"), LinkError("gone")])
def test_control_that_cannot_be_taken_or_given_is_a_fault(error: Exception) -> None:
    on = bench(Shared())
    on.device.raises["take"] = error
    on.guard.take_control()
    assert not on.guard.state().healthy
    on.device.raises = {"give": error}
    on.guard.rearm()
    on.guard.release_control()
    assert not on.guard.state().healthy
    on.device.raises = {}
    on.guard.rearm()
    on.guard.release_control()
    assert on.device.asked[-1] == "give"


@pytest.mark.parametrize("method", ["state", "stop", "poll", "capabilities"])
def test_a_driver_that_ends_the_program_is_a_fault_and_a_stop_reaches_it(method: str) -> None:
    class Leaving(Device):
        left = ""

        def __getattribute__(self, name: str) -> Any:
            if name != "left" and name == self.left:
                raise SystemExit("no licence")
            return super().__getattribute__(name)

    device = Leaving()
    on = bench(device)
    on.guard.command(1.0)
    device.left = method
    on.guard.stop()
    on.clock.sleep(0.1)
    assert "SystemExit('no licence')" in on.guard.state().fault
    device.left = ""
    on.clock.sleep(0.1)
    assert device.asked[-1] == "stop"


def test_capabilities_that_are_none_are_a_fault_as_long_as_they_are_none() -> None:
    on = bench()
    able, on.device.capabilities = on.device.capabilities, None  # type: ignore[assignment]
    with pytest.raises(ActuatorFault, match="the driver broke: AttributeError"):
        on.guard.command(1.0)
    on.device.capabilities = able
    on.clock.sleep(0.1)
    on.guard.rearm()
    on.guard.command(1.0)
    assert on.device.asked[-1] == f"go 1.00 at {FAST}"


def test_a_driver_that_opens_as_what_none_can_use_is_closed() -> None:
    class Unfit(Device):
        def __enter__(self) -> Device:
            self.capabilities = None  # type: ignore[assignment]
            return self

    device = Unfit()
    with pytest.raises(ConfigError, match="the driver broke: AttributeError"):
        Guard(device, config.Guard(), SimClock()).__enter__()
    assert device.asked == ["close"]
