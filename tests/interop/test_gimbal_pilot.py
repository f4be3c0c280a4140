"""A pilot, an autopilot that manages a gimbal, and the payload that uses it, in three processes."""

import statistics
import time
from contextlib import ExitStack

import pytest

from gimbal_flight import ACCEPTED, PAYLOAD, GimbalAutopilot, Pilot

TURN, STOP, PARK, REARM, HOME = 54003, 54004, 54006, 54009, 54010
ITSELF, NOBODY = -2.0, -3.0
SELF, FREE = (255, 190), (0, 0)


@pytest.fixture(scope="module")
def pilot(living, ground_stations, free_port, until, noise, tmp_path_factory):  # noqa: PLR0917
    """A pilot whose payload is idle."""
    folder, ground, port = tmp_path_factory.mktemp("pilot"), ground_stations(), free_port()
    (folder / "ross.toml").write_text(PAYLOAD.format(source=f"file:{noise}", port=port))
    with ExitStack() as stack:
        autopilot = GimbalAutopilot(port, ground.port)
        stack.callback(autopilot.kill)
        payload = stack.enter_context(living(["run", "ross.toml"], folder))
        pilot = Pilot(ground, payload, until)
        pilot.autopilot = autopilot
        until(lambda: "idle" in payload.lines() and pilot.status())
        yield pilot


def test_a_pilot_turns_the_gimbal_while_the_payload_is_idle(pilot):
    turned(pilot, times=3)


@pytest.mark.soak
def test_a_pilot_turns_the_gimbal_20_of_20_times_while_the_payload_is_idle(pilot):
    turned(pilot, times=20)


def turned(pilot, times):
    missed = []
    for n in range(times):
        goal = -50.0 if n % 2 else 50.0
        assert pilot.point(goal) == ACCEPTED
        if not pilot.reaches(goal):
            missed.append((goal, pilot.yaw()))
    assert missed == []
    pilot.until(lambda: abs(pilot.heading() - pilot.yaw()) < 0.5)
    assert pilot.faults() == []
    assert pilot.ground.obeyed(PARK) == ACCEPTED
    assert pilot.reaches(0.0, seconds=5.0, within=0.2)
    assert pilot.primary() == FREE


def test_an_order_from_idle_turns_the_gimbal_soon(pilot):
    """Taking control takes a question and an answer."""
    assert statistics.median(latency(pilot, goal) for goal in (8.0, 0.0, 8.0, 0.0, 8.0)) < 0.5


def latency(pilot, goal):
    """Time from an order until the gimbal has reported a first turn [s]."""
    pilot.ground.rest(1.0)
    here, seen = pilot.yaw(), len(pilot.ground.of("GIMBAL_DEVICE_ATTITUDE_STATUS", 154))
    begin = time.monotonic()
    pilot.ground.command(TURN, goal)
    first = pilot.until(lambda: pilot.moved(here, seen), 5.0)[0]
    assert pilot.reaches(goal, seconds=5.0, within=0.2)
    return first.arrived - begin
