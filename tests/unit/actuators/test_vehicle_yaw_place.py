"""A PX4 that is sent nowhere which is not known to be its place: what the stream for Offboard says, and when."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest

from ross_protocols.mavlink.vehicle_control import ATTITUDE, GLOBAL_POSITION, HOLD, LOCAL_POSITION, OFFBOARD
from vehicle_rig import Bench

pytestmark = pytest.mark.lockstep


def streamed(bench, seconds):
    """Set-points of the stream in the time to come, as (mode, place, yaw)."""
    sent, send = [], bench.far_end.port.send

    def noted(message):
        if message.get_type() == "SET_POSITION_TARGET_LOCAL_NED":
            sent.append((bench.modes.mode, (message.x, message.y, message.z), math.degrees(message.yaw)))
        send(message)

    bench.far_end.port.send = noted
    bench.clock.sleep(seconds)
    bench.far_end.port.send = send
    return sent


@pytest.fixture
def waiting():
    """A payload that waits for Offboard, which its pilot does not choose."""
    return Bench("hold", wait=0.0, px4_mode="offboard")


def test_the_stream_of_an_idle_payload_keeps_its_rhythm_and_says_where_the_vehicle_is(waiting):
    waiting.clock.sleep(1.5)
    sent = streamed(waiting, 2.0)
    assert len(sent) == pytest.approx(40, abs=2)
    assert {place for _, place, _ in sent} == {(1.0, 2.0, -10.0)}
    waiting.modes.enter(OFFBOARD, waiting.clock.now())
    assert waiting.modes.mode == OFFBOARD


@pytest.mark.parametrize("never", [LOCAL_POSITION, ATTITUDE])
def test_nobody_is_sent_anywhere_while_it_is_not_known_where_the_vehicle_is(waiting, never):
    waiting.far_end.autopilot.withhold(never)
    assert streamed(waiting, 3.0) == []
    waiting.modes.enter(OFFBOARD, waiting.clock.now())
    assert waiting.modes.mode == HOLD  # without a stream a PX4 does not grant it


def test_offboard_of_somebody_else_is_left_alone(waiting):
    waiting.modes.on_set_point(SimpleNamespace(yaw=0.0), 0.0)
    waiting.modes.mode = OFFBOARD
    waiting.clock.every(0.05, lambda: waiting.modes.on_set_point(SimpleNamespace(yaw=0.0), waiting.clock.now()))
    assert streamed(waiting, 3.0) == []
    waiting.actuator.command(math.radians(30))
    waiting.clock.sleep(3.0)
    assert "Offboard began before the place was known, or for another program" in waiting.state.fault
    assert waiting.modes.mode == OFFBOARD


def test_a_place_that_is_no_longer_told_ends_the_stream_before_offboard(waiting):
    waiting.clock.sleep(1.5)
    waiting.far_end.autopilot.withhold(LOCAL_POSITION)
    waiting.clock.sleep(2.0)
    assert streamed(waiting, 1.5) == []
    waiting.modes.enter(OFFBOARD, waiting.clock.now())
    assert waiting.modes.mode == HOLD


def test_in_hold_nobody_is_sent_back_to_the_height_of_a_minute_ago():
    bench = Bench("hold")
    bench.far_end.autopilot.withhold(GLOBAL_POSITION)
    bench.clock.sleep(3.0)
    bench.actuator.command(math.radians(30))
    bench.clock.sleep(3.0)
    assert "does not tell where it is (GLOBAL_POSITION_INT)" in bench.state.fault
    assert bench.yaw_deg == pytest.approx(0.0, abs=0.5)
