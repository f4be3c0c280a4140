"""Steps, edges, segments and the recording port."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ross_payload.actuators.motion import Trapezoid
from ross_payload.actuators.tb6600.pulse_segments import EDGE, Played, PulseLine, RecordingPulses, Segment
from ross_payload.actuators.tb6600.step_edges import LineState, PulseTiming, after, step_times, train
from ross_payload.actuators.wires import open_wire
from ross_payload.errors import ConfigError
from ross_sim.clock import SimClock

STEP = math.radians(0.1125)
INTERFACE = PulseTiming(width=10e-6, setup=20e-6, hold=20e-6, period=1 / 15000)


def test_full_speed_of_the_paper_is_2000_pulses_a_second_at_sixteenth_steps() -> None:
    plan = Trapezoid(0.0, math.radians(900), math.radians(225), math.radians(112.5))
    times, _ = step_times(plan, STEP, 0)
    cruise = times[(times > 2.1) & (times < 3.9)]
    assert 1 / np.diff(cruise) == pytest.approx(2000, rel=1e-6)


def test_a_move_has_as_many_steps_as_microsteps_in_its_distance() -> None:
    times, signs = step_times(Trapezoid(0.0, 800 * STEP, 4.0, 2.0), STEP, 0)
    assert signs.sum() == len(times) == 800


def test_the_first_step_comes_when_half_a_step_has_been_travelled() -> None:
    times, _ = step_times(Trapezoid(0.0, 100 * STEP, 4.0, 2.0), STEP, 0)
    assert times[0] == pytest.approx(math.sqrt(2 * (STEP / 2) / 2.0))


def test_a_reversal_counts_up_and_then_down() -> None:
    _, signs = step_times(Trapezoid(0.0, -10 * STEP, 4.0, 2.0, velocity=0.5), STEP, 0)
    up = math.floor(0.5**2 / (2 * 2.0) / STEP + 0.5)
    assert signs.tolist() == [1] * up + [-1] * (up + 10)


SLOW = PulseTiming(width=10e-6, setup=400e-6, hold=300e-6, period=1 / 15000, up=False)
interfaces = st.sampled_from([INTERFACE, SLOW])


journeys = st.builds(
    Trapezoid, st.just(0.0), st.integers(-3000, 3000).map(lambda n: n * STEP), st.floats(0.1, 4), st.floats(0.5, 100)
)


@given(interfaces, journeys, st.floats(-4, 4), st.sampled_from([-1, 0, 1]))
def test_edges_keep_their_distances_and_end_at_the_goal(
    interface: PulseTiming, plan: Trapezoid, velocity: float, before: int
) -> None:
    laid = train(replace(plan, velocity=velocity), 5.0, LineState(direction=before), interface, STEP)
    rises = _times(laid.edges, PulseLine.STEP, True)
    falls = _times(laid.edges, PulseLine.STEP, False)
    turns = laid.edges["time"][laid.edges["line"] == PulseLine.DIRECTION]
    assert laid.signs.sum() == round(plan.goal / STEP)
    assert np.all(np.diff(laid.edges["time"]) >= 0)
    assert falls - rises == pytest.approx(np.full(len(rises), interface.width), abs=1e-9)
    assert np.all(np.diff(rises) >= interface.period - 1e-9)
    for turn in turns:
        clear = (rises >= turn + interface.setup - 1e-9) | (rises + interface.width <= turn - interface.hold + 1e-9)
        assert turn >= 5.0 - 1e-9
        assert np.all(clear)
    assert after(LineState(), laid.edges, laid.steps, laid.signs, interface).count == laid.signs.sum()


def test_a_reversal_leaves_room_for_hold_and_set_up() -> None:
    """The turning point lies 1e-9 steps beyond a half step, so both crossings would be almost at once."""
    velocity = math.sqrt(2 * 2.0 * STEP * (0.5 + 1e-9))
    laid = train(Trapezoid(0.0, -STEP, 4.0, 2.0, velocity), 0.0, LineState(direction=1), SLOW, STEP)
    turn = laid.edges["time"][laid.edges["line"] == PulseLine.DIRECTION]
    assert laid.signs.tolist() == [1, -1, -1]
    assert turn - (laid.steps[0] + SLOW.width) >= SLOW.hold - 1e-12
    assert laid.steps[1] - turn == pytest.approx(SLOW.setup)


@given(st.integers(-200, 200), st.integers(-200, 200), st.floats(0, 1))
def test_a_plan_replaced_in_flight_ends_on_the_new_goal(first: int, second: int, when: float) -> None:
    plan = Trapezoid(0.0, first * STEP, 1.0, 2.0)
    laid = train(plan, 0.0, LineState(), INTERFACE, STEP)
    cut = when * laid.end
    n, m = np.searchsorted(laid.edges["time"], cut), np.searchsorted(laid.steps, cut)
    wires = after(LineState(), laid.edges[:n], laid.steps[:m], laid.signs[:m], INTERFACE)
    position, velocity = plan.at(cut)
    again = train(Trapezoid(position, second * STEP, 1.0, 2.0, velocity), cut, wires, INTERFACE, STEP)
    assert wires.count + again.signs.sum() == second
    rises = np.concatenate([laid.steps[:m], again.steps])
    assert np.all(np.diff(rises) >= INTERFACE.period - 1e-9)


def test_a_step_waits_for_the_set_up_of_a_turn_already_handed_over() -> None:
    fast = Trapezoid(0.5 * STEP, 10 * STEP, 4.0, 2.0, velocity=1.0)
    laid = train(fast, 1.0, LineState(direction=1, last_turn=1.0 - 1e-6), INTERFACE, STEP)
    assert laid.steps[0] == pytest.approx(1.0 + 19e-6)


def test_a_pulse_that_is_high_when_the_plan_changes_still_ends() -> None:
    here = Trapezoid(0.0, 0.0, 1.0, 1.0)
    laid = train(here, 1.0, LineState(count=1, direction=1, last_step=1.0 - 4e-6), INTERFACE, STEP)
    assert laid.edges["time"] == pytest.approx([1.0 + 6e-6])
    assert not laid.edges["level"].any()


def test_the_recording_port_reports_a_segment_once_when_its_time_is_over() -> None:
    port = RecordingPulses()
    segment = Segment(1.0, 0.02, np.empty(0, dtype=EDGE))
    port.send(segment)
    port.play(1.01)
    assert port.receive() == []
    port.play(1.02)
    assert port.receive() == [Played(1.02)]
    assert port.receive() == []
    assert port.sent == [segment]


def test_a_recording_port_with_a_clock_plays_by_itself() -> None:
    clock = SimClock()
    clock.sleep(2.0)
    port = open_wire("pulses:recording", clock)
    port.send(Segment(1.0, 0.5, np.empty(0, dtype=EDGE)))
    assert port.receive() == [Played(1.5)]


def test_an_unknown_pulse_port_is_an_error_that_names_those_that_exist() -> None:
    there = "pulses:recording, pulses:tcp:HOST:PORT, pulses:lgpio:CHIP:STEP"
    with pytest.raises(ConfigError, match=f"'pulses:gpio17' is unknown; there are: {there}"):
        open_wire("pulses:gpio17", SimClock())


def _times(edges: np.ndarray, line: PulseLine, level: bool) -> np.ndarray:
    times: np.ndarray = edges["time"][(edges["line"] == line) & (edges["level"] == level)]
    return times
