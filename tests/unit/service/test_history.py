"""Where the array pointed in the past, from the reports of its actuator."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ross_payload.interfaces import ActuatorState
from ross_payload.service.runner import MOST, JointHistory


def report(time, angle, *, rate=0.0, settled=True):
    return ActuatorState(angle, rate, settled, homed=True, healthy=True, time=time)


def kept(*reports):
    history = JointHistory()
    for one in reports:
        history.note(one)
    return history


def test_nothing_is_known_before_the_first_report():
    assert JointHistory().angle(1.0) is None
    assert not JointHistory().settled(0.0, 1.0)


def test_an_angle_between_two_reports_is_interpolated():
    history = kept(report(1.0, 0.0), report(1.1, 0.2), report(1.2, 1.0))
    assert history.angle(1.05) == pytest.approx(0.1)
    assert history.angle(1.15) == pytest.approx(0.6)


def test_before_the_first_report_the_array_was_where_it_says():
    assert kept(report(5.0, 0.7)).angle(1.0) == 0.7


def test_an_actuator_that_has_reported_nothing_yet_stood_where_its_first_report_says():
    """What is heard while it is looked for waits in the buffer, and asks later where the array pointed."""
    history = kept(report(-math.inf, 0.0, settled=False), report(5.0, 0.7))
    assert history.angle(1.0) == 0.7
    assert not history.settled(1.0, 1.01)


def test_the_newest_rate_is_trusted_for_a_tenth_of_a_second():
    history = kept(report(1.0, 0.5, rate=2.0))
    assert history.angle(1.05) == pytest.approx(0.6)
    assert history.angle(9.0) == pytest.approx(0.7)


def test_of_two_reports_of_one_time_the_later_holds():
    assert kept(report(1.0, 0.5), report(1.0, 0.6)).angle(1.0) == 0.6


def test_a_hop_is_settled_when_every_report_around_it_is():
    history = kept(report(1.0, 0.0), report(1.1, 0.0, settled=False), report(1.2, 0.0), report(1.3, 0.0))
    assert not history.settled(1.15, 1.16)  # the report before it says that it still turns
    assert history.settled(1.2, 1.25)
    assert history.settled(1.31, 1.32)
    assert not history.settled(1.05, 1.15)


def test_a_hop_that_ends_with_a_report_of_motion_is_not_settled():
    history = kept(report(1.0, 0.0), report(1.01, 0.0, settled=False), report(1.02, 0.001, settled=False))
    assert not history.settled(1.0, 1.01)
    assert not history.settled(1.0, 1.005)
    assert history.settled(0.98, 1.0)


def test_old_reports_are_forgotten_and_the_newest_minutes_are_not():
    history = kept(*(report(0.01 * k, float(k)) for k in range(3 * MOST)))
    assert history.angle(0.01 * (3 * MOST - 1)) == 3 * MOST - 1
    assert history.angle(0.01 * (2 * MOST + 5)) == pytest.approx(2 * MOST + 5)
    assert history.angle(0.0) > 0  # long gone


@given(st.lists(st.tuples(st.floats(0, 100), st.floats(-4, 4)), min_size=1, max_size=30), st.floats(-10, 110))
def test_an_angle_never_lies_outside_what_was_reported(pairs, time):
    reports = [report(t, angle) for t, angle in sorted(pairs)]
    angles = [one.angle for one in reports]
    assert min(angles) - 1e-9 <= kept(*reports).angle(time) <= max(angles) + 1e-9
