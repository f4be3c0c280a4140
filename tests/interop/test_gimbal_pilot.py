"""A pilot, an autopilot that manages a gimbal, and the payload that uses it, in three processes."""

import statistics
import time
from contextlib import ExitStack

import pytest

from gimbal_flight import ACCEPTED, PAYLOAD, GimbalAutopilot, Pilot
from waiting import wait_for

TURN, STOP, PARK, REARM, HOME = 54003, 54004, 54006, 54009, 54010
ITSELF, NOBODY = -2.0, -3.0
SELF, FREE = (255, 190), (0, 0)
GOING_ON = 5
HELD_UP = ("fault: no data from the autopilot", "fault: no attitude received from the gimbal")


@pytest.fixture(scope="module")
def pilot(living, ground_stations, free_port, noise, tmp_path_factory):
    """A pilot whose payload is idle."""
    folder, ground, port = tmp_path_factory.mktemp("pilot"), ground_stations(), free_port()
    (folder / "ross.toml").write_text(PAYLOAD.format(source=f"file:{noise}", port=port))
    with ExitStack() as stack:
        autopilot = GimbalAutopilot(port, ground.port)
        stack.callback(autopilot.kill)
        payload = stack.enter_context(living(["run", "ross.toml"], folder))
        pilot = Pilot(ground, payload)
        pilot.autopilot = autopilot
        wait_for(lambda: "idle" in payload.lines() and pilot.status())
        yield pilot


def test_a_pilot_turns_the_gimbal_while_the_payload_is_idle(pilot):
    turned(pilot, times=1)


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


@pytest.mark.soak
def test_an_order_from_idle_turns_the_gimbal_soon(pilot):
    """Taking control takes a question and an answer."""
    assert statistics.median(latency(pilot, goal) for goal in (8.0, 0.0) * 5) < 0.25


def latency(pilot, goal):
    """Time from an order until the gimbal has reported a first turn [s]."""
    pilot.ground.rest(1.0)
    here, seen = pilot.yaw(), len(pilot.ground.of("GIMBAL_DEVICE_ATTITUDE_STATUS", 154))
    begin = time.monotonic()
    pilot.ground.command(TURN, goal)
    first = pilot.until(lambda: pilot.moved(here, seen), 5.0)[0]
    assert pilot.reaches(goal, seconds=5.0, within=0.2)
    return first.arrived - begin


def named(pilot, count, words):
    """Wait until the payload tells of a fault, after these many, in these words; none may blame the link."""
    pilot.until(lambda: [line for line in pilot.faults()[count:] if line["message"].startswith(f"fault: {words}")])
    assert not [line for line in pilot.faults()[count:] if "late" in line["message"]]


def test_an_autopilot_that_freezes_in_mid_move_is_named_and_home_brings_all_back(pilot):
    autopilot, before = pilot.autopilot, begin_a_move(pilot)
    autopilot.freeze()
    named(pilot, before, "no data from the autopilot")
    autopilot.go_on()
    pilot.hears_the_payload()
    assert pilot.ground.obeyed(HOME) == ACCEPTED
    assert pilot.ground.obeyed(PARK) == ACCEPTED
    assert pilot.reaches(0.0, within=0.2)
    assert pilot.primary() == FREE


def test_after_a_reboot_of_the_autopilot_in_mid_move_a_rival_stays_in_control_until_an_order(pilot):
    """A killed autopilot is named; one that has rebooted says that nobody is in control."""
    autopilot, before = pilot.autopilot, begin_a_move(pilot)
    autopilot.kill()
    named(pilot, before, "no data from the autopilot")
    autopilot.start()
    pilot.hears_the_payload()
    assert pilot.primary() == FREE
    assert pilot.configure(ITSELF) == ACCEPTED
    pilot.ground.rest(2.0)
    assert pilot.primary() == SELF
    assert pilot.ground.obeyed(REARM) == ACCEPTED
    pilot.ground.rest(0.5)
    assert pilot.primary() == SELF
    assert pilot.ground.obeyed(PARK) == ACCEPTED
    assert pilot.primary() == FREE


def test_a_pilot_who_takes_control_in_mid_move_is_named_and_keeps_it(pilot):
    before = begin_a_move(pilot)
    assert pilot.configure(ITSELF) == ACCEPTED
    named(pilot, before, "component 190 of system 255 has taken control of the gimbal")
    assert pilot.point(50.0) == ACCEPTED
    assert pilot.reaches(50.0)
    assert pilot.primary() == SELF
    assert pilot.configure(NOBODY) == ACCEPTED
    assert pilot.ground.obeyed(REARM) == ACCEPTED
    assert pilot.ground.obeyed(PARK) == ACCEPTED


def test_a_stop_while_idle_brakes_what_the_pilot_turns_and_takes_no_control(pilot):
    park(pilot)
    assert pilot.point(150.0) == ACCEPTED
    pilot.until(lambda: pilot.yaw() > 20.0)
    assert pilot.ground.obeyed(STOP) == ACCEPTED
    pilot.ground.rest(1.5)
    assert pilot.yaw() < 120.0
    assert pilot.primary() == FREE
    assert pilot.point(10.0) == ACCEPTED
    assert pilot.reaches(10.0)
    assert pilot.ground.obeyed(REARM) == ACCEPTED


def park(pilot):
    """Have the payload turn to 0, after what goes on, and give the gimbal back: until then its set-points count."""
    pilot.until(lambda: pilot.ground.obeyed(PARK) == ACCEPTED)
    pilot.until(lambda: pilot.primary() == FREE)


def begin_a_move(pilot):
    """Order a long turn, wait until it is going on, and return how many faults were told before.

    What a computer that had no time for the autopilot ends before it begins is ordered again.
    """
    while True:
        park(pilot)
        before, acks = len(pilot.faults()), len(pilot.ground.of("COMMAND_ACK"))

        def against(before=before, acks=acks):
            answers = [ack.result for ack in pilot.ground.of("COMMAND_ACK")[acks:] if ack.command == TURN]
            return [line["message"] for line in pilot.faults()[before:]], [one for one in answers if one != GOING_ON]

        pilot.ground.command(TURN, 85.0)
        pilot.until(lambda: pilot.yaw() > 5.0 or any(against()), what=against)
        if pilot.yaw() > 5.0:
            return before
        faults, answers = against()
        assert all(fault.startswith(HELD_UP) for fault in faults)
        assert faults, answers
        pilot.hears_the_payload()
        assert pilot.ground.obeyed(HOME) == ACCEPTED
